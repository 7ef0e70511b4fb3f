"""Options of scripts that read their own arguments, found in their source without running them."""

import ast
import os

from commands.paths import read


def declare(parser, script):
    """Declares a script's options, so that help and completion tell what it really takes.

    Args:
        parser: Gets each option that the script declares with add_argument().
        script: Path of a Python file.
    """
    for call in ast.walk(ast.parse(read(script))):
        if isinstance(call, ast.Call) and getattr(call.func, "attr", "") == "add_argument":
            flags = [value for value in map(_constant, call.args) if value]
            given = {keyword.arg: _constant(keyword.value) for keyword in call.keywords}
            if flags and flags[0].startswith("-"):
                kinds = {name: given[name] for name in ("nargs", "metavar") if given.get(name)}
                if str(given.get("action")).startswith("store_"):
                    kinds = {"action": "store_true"}
                parser.add_argument(*flags, help=given.get("help") or "", **kinds)


def keys(script, name):
    """Lists the keys of a dict that a script assigns to a name.

    Args:
        script: Path of a Python file.
        name: The dict's name.
    """
    if not os.path.exists(script):
        return []
    for node in ast.parse(read(script)).body:
        targets = [getattr(target, "id", "") for target in getattr(node, "targets", [])]
        if name in targets and isinstance(node.value, ast.Dict):
            return [key.value for key in node.value.keys]
    return []


def _constant(node):
    return node.value if isinstance(node, ast.Constant) else None

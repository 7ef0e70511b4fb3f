"""Engines hand nothing on to another object that has a method of the same name (mypy holds that
both have all of engine/api.py)."""

import ast
from pathlib import Path

from bullet_sim.engine import api

FOLDER = Path(api.__file__).parent


def is_super(node):
    return isinstance(node, ast.Call) and getattr(node.func, "id", "") == "super"


def handed_on(path):
    """Methods that do nothing but call a method of the same name of another object."""
    for kind in (n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.ClassDef)):
        for method in (node for node in kind.body if isinstance(node, ast.FunctionDef)):
            *_, last = method.body
            value = getattr(last, "value", None)
            is_short = len(method.body) - bool(ast.get_docstring(method)) == 1
            if is_short and isinstance(value, ast.Call) and isinstance(value.func, ast.Attribute):
                if value.func.attr == method.name and not is_super(value.func.value):
                    yield f"{path.name}: {kind.name}.{method.name}"


def test_no_method_hands_on_to_one_of_the_same_name():
    found = [name for path in sorted(FOLDER.rglob("*.py")) for name in handed_on(path)]
    assert [name for name in found if not name.endswith(".close")] == []

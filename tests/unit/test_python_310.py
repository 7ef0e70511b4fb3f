"""What Python 3.10 cannot read and vermin does not see: regular expressions of later versions."""

import ast
import re
import subprocess
import sys

import pytest
from run_rig import ROOT

FUNCTIONS = (
    "compile",
    "match",
    "search",
    "fullmatch",
    "sub",
    "subn",
    "split",
    "findall",
    "finditer",
)
# (?>...) and possessive quantifiers, which compile from Python 3.11
LATER = ("ATOMIC_GROUP", "POSSESSIVE_REPEAT", "POSSESSIVE_REPEAT_ONE")


def expressions(text):
    """Yields (line, expression) of the literal arguments of re's functions."""
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            continue
        if getattr(node.func.value, "id", None) != "re" or node.func.attr not in FUNCTIONS:
            continue
        if node.args and isinstance(node.args[0], ast.Constant):
            yield node.lineno, node.args[0].value


def operations(parsed):
    """Yields the names of the operations in a parsed expression."""
    if isinstance(parsed, (list, tuple)) or hasattr(parsed, "data"):
        for part in getattr(parsed, "data", parsed):
            yield from operations(part)
    else:
        yield str(parsed)


def later(expression):
    """Whether an expression needs a later Python."""
    try:
        parsed = getattr(re, "_parser", None) or __import__("sre_parse")
        return bool(set(LATER).intersection(operations(parsed.parse(expression))))
    except re.error:
        return True


@pytest.mark.parametrize("expression, expected", [
    ("a++", True), ("(a|b)*+c", True), ("(?>a)", True), ("x(?:y(z?+))", True),
    ("a+", False), (r"(?P<n>[+]+)\++", False), (rb"a*b+?", False),
])  # fmt: skip
def test_such_an_expression_is_found(expression, expected):
    assert later(expression) == expected
    found = list(expressions(f"import re\n\nre.compile({expression!r}, re.MULTILINE)\n"))
    assert found == [(3, expression)]


def test_none_is_in_the_sources():
    files = subprocess.run(
        [sys.executable, "-m", "ruff", "check", "--show-files"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout.split()  # fmt: skip
    sources = [path for path in files if not path.endswith((".toml", ".ipynb", ".pyi"))]
    count, found = 0, []
    for path in sources:
        with open(path, encoding="utf-8") as stream:
            text = stream.read()
        for line, expression in expressions(text):
            count += 1
            if later(expression):
                found.append(f"{path}:{line}: {expression!r}")
    assert found == [] and count > 50

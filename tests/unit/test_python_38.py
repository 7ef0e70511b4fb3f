"""What Python 3.8 cannot run and vermin does not see.

Regular expressions, methods of values whose types it does not know, and generic types, unions
and starred items outside annotations and parentheses.
"""

import ast
import re
import subprocess
import sys
from pathlib import Path

from run_rig import ROOT

FUNCTIONS = "compile match search fullmatch sub subn split findall finditer".split()
# (?>...) and possessive quantifiers, which compile from Python 3.11
LATER = ("ATOMIC_GROUP", "POSSESSIVE_REPEAT", "POSSESSIVE_REPEAT_ONE")
METHODS = "removeprefix removesuffix bit_count is_relative_to with_stem hardlink_to".split()
BUILTINS = ("bool", "bytes", "dict", "float", "frozenset", "int")
BUILTINS += ("list", "set", "str", "tuple", "type")
GENERIC = re.compile(
    "(collections[.](abc[.])?|contextlib[.]|queue[.]|weakref[.]|subprocess[.]|os[.])"
    "([A-Z][a-z]|deque|defaultdict|ref)|re[.](Pattern|Match)$"
)


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


class Evaluated(ast.NodeVisitor):
    """Finds what is evaluated and needs a later Python; annotations are not, with the import.

    Attributes:
        found: List of (line, text).
        expressions: List of (line, regular expression) of the literal arguments of re's functions.
    """

    def __init__(self, tree):
        self.found, self.expressions, self._generic = [], [], set(BUILTINS)
        self._postponed = False
        self.visit(tree)

    def visit_ImportFrom(self, node):  # noqa: N802
        self._postponed |= node.module == "__future__"
        self._generic.update(
            each.asname or each.name
            for each in node.names
            if GENERIC.match(f"{node.module}.{each.name}")
        )

    def visit_Call(self, node):  # noqa: N802
        function = node.func
        if isinstance(function, ast.Attribute) and function.attr in FUNCTIONS and node.args:
            if getattr(function.value, "id", None) == "re":
                if isinstance(node.args[0], ast.Constant):
                    self.expressions.append((node.lineno, node.args[0].value))
        self.generic_visit(node)

    def _add(self, node):
        self.found.append((node.lineno, ast.dump(node)[:100]))

    def visit_AnnAssign(self, node):  # noqa: N802
        self._parts(node, "annotation")

    def visit_arg(self, node):
        self._parts(node, "annotation")

    def visit_FunctionDef(self, node):  # noqa: N802
        self._parts(node, "returns")

    visit_AsyncFunctionDef = visit_FunctionDef

    def _parts(self, node, annotation):
        for name, value in ast.iter_fields(node):
            if name == annotation and self._postponed:
                continue
            for part in value if isinstance(value, list) else [value]:
                if isinstance(part, ast.AST):
                    self.visit(part)

    def visit_Subscript(self, node):  # noqa: N802
        if isinstance(node.ctx, ast.Load) and self._is_generic(node.value):
            self._add(node)
        self.generic_visit(node)

    def _is_generic(self, node):
        if isinstance(node, ast.Attribute):
            return bool(GENERIC.match(f"{getattr(node.value, 'id', '')}.{node.attr}"))
        return isinstance(node, ast.Name) and node.id in self._generic

    def visit_BinOp(self, node):  # noqa: N802
        if isinstance(node.op, ast.BitOr) and any(map(self._unites, (node.left, node.right))):
            self._add(node)
        self.generic_visit(node)

    def visit_For(self, node):  # noqa: N802
        self._starred(node.iter)
        self.generic_visit(node)

    def _starred(self, node):
        """Find a, *b without parentheses where Python 3.8 wants them."""
        if isinstance(node, ast.Tuple) and any(isinstance(e, ast.Starred) for e in node.elts):
            if node.col_offset == node.elts[0].col_offset:
                self._add(node)

    def visit_AugAssign(self, node):  # noqa: N802
        self._starred(node.value)
        if isinstance(node.op, ast.BitOr) and self._is_dict(node.value):
            self._add(node)
        self.generic_visit(node)

    def _unites(self, node):
        """Whether a value is a type, None, or a dictionary, which | joins from Python 3.9 on."""
        if isinstance(node, ast.Constant):
            return node.value is None
        if isinstance(node, ast.Name):
            return node.id in self._generic or bool(re.match("[A-Z][a-z]", node.id))
        return self._is_dict(node)

    def _is_dict(self, node):
        is_call = isinstance(node, ast.Call) and getattr(node.func, "id", "") == "dict"
        return is_call or isinstance(node, (ast.Dict, ast.DictComp))

    def visit_Attribute(self, node):  # noqa: N802
        if node.attr in METHODS:
            self._add(node)
        self.generic_visit(node)


def sources():
    """Yields (path, text) of all Python that ruff checks."""
    files = subprocess.run(
        [sys.executable, "-m", "ruff", "check", "--show-files"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout.split()  # fmt: skip
    for path in files:
        if not path.endswith((".toml", ".ipynb", ".pyi")):
            with open(path, encoding="utf-8") as stream:
                yield path, stream.read()


def test_methods_that_older_test_cases_figures_and_images_lack():
    """What needs the class of an object to be known, which nothing here looks up."""
    newer = re.compile(  # Python 3.11; matplotlib 3.5; Pillow 9.1, for constants of Image itself
        r"\.enter(Class)?Context\(|\blayout=[\"']|\bImage\.(Transpose|Resampling|Transform)\b"
    )
    found = [
        f"{path}: {line}"
        for path, text in sources()
        for line in text.splitlines()
        if newer.search(line) and newer.pattern not in line
    ]
    assert found == []


def test_no_file_that_can_be_imported_by_its_name_alone_is_named_as_a_standard_module():
    """Python 3.8 looks for `site` in PYTHONPATH, too, where a test may have put any folder."""
    standard = getattr(sys, "stdlib_module_names", ())  # from Python 3.10 on
    loose = [Path(path) for path, _ in sources()]
    loose = [path for path in loose if not (path.parent / "__init__.py").exists()]
    assert [path for path in loose if path.stem in standard] == [] and len(loose) > 100


def test_none_is_in_the_sources():
    count, found = 0, []
    for path, text in sources():
        evaluated = Evaluated(ast.parse(text))
        found += [f"{path}:{line}: {what}" for line, what in evaluated.found]
        for line, expression in evaluated.expressions:
            count += 1
            if later(expression):
                found.append(f"{path}:{line}: {expression!r}")
    assert found == [] and count > 50

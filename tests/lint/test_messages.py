"""Messages are made with all fields by position or some by keyword: genpy takes nothing else."""

import ast
import importlib
from pathlib import Path

from commands.bootstrap import workspace

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = (*(f"src/{name}" for name in workspace.OURS), "commands", "tests", "bench")


def sources():
    """Python files of the repository, nodes without an ending among them."""
    below = [path for name in FOLDERS for path in sorted((ROOT / name).rglob("*"))]
    for path in below:
        if path.suffix == ".py" or (
            not path.suffix and path.is_file() and path.read_bytes().startswith(b"#!")
        ):
            text = path.read_text(encoding="utf-8")
            if path.suffix == ".py" or "python" in text.partition("\n")[0]:
                yield path, text


def message_classes(tree):
    """Name in the file -> class, of what it imports from packages of messages that are there."""
    classes = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").endswith((".msg", ".srv")):
            try:
                module = importlib.import_module(node.module)
            except ImportError:
                continue
            classes.update({a.asname or a.name: getattr(module, a.name) for a in node.names})
    return classes


def refused_calls(text):
    """Yields (line, text) of the calls that end with a TypeError of genpy."""
    tree = ast.parse(text)
    classes = message_classes(tree)
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name):
            continue
        slots = getattr(classes.get(node.func.id), "__slots__", None)
        if slots is None or not node.args or any(isinstance(a, ast.Starred) for a in node.args):
            continue
        if node.keywords or len(node.args) != len(slots):
            yield node.lineno, ast.get_source_segment(text, node)


def test_no_call_is_refused():
    calls = 0
    for path, text in sources():
        calls += bool(message_classes(ast.parse(text)))
        for line, call in refused_calls(text):
            raise AssertionError(f"{path.relative_to(ROOT)}:{line}: {call}")
    assert calls > 50

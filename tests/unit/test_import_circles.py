"""Holds that no modules import each other in a circle, at their top, in functions or for types."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = "bench", "commands", "docs", "src", "tests"


def modules_of(files):
    """Gives the modules that files are, by the folders from which they are imported.

    Args:
        files: paths of *.py below the root, relative to it.

    Returns:
        Mapping of folder -> mapping of dotted name -> path; a package's name stands for its
        __init__.py.
    """
    found = {}
    for path in files:
        root = import_root(path)
        name = re.sub(r"\.__init__$", "", ".".join(path.relative_to(root).with_suffix("").parts))
        found.setdefault(root, {})[name] = path
    return found


def import_root(path):
    """Gives the folder from which a file is imported: src of a catkin package, commands' parent,
    else the nearest one in which it and the packages around it are no package's."""
    folders = path.parent.parts
    if folders[:1] == ("src",) and "src" in folders[1:]:
        last = len(folders) - folders[::-1].index("src")
        return Path(*folders[:last])
    if folders[:1] == ("commands",):
        return Path()
    root = path.parent
    while (ROOT / root / "__init__.py").is_file():
        root = root.parent
    return Path("bench") if folders[:1] == ("bench",) else root


def imported_names(text, package):
    """Lists the dotted names that a source text imports, wherever it does.

    Args:
        package: dotted name of the package that the text is a module of, for relative imports;
            empty: these begin with a dot.

    Returns:
        (name, line) of modules, and of what may be one: of `from a import b` it is a.b.
    """
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            stem = [node.module] if node.module else []
            if node.level:
                parts = package.split(".")
                stem = [*parts[: len(parts) - node.level + 1], *stem]
            names = [".".join([*stem, alias.name]) for alias in node.names]
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            called = getattr(node.func, "attr", getattr(node.func, "id", ""))
            is_import = called in ("import_module", "__import__")
            names = [node.args[0].value] if is_import else []
        else:
            continue
        found += [(name, node.lineno) for name in names if isinstance(name, str)]
    return found


def graph_of(modules, text_of):
    """Gives what each file imports.

    The __init__.py of a package that is imported from counts, too, but for the packages that the
    importing module is in.

    Args:
        modules: see modules_of().
        text_of: function of a path to the file's text.

    Returns:
        Mapping of path -> set of paths.
    """
    shared = {
        name: path for root, names in modules.items() if root.parts[:1] == ("src",)
        and root.name == "src" for name, path in names.items()
    }  # fmt: skip
    graph = {}
    for names in modules.values():
        known = {**shared, **names}
        for name, path in names.items():
            package = name if path.name == "__init__.py" else name.rpartition(".")[0]
            graph[path] = targets = set()
            around = {".".join(name.split(".")[:n]) for n in range(1, name.count(".") + 1)}
            for imported, _ in imported_names(text_of(path), package):
                parts = imported.split(".")
                ways = [".".join(parts[:n]) for n in range(1, len(parts) + 1)]
                inner = [way for way in ways if way in known]
                targets |= {known[way] for way in inner if way not in around}
                if inner and inner[-1] in around and ways[-2:-1] == inner[-1:]:
                    targets.add(known[inner[-1]])  # something that its package defines
            targets.discard(path)
    return graph


def in_circles(graph):
    """Lists the nodes on circles, and between two: what is left when all ends are taken off."""
    graph = {node: set(targets) for node, targets in graph.items()}
    while True:
        entered = set().union(*graph.values()) if graph else set()
        ends = {node for node, targets in graph.items() if not targets or node not in entered}
        if not ends:
            return sorted(graph)
        graph = {node: graph[node] - ends for node in graph.keys() - ends}


def python_files():
    """Lists the checkout's *.py files, relative to it."""
    found = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")]
    return sorted(path.relative_to(ROOT) for path in found if "__pycache__" not in path.parts)


def test_no_modules_import_each_other_in_a_circle():
    graph = graph_of(modules_of(python_files()), lambda path: (ROOT / path).read_text())
    assert [str(path) for path in in_circles(graph)] == []

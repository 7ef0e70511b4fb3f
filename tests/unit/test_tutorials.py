"""What the tutorials name exists: commands, launch files and arguments, nodes, links."""

import ast
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "tutorials"))

import page as tutorial  # noqa: E402
import typed  # noqa: E402


def test_there_are_pages():
    names = [path.stem for path in tutorial.PAGES]
    assert len(names) == 10
    index = tutorial.links(ROOT / "docs" / "tutorials" / "README.md")
    own = sorted(target for target in index if not target.startswith(".."))
    assert own == [f"{name}.md" for name in names]


@pytest.mark.parametrize("path", tutorial.PAGES, ids=lambda path: path.stem)
def test_commands_exist(path):
    lines = tutorial.commands(path)
    assert any(line.startswith("./run") for line in lines)
    for line in lines:
        try:
            typed.check(line)
        except Exception as error:
            raise AssertionError(f"{path.name}: {line}: {error!r}") from None


@pytest.mark.parametrize("path", tutorial.PAGES, ids=lambda path: path.stem)
def test_files_and_links(path):
    for box in tutorial.boxes(path):
        if box.path.endswith(".py"):
            ast.parse(box.text)
        elif box.path:
            assert yaml.safe_load(box.text)
    for target in tutorial.links(path):
        assert (path.parent / target).exists(), f"{path.name}: {target}"

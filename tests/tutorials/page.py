"""Reads a tutorial: its commands, its files, what it says comes out.

In the pages, the words behind three backquotes say what a box is:
`bash` runs to its end; `bash terminal` goes on running while the page goes on;
`LANGUAGE file=PATH` is a file that the reader saves; `text expect` is what the boxes of commands
before it print, in part.
"""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    path for path in (ROOT / "docs" / "tutorials").glob("*.md") if path.name != "README.md"
)


@dataclass(frozen=True)
class Box:
    """One box of a page.

    Attributes:
        kind: "run", "terminal", "file" or "expect".
        text: Without the fences.
        line: Number of its first line.
        path: Of a file, with its ~.
    """

    kind: str
    text: str
    line: int
    path: str = ""


def boxes(page):
    """Lists the boxes of a page in their order.

    Raises:
        ValueError: The words behind the backquotes are none of the above.
    """
    found, opened = [], None
    for number, line in enumerate(Path(page).read_text().splitlines(), start=1):
        if line.startswith("```") and opened is None:
            opened = (line[3:].strip(), number + 1, [])
        elif line.startswith("```"):
            words, first, lines = opened
            found.append(_box(words, "".join(f"{item}\n" for item in lines), first))
            opened = None
        elif opened is not None:
            opened[2].append(line)
    if opened is not None:
        raise ValueError(f"{page}:{opened[1]}: the box has no end")
    return found


def _box(words, text, line):
    kinds = {"bash": "run", "bash terminal": "terminal", "text expect": "expect"}
    if words in kinds:
        return Box(kinds[words], text, line)
    given = re.fullmatch(r"\w+ file=(\S+)", words)
    if given is None:
        raise ValueError(f"line {line}: a box is {words!r}, which means nothing")
    return Box("file", text, line, given[1])


def inline_commands(page):
    """Lists the `./run ...` in a page's running text."""
    text = re.sub(r"^```.*?^```", "", Path(page).read_text(), flags=re.DOTALL | re.MULTILINE)
    return [" ".join(found.split()) for found in re.findall(r"`(\./run[^`]*)`", text)]


def commands(page):
    """Lists every command line of a page, of boxes and of the running text."""
    lines = [
        line
        for box in boxes(page)
        if box.kind in ("run", "terminal")
        for line in box.text.splitlines()
    ]
    return [*lines, *inline_commands(page)]


def links(page):
    """Lists what a page links to, and its pictures, without those of the web."""
    targets = re.findall(r"\]\(([^)]+)\)", Path(page).read_text())
    return [target.partition("#")[0] for target in targets if "://" not in target]

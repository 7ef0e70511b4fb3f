"""Makes docs/results.md of bench/results/*.json, which ./run bench --save writes.

    ./run exec python docs/tools/results_page.py

The page has a table for each section, with the machine, the commit and the day of its run.
"""

from __future__ import annotations

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "bench"))

import results  # noqa: E402

PAGE = ROOT / "docs" / "results.md"
HEAD = """# Results

Made by `docs/tools/results_page.py` from what `./run bench -- --save` writes to `bench/results/`.
Each value is the median of its runs; the spread is the least and the greatest of them. How they are
measured, and what limits what: [performance](performance.md).
"""
NONE = "\nNo results are recorded for this version yet.\n"


def number(value: float) -> str:
    """A figure with three digits that count, without an exponent."""
    digits = 0 if abs(value) >= 100 else 1 if abs(value) >= 10 else 2 if abs(value) >= 1 else 3
    return f"{value:.{digits}f}"


def section(found: dict) -> str:
    """The text of a section.

    Args:
        found: A document of bench/results.py.
    """
    machine = found["machine"]
    text = (
        f"\n## {found['name'].replace('_', ' ')}\n\n"
        f"{machine['processor']}, {machine['cores']} cores, Python {machine['python']}; "
        f"commit {found['commit']}, {found['date'][:10]}; "
        f"others had at most {found['others']:.2f} processors.\n\n"
        "| | value | spread | runs |\n| --- | --- | --- | --- |\n"
    )
    for figure in found["figures"]:
        spread = "" if figure["spread"] is None else " to ".join(map(number, figure["spread"]))
        value = f"{number(figure['value'])} {figure['unit']}".rstrip()
        text += f"| {figure['name']} | {value} | {spread} | {figure['runs']} |\n"
    return text


def page(folder: pathlib.Path = results.FOLDER) -> str:
    """The page's text.

    Args:
        folder: With files as bench/results.py writes them.
    """
    documents = [results.check(path.read_text()) for path in sorted(folder.glob("*.json"))]
    return HEAD + ("".join(map(section, documents)) or NONE)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)

"""Makes docs/supported.md of docs/support: what is supported of all that Gazebo's sources read.

    python docs/tools/supported.py            writes the page
    python docs/tools/supported.py --check    says what is wrong with the data and fails

docs/support/names/KEY.txt has names that an original reads, docs/support/FAMILY.yaml their rows:

    family: the heading on the page
    names: KEY, or a list of keys
    rows:
    - name: a name, or several in a list
      state: as Gazebo
      test: PATH::FUNCTION[PARAMETERS] that holds it, or several in a list
      note: only where there is something to say
    - {name: ..., state: differs, note: how, from: measured (beside Gazebo) or sources}
    - {name: ..., state: ignored, warns: true, note: what is missing}
    - {name: ..., state: means nothing here, note: why}
"""

from __future__ import annotations

import argparse
import ast
import collections
import pathlib
import re
import sys
from dataclasses import dataclass, field

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "support"
PAGE = ROOT / "docs" / "supported.md"
SAME, DIFFERS, IGNORED, NOTHING = "as Gazebo", "differs", "ignored", "means nothing here"
READ = "read only"  # on the page: SAME, of a row that no other tests than READERS hold
STATES = SAME, DIFFERS, IGNORED, NOTHING
COLUMNS = SAME, READ, DIFFERS, IGNORED, NOTHING
READERS = ("test_a_parameter_and_its_default", "test_a_parameter_of_a_realsense")
KEYS = {  # state -> (keys that a row must have, keys that it may have), besides name and state
    SAME: ({"test"}, {"note"}),
    DIFFERS: ({"note", "from"}, {"test"}),
    IGNORED: ({"warns"}, {"note", "test"}),
    NOTHING: ({"note"}, set()),
}
FROM = "measured", "sources"
HEAD = """# What is supported

Every element, attribute and parameter that the sources of Gazebo 11 and its ROS packages read,
and what Paddock does with it. `docs/tools/supported.py` makes this page of [docs/support](support).

- `as Gazebo`: a test, which is named, holds what it does: as recorded in Gazebo, or by its source.
- `read only`: a test holds the value that is read and its default, as in Gazebo's source; what it
  does has no test of its own.
- `differs`: how; measured beside Gazebo, or read in the sources of both.
- `ignored`: it means something in Gazebo and nothing in Paddock; a warning may name it.
- `means nothing here`: it has no effect in Gazebo with ODE and ROS either, or the row says why.
"""


@dataclass
class Names:
    """A list of names that an original reads, and where they are from."""

    key: str
    title: str
    source: str
    names: list[str]


@dataclass
class Row:
    """What becomes of some names."""

    names: list[str]
    values: dict
    where: str  # for messages

    @property
    def state(self) -> str | None:
        return self.values.get("state")

    @property
    def tests(self) -> list[str]:
        return _listed(self.values.get("test"))

    @property
    def kind(self) -> str | None:
        """The state as the page tells it: one of COLUMNS."""
        reads = all(_plain(test).rpartition("::")[2] in READERS for test in self.tests)
        return READ if self.state == SAME and reads else self.state


@dataclass
class Family:
    """The rows of one file; each name is in one of the lists of names."""

    title: str
    key: str
    lists: list[str]
    rows: list[Row] = field(default_factory=list)


def _listed(value) -> list:
    return [] if value is None else value if isinstance(value, list) else [value]


def _loaded(path: pathlib.Path):
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    return yaml.load(path.read_text(encoding="utf-8"), Loader=loader)  # noqa: S506


def read_names(folder: pathlib.Path = FOLDER) -> dict[str, Names]:
    """Lists of names: key, the file's name without .txt, -> list.

    A file has a line "# title: ...", one "# source: ..." and then a name a line.
    """
    found = {}
    for path in sorted((folder / "names").glob("*.txt")):
        head, names = {}, []
        for line in path.read_text(encoding="utf-8").splitlines():
            if line.startswith("#"):
                key, _, value = line[1:].partition(":")
                head[key.strip()] = value.strip()
            elif line.strip():
                names.append(line.strip())
        found[path.stem] = Names(path.stem, head["title"], head["source"], names)
    return found


def read_families(folder: pathlib.Path = FOLDER) -> list[Family]:
    """Families of rows, in the order of their files' names."""
    found = []
    for path in sorted(folder.glob("*.yaml")):
        data = _loaded(path)
        family = Family(data["family"], path.stem, _listed(data["names"]))
        for number, values in enumerate(data["rows"], 1):
            names = [str(name) for name in _listed(values.get("name"))]
            family.rows.append(Row(names, values, f"{path.name}, row {number} ({names[:1]})"))
        found.append(family)
    return found


def existing_tests(root: pathlib.Path = ROOT) -> set[str]:
    """Ids PATH::FUNCTION and PATH::CLASS::METHOD of all tests, without parameters."""
    found = set()
    for folder in ("tests", "src"):
        for path in (root / folder).rglob("test_*.py"):
            place = path.relative_to(root).as_posix()
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.ClassDef):
                    found |= {
                        f"{place}::{node.name}::{inner.name}"
                        for inner in node.body
                        if isinstance(inner, ast.FunctionDef) and inner.name.startswith("test")
                    }
                elif isinstance(node, ast.FunctionDef) and node.name.startswith("test"):
                    found.add(f"{place}::{node.name}")
    return found


def problems(lists: dict[str, Names], families: list[Family], tests: set[str]) -> list[str]:
    """What is wrong with the data, a sentence each."""
    found = []
    for names in lists.values():
        counts = collections.Counter(names.names)
        found += [
            f"names/{names.key}.txt has '{name}' twice" for name in counts if counts[name] > 1
        ]
    have: dict[str, list[str]] = {key: [] for key in lists}
    for family in families:
        found += [f"{family.key}: no list '{key}'" for key in family.lists if key not in lists]
        known = {name: key for key in family.lists if key in lists for name in lists[key].names}
        for row in family.rows:
            found += [f"{row.where}: {text}" for text in _row_problems(row, tests)]
            for name in row.names:
                if name not in known:
                    found.append(f"{row.where}: '{name}' is in no list of {family.lists}")
                else:
                    have[known[name]].append(name)
    for key, names in have.items():
        counts = collections.Counter(names)
        found += [f"'{name}' of {key} has {n} rows" for name, n in counts.items() if n > 1]
        found += [f"'{name}' of {key} has no row" for name in lists[key].names if not counts[name]]
    return found


def _row_problems(row: Row, tests: set[str]) -> list[str]:
    if row.state not in KEYS:
        return [f"state is '{row.state}', must be one of {', '.join(STATES)}"]
    required, optional = KEYS[row.state]
    keys = set(row.values) - {"name", "state"}
    found = [f"'{row.state}' needs {key}" for key in sorted(required - keys)]
    found += [f"'{row.state}' has no {key}" for key in sorted(keys - required - optional)]
    found += [f"test '{test}' does not exist" for test in row.tests if _plain(test) not in tests]
    if "from" in keys and row.values["from"] not in FROM:
        found.append(f"from is '{row.values['from']}', must be one of {', '.join(FROM)}")
    if "warns" in keys and not isinstance(row.values["warns"], bool):
        found.append("warns must be true or false")
    if not row.names:
        found.append("it has no name")
    return found


def _plain(test: str) -> str:
    """A test's id without its parameters."""
    return test.partition("[")[0]


def counted(families: list[Family]) -> dict[str, dict[str, int]]:
    """Family's title -> state as the page tells it -> number of names."""
    counts: dict[str, dict[str, int]] = {}
    for family in families:
        of = counts.setdefault(family.title, dict.fromkeys(COLUMNS, 0))
        for row in family.rows:
            of[row.kind] += len(row.names)
    return counts


def page(lists: dict[str, Names], families: list[Family]) -> str:
    """The text of docs/supported.md."""
    lines = [HEAD, f"| family | {' | '.join(COLUMNS)} | all |", "| --- |" + " ---: |" * 6]
    counts = counted(families)
    for title, of in counts.items():
        link = f"[{_cell(title)}](#{_anchor(title)})"
        numbers = " | ".join(str(of[state]) for state in COLUMNS)
        lines.append(f"| {link} | {numbers} | {sum(of.values())} |")
    sums = [sum(of[state] for of in counts.values()) for state in COLUMNS]
    lines.append(f"| all | {' | '.join(map(str, sums))} | {sum(sums)} |")
    lines += ["", "Where the names are from:", ""]
    lines += [
        f"- {_cell(names.title)}: {_cell(names.source)} ({len(names.names)})"
        for names in lists.values()
    ]
    for family in families:
        lines += ["", f"## {_cell(family.title)}", "", "| name | state | |", "| --- | --- | --- |"]
        for row in family.rows:
            names = ", ".join(_cell(f"`{name}`") for name in row.names)
            lines.append(f"| {names} | {row.kind} | {_cell(_remark(row))} |")
    return "\n".join(lines) + "\n"


def _remark(row: Row) -> str:
    parts = [str(row.values["note"]).strip()] if row.values.get("note") else []
    if row.state == DIFFERS:
        parts.append(
            {"measured": "(measured)", "sources": "(from the sources)"}[row.values["from"]]
        )
    if row.state == IGNORED:
        parts.append("with a warning" if row.values["warns"] else "without a warning")
    if row.tests:
        parts.append("; ".join(f"`{_shown(test)}`" for test in row.tests))
    return " ".join(parts)


def _shown(test: str) -> str:
    """A test's id without the folders of its file."""
    path, _, rest = test.partition("::")
    return f"{path.rpartition('/')[2]}::{rest}"


def _cell(text: str) -> str:
    words = " ".join(text.split()).replace("|", "\\|")
    return re.sub(r"`[^`]*`|<[^>`]*>", lambda found: f"`{found[0].strip('`')}`", words)


def _anchor(title: str) -> str:
    """GitHub's anchor of a heading."""
    kept = (c for c in title.lower() if c.isalnum() or c in " -_")
    return "".join(kept).replace(" ", "-")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="only say what is wrong")
    check = parser.parse_args().check
    lists, families = read_names(), read_families()
    found = problems(lists, families, existing_tests())
    if not found:
        text = page(lists, families)
        if check and text != PAGE.read_text(encoding="utf-8"):
            found.append("docs/supported.md is not what the data say: run docs/tools/supported.py")
        elif not check:
            PAGE.write_text(text, encoding="utf-8")
    print("\n".join(found), file=sys.stderr, end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

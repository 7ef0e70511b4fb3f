"""What docs/support says of what is supported: complete, true of the readers, and on the page."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from bullet_sim.formats import gazebo
from bullet_sim.formats.sdf.unread import UNREAD

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "tools"))

import supported  # noqa: E402

TESTS = {"tests/a.py::test_a"}
SAME = {"name": "a", "state": "as Gazebo", "test": "tests/a.py::test_a[case 1]"}
OTHER = {"name": "b", "state": "means nothing here", "note": "because"}


@pytest.fixture(name="matrix", scope="module")
def _matrix():
    return supported.read_names(), supported.read_families()


def rows_of(families, key):
    """Name -> row, of all families that have names of a list."""
    found = {}
    for family in families:
        if key in family.lists:
            found.update((name, row) for row in family.rows for name in row.names)
    return found


def test_every_name_has_a_row_and_every_row_is_true(matrix):
    assert supported.problems(*matrix, supported.existing_tests()) == []


def test_the_page_is_made_of_the_data(matrix):
    assert supported.PAGE.read_text() == supported.page(*matrix), "run docs/tools/supported.py"


def test_keys_of_a_urdfs_gazebo_element_are_what_its_reader_has(matrix):
    rows = rows_of(matrix[1], "urdf_gazebo")
    for name, row in rows.items():
        if row.state in (supported.SAME, supported.DIFFERS):
            assert name in gazebo.READ, name
        elif row.state == supported.IGNORED:
            assert name not in gazebo.READ, name
            assert (name in gazebo.QUIET) != row.values["warns"], name
    assert gazebo.READ | gazebo.QUIET <= set(rows)


def test_what_of_sdf_is_ignored_with_a_warning_is_what_its_reader_warns_of(matrix):
    """Where it is not the reader of formats/sdf/unread.py that warns, a test holds the warning."""
    rows = {**rows_of(matrix[1], "sdf"), **rows_of(matrix[1], "sdf_old")}
    ignored = {name for name, row in rows.items() if row.state == supported.IGNORED}
    for name in ignored:
        assert rows[name].values["warns"], f"{name} has to be warned of"
        assert (name in UNREAD) != bool(rows[name].tests), name
    assert set(UNREAD) <= ignored


def made(*rows, names=("a", "b")):
    """What is wrong with these rows, of a list of names."""
    lists = {"l": supported.Names("l", "t", "s", list(names))}
    found = [
        supported.Row(supported._listed(values.get("name")), values, f"row {values.get('name')}")
        for values in rows
    ]
    return supported.problems(lists, [supported.Family("f", "f", ["l"], found)], TESTS)


@pytest.mark.parametrize(
    "rows, words",
    [
        ((SAME,), "'b' of l has no row"),
        ((SAME, OTHER, OTHER), "'b' of l has 2 rows"),
        (({**SAME, "test": "tests/a.py::test_b"}, OTHER), "'tests/a.py::test_b' does not exist"),
        (({"name": "a", "state": "as Gazebo"}, OTHER), "needs test"),
        (({"name": "a", "state": "ignored", "warns": "no"}, OTHER), "true or false"),
        (({"name": "a", "state": "differs", "note": "x", "from": "ear"}, OTHER), "from is 'ear'"),
    ],
)
def test_what_is_wrong_is_said(rows, words):
    assert made(SAME, OTHER) == []
    found = made(*rows)
    assert len(found) == 1 and words in found[0]


def test_counts_and_links_of_the_page():
    lists = {"l": supported.Names("l", "keys", "their source", ["a", "b|c", "d"])}
    reads = {"state": "as Gazebo", "test": f"tests/a.py::{supported.READERS[0]}[of/a-b]"}
    values = (SAME, OTHER, reads)
    rows = [supported.Row([name], row, "") for name, row in zip(lists["l"].names, values)]
    text = supported.page(lists, [supported.Family("Keys: <of>", "f", ["l"], rows)])
    assert "| [Keys: `<of>`](#keys-of) | 1 | 1 | 0 | 0 | 1 | 3 |" in text
    assert "| `a` | as Gazebo | `a.py::test_a[case 1]` |" in text
    assert f"| `d` | read only | `a.py::{supported.READERS[0]}[of/a-b]` |" in text
    assert "| `b\\|c` | means nothing here | because |" in text

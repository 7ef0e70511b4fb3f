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

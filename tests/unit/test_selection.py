"""The tests' own plugins: which tests run, and in which order."""

import os
import subprocess

import pytest
from plugin_rig import CIRCLE, LINTERS, LONG, PHYSICS, SKID, STANDIN, TWISTS

from commands import procfs

FILTERS = {
    (): {SKID, CIRCLE, LONG, STANDIN, PHYSICS, LINTERS},
    ("unit",): {SKID, LONG, STANDIN, PHYSICS},
    ("project",): {LONG},
    ("ros",): {CIRCLE},
    ("circ",): {CIRCLE},
    ("car",): {SKID},
    ("car/test_sk", "circle"): {SKID, CIRCLE},
    ("standins",): {STANDIN},  # a folder
    ("joy",): {STANDIN},
    ("physics",): {PHYSICS},
    ("long",): {TWISTS},  # a stage, and no part of a name
    ("lint",): {LINTERS},
    ("mypy",): {LINTERS},
    ("no_such",): set(),
}


def test_filters(project):
    for path in (SKID, CIRCLE, TWISTS, LONG, STANDIN, PHYSICS):
        project.add(path)
    selected = dict(zip(FILTERS, project.selected(*FILTERS)))
    files = {
        filters: {test.partition("::")[0] for test in selected[filters]} for filters in FILTERS
    }
    assert files == FILTERS
    # a linter is picked by its name
    assert [test.partition("::")[2] for test in selected["mypy",]] == ["test_no_warnings[mypy]"]


@pytest.mark.parametrize("options", [(), ("--numprocesses=2",)])
def test_a_filter_that_matches_nothing_is_named(project, options):
    project.add(SKID)
    status, output = project.run(*options, "--select", "no_such")
    assert status != 0 and "nothing matches 'no_such'; there are the stages unit, lint" in output


def test_a_process_is_found_as_soon_as_it_is_started():
    for number in range(200):
        value = f"{os.getpid()}_{number}"
        with subprocess.Popen(
            ["sleep", "600"], start_new_session=True, env={**os.environ, "FOUND": value}
        ) as child:
            found = procfs.marked("FOUND", value)
            child.kill()
        assert found == [child.pid]

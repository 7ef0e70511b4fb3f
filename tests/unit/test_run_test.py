"""The command line of ./run test, and how many processes it takes."""

import os

import pytest

from commands.subcommands import test as command


@pytest.mark.parametrize("line, words, filters", [
    ("", "--numprocesses=4", ""),
    ("circle unit", "--numprocesses=4", "circle unit"),
    ("-j 1 circle", "--numprocesses=1", "circle"),
    ("-j5", "--numprocesses=5", ""),
    ("web", "--numprocesses=1", "web"),
    ("-j 3 web", "--numprocesses=3", "web"),
    ("--jobs=5 -x", "-x --numprocesses=5", ""),
    ("-k spot ros", "-k spot --numprocesses=4", "ros"),
    ("--list ros", "--collect-only", "ros"),
    ("--failed", "--last-failed --last-failed-no-failures=none --numprocesses=4", ""),
])  # fmt: skip
def test_options(monkeypatch, line, words, filters):
    monkeypatch.setattr(command, "cores", lambda: 2)
    assert command.options(line.split()) == (words.split(), filters.split())


@pytest.mark.parametrize("limit, most", [
    (None, None), ("max 100000\n", None), ("nonsense", None), ("50000 100000\n", 1),
    ("150000 100000\n", 2),
])  # fmt: skip
def test_cores_heeds_the_limit_of_a_container(tmp_path, limit, most):
    file = tmp_path / "cpu.max"
    if limit is not None:
        file.write_text(limit)
    there = len(os.sched_getaffinity(0))
    assert command.cores(file) == min(there, most or there)

"""The runner of upstream's suites: what it changes in launch files, what it reads, its table."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "conformance"))
import run  # noqa: E402
import suites  # noqa: E402

LAUNCH = """<launch>
  <rosparam command="load" file="$(find robot)/test/values.yaml"/>
  <node pkg="robot" type="fake" name="fake"/>
  <node pkg="robot" type="real" name="real"/>
  <test test-name="t" pkg="robot" type="client.py" args="$(find robot)/test/api.yaml"/>
</launch>
"""
SUITE = suites.Suite(
    "clone", "robot", ("test/*.test",), nodes={("robot", "fake"): "here.launch"}, service="/ready",
    edits=(("old()", "new()"),),
)  # fmt: skip


@pytest.fixture(name="sources")
def _sources(tmp_path):
    test = tmp_path / "sources" / "clone" / "robot" / "test"
    test.mkdir(parents=True)
    (test / "drive.test").write_text(LAUNCH)
    (test / "client.py").write_text("#!/usr/bin/env python\nold()\n")
    (test / "test_sums.py").write_text(
        "TAG = '<test/>'\n\ndef sum_test():\n    assert 1 + 1 == 2\n"
    )
    return tmp_path / "sources"


def test_copies_find_each_other_and_the_clone_stays_as_it_is(sources, tmp_path):
    (tmp_path / "work").mkdir()
    copy, name = run.copy_package(SUITE, sources, "robot", tmp_path / "work")
    text = (copy / "test" / "drive.test").read_text()
    assert name == "conformance_robot" and "$(find robot)" not in text
    assert 'type="fake"' not in text and "here.launch" in text
    assert 'pkg="robot" type="real"' in text
    assert f'pkg="{name}" type="client.py"' in text and "wait_for /ready" in text
    script = copy / "test" / "client.py"
    assert "new()" in script.read_text() and script.stat().st_mode & 0o100
    original = sources / "clone" / "robot" / "test"
    assert (original / "drive.test").read_text() == LAUNCH
    assert "old()" in (original / "client.py").read_text()


def test_a_suite_of_functions_and_a_table(sources, monkeypatch):
    suite = suites.Suite("clone", "robot", modules=("test/test_sums.py",),
                         not_applicable={"cm_test": "C++"})  # fmt: skip
    monkeypatch.setitem(suites.SUITES, "robot", suite)
    cases = run.run_suite("robot", suite, sources)
    assert [(case.name, case.reason) for case in cases] == [
        ("test_sums.py::test_sums.sum_test", "")
    ]
    lines = run.table({"robot": [*cases, run.Case("b", "it broke")]})
    assert lines[1].endswith("1 of 2") and "  robot: b: it broke" in lines
    assert "  robot: not applicable: cm_test: C++" in lines

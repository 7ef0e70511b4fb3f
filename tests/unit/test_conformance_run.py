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


def test_compiled_programs_are_copied_and_missing_ones_named(sources, tmp_path):
    nodes = {("robot", "fake"): "here.launch speed:='1 2' slow:=true"}
    suite = suites.Suite("clone", "robot", ("test/*.test",), nodes=nodes)
    text = LAUNCH.replace("client.py", "client_test").replace("<test ", '<test time-limit="9" ')
    (sources / "clone" / "robot" / "test" / "drive.test").write_text(text)
    (tmp_path / "work").mkdir()
    (case,) = run.run_suite("robot", suite, sources)
    assert case.name == "drive.test" and "compile client_test" in case.reason
    clients = tmp_path / "clients" / "robot"
    clients.mkdir(parents=True)
    (clients / "client_test").write_text("#!/bin/sh\n")
    (clients / "client_test").chmod(0o755)
    copy, name = run.copy_package(suite, sources, "robot", tmp_path / "work", clients.parent)
    assert run.missing_client(copy / "test" / "drive.test", copy, "robot") == ""
    text = (copy / "test" / "drive.test").read_text()
    assert f'pkg="{name}" type="client_test"' in text and 'time-limit="9"' not in text
    assert '<arg name="speed" value="1 2"/><arg name="slow" value="true"/></include>' in text


def test_a_simulator_of_the_launch_files_goes_at_the_pace(monkeypatch):
    suite = suites.Suite("clone", "robot", simulator="gazebo")
    assert "real_time_factor" not in run.rewrite(LAUNCH, suite, "robot", "copy", [])
    monkeypatch.setenv(run.PACE, "0.5")
    text = run.rewrite(LAUNCH, suite, "robot", "copy", [])
    assert '<param name="/gazebo/real_time_factor" value="0.5"/>\n</launch>' in text
    other = suites.Suite("clone", "robot")
    assert "real_time_factor" not in run.rewrite(LAUNCH, other, "robot", "copy", [])


def test_what_gtest_says_is_one_line():
    assert run.short("Traceback\n  File x\nValueError: 3") == "ValueError: 3"
    assert run.short("/a/b.cpp:7\nExpected: 1\n  Which is: 2") == (
        "/a/b.cpp:7 Expected: 1 Which is: 2"
    )
    assert run.short(" ") == ""


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


def test_a_copy_can_have_the_name_of_its_package(sources, tmp_path):
    suite = suites.Suite("clone", "robot", own_name=True)
    copy, name = run.copy_package(suite, sources, "robot", tmp_path / "work")
    assert name == "robot" and "<name>robot</name>" in (copy / "package.xml").read_text()


def test_missing_clones_and_unknown_suites_are_named(tmp_path, capsys):
    assert run.main(["--sources", str(tmp_path), "xacro"]) == 1
    assert f"clone xacro into {tmp_path}" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        run.main(["--sources", str(tmp_path), "nothing"])
    assert "'nothing' is not one of diff_drive_controller" in capsys.readouterr().err

"""The test runner's tables: what runs when, what is counted, what is remembered and printed."""

import json
import os
import pathlib
import subprocess
import sys

import pytest
from runner import jobs as table
from runner import report
from runner.history import LENGTH, History
from runner.job import ALONE, WAITS, Case, Job, Outcome
from runner.junit import count
from runner.main import DEADLINES
from runner.schedule import Schedule, cores, slack
from runner_rig import LONG, job, write_cases


def order(schedule):
    """Names in the order in which a schedule starts jobs of which one runs at a time."""
    while (item := schedule.take()) is not None:
        yield item.name
        schedule.give_back(item)


# scheduling -----------------------------------------------------------------------------------


def test_the_longest_start_first():
    jobs = [job("a"), job("b"), job("c")]
    seconds = {"unit a": 2.0, "unit b": 30.0, "unit c": 10.0}
    assert list(order(Schedule(jobs, 1, seconds))) == ["b", "c", "a"]


def test_as_many_run_as_there_are_slots():
    schedule = Schedule([job(name) for name in "abc"], 2, {})
    first, second = schedule.take(), schedule.take()
    assert {first.name, second.name} == {"a", "b"} and schedule.take() is None
    schedule.give_back(first)
    assert schedule.take().name == "c"


def test_a_job_that_counts_as_two_leaves_room_for_one_less():
    schedule = Schedule([job("wide", slots=2), job("a"), job("b")], 3, {"unit a": 9.0})
    assert [schedule.take().name, schedule.take().name] == ["wide", "a"]
    assert schedule.take() is None


def test_two_jobs_that_wait_count_as_one_and_start_with_the_longest():
    waiting = [job(name, slots=WAITS) for name in ("w1", "w2")]
    seconds = {"unit w1": 9.0, "unit w2": 8.0, "unit a": 7.0, "unit b": 6.0}
    schedule = Schedule([job("a"), job("b"), *waiting], 2, seconds)
    assert [schedule.take().name for _ in range(3)] == ["w1", "w2", "a"]
    assert schedule.take() is None
    schedule.give_back(waiting[0])
    assert schedule.take() is None  # half a slot is free
    schedule.give_back(waiting[1])
    assert schedule.take().name == "b"


def test_one_at_a_time_is_one_at_a_time():
    schedule = Schedule([job("w1", slots=WAITS), job("w2", slots=WAITS)], 1, {})
    assert schedule.take().name == "w1" and schedule.take() is None


def test_every_job_has_an_expected_time_and_a_deadline(tmp_path):
    jobs = table.all_jobs()
    assert all(History(tmp_path / "none.json").seconds(jobs).values())
    assert {item.stage for item in jobs} <= set(DEADLINES)


def test_the_jobs_that_wait_exist():
    names = {item.name for item in table.all_jobs() if item.slots == WAITS}
    assert names == set(table.WAITING)


def test_the_soak_has_to_be_asked_for_and_its_page_is_a_result():
    jobs = table.all_jobs()
    assert "soak" not in {item.stage for item in table.selected(jobs, [])}
    (found,) = table.selected(jobs, ["soak"])
    assert found.command[-4:] == ("--seed", "1", "--folder", str(found.directory))


@pytest.mark.parametrize("slots", [1, 2, 5])
def test_a_job_that_runs_alone_has_all_slots(slots):
    alone = job("alone", slots=ALONE)
    schedule = Schedule([job("a"), alone], slots, {"unit a": 9.0})
    assert schedule.take() is alone and schedule.take() is None
    schedule.give_back(alone)
    assert schedule.take().name == "a"


@pytest.mark.parametrize(
    "text, most",
    [("150000 100000\n", 2), ("50000 100000\n", 1), ("max 100000\n", None), (None, None)],
)
def test_cores_heeds_the_limit_of_a_container(tmp_path, monkeypatch, text, most):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)))
    if text is not None:
        (tmp_path / "cpu.max").write_text(text)
    assert cores(tmp_path / "cpu.max") == (most or 8)


def test_deadlines_grow_with_what_runs_on_a_core():
    assert slack(2, 2) == 2.0 and slack(8, 2) == 5.0 and slack(1, 8) < slack(4, 8)


# counting -------------------------------------------------------------------------------------


def test_cases_are_counted(tmp_path):
    write_cases(
        tmp_path,
        '<testcase classname="A" name="good" time="1.5"/>'
        '<testcase classname="A" name="left_out"><skipped/></testcase>'
        '<testcase classname="A" name="wrong"><failure message="1 is not 2"/></testcase>'
        '<testcase classname="A" name="broken"><error>Traceback</error></testcase>'
        '<testcase classname="rostest.runner.RosTest" name="testwrapper" time="9"/>',
    )
    outcome = count(tmp_path)
    assert (outcome.passed, outcome.skipped) == (1, 1)
    assert outcome.failures == ["A.wrong: 1 is not 2", "A.broken: Traceback"]
    assert outcome.cases[0] == Case("A.good", 1.5) and len(outcome.cases) == 4


def test_the_wrapper_fails_when_its_test_node_died(tmp_path):
    write_cases(
        tmp_path,
        '<testcase classname="rostest.runner.RosTest" name="x">'
        '<failure message="died"/></testcase>',
    )
    assert count(tmp_path).failures == ["rostest.runner.RosTest.x: died"]


def test_a_file_that_was_cut_off_is_a_failure(tmp_path):
    (tmp_path / "half.xml").write_text("<testsuite><testcase")
    [failure] = count(tmp_path).failures
    assert "half.xml is no complete JUnit file" in failure


# what is printed and remembered -----


def test_the_sum_is_the_last_line(capsys):
    outcomes = {
        job("a"): Outcome(passed=3, cases=[Case(f"quick{n}", 0.1) for n in range(20)]),
        job("b"): Outcome(passed=1, skipped=2, failures=["B.x: bad\nmore"], cases=[Case("B.x", 7)]),
    }
    report.whole(outcomes, {"unit b": (1, 4)}, 12.0)
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1] == "4 passed, 1 failed, 2 skipped"
    assert "  unit b: B.x: bad" in lines and "  unit b: failed 1 of 4 times" in lines
    slowest = lines.index("slowest 10 of 21 tests:")
    assert lines[slowest + 1].split() == ["7.0", "s", "unit", "b:", "B.x"]
    assert sum("quick" in line for line in lines) == 9


def remembered(file, runs):
    """A history read from its file, after runs (key, ok)."""
    history = History(file)
    for key, ok in runs:
        history.add(key, Outcome(failures=[] if ok else ["bad"], seconds=3.0))
    return History(file)


def test_failed_are_those_that_failed_when_they_last_ran(tmp_path):
    runs = [("unit a", False), ("unit b", True), ("unit c", False), ("unit a", True)]
    assert remembered(tmp_path / "h.json", runs).failed() == {"unit c"}


def test_flaky_are_those_that_failed_and_passed(tmp_path):
    runs = [("unit a", False), ("unit a", True), ("unit b", False), ("unit b", False)]
    runs += [("unit c", True), ("unit a", True)]
    assert remembered(tmp_path / "h.json", runs).flaky() == {"unit a": (1, 3)}


def test_old_runs_are_forgotten(tmp_path):
    runs = [("unit a", False)] + LENGTH * [("unit a", True)]
    assert remembered(tmp_path / "h.json", runs).flaky() == {}


def test_expected_times_are_the_last_ones(tmp_path):
    history = remembered(tmp_path / "h.json", [("unit a", True)])
    seconds = history.seconds([job("a"), job("b")])
    assert seconds["unit a"] == 3.0 and seconds["unit b"] > 0.0


@pytest.mark.parametrize("text", ["", "{", "[]", '{"jobs": '])
def test_a_history_that_cannot_be_read_is_an_empty_one(tmp_path, text):
    (tmp_path / "h.json").write_text(text)
    assert remembered(tmp_path / "h.json", [("unit a", False)]).failed() == {"unit a"}
    assert json.loads((tmp_path / "h.json").read_text())


# command line ---------------------------------------------------------------------------------

RUNNER = pathlib.Path(report.__file__).parents[1] / "runner.py"


def said(*arguments):
    """Exit status and what the runner prints."""
    done = subprocess.run(
        [sys.executable, str(RUNNER), *arguments],
        capture_output=True,
        text=True,
        timeout=LONG,
        check=False,
    )
    return done.returncode, done.stdout + done.stderr


def test_list_names_every_stage():
    status, text = said("--list")
    stages = [line.split()[0] for line in text.splitlines()]
    assert status == 0 and set(stages) == {"unit", "lint", "ros"} and stages.count("ros") > 40


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["no_such_test"], "nothing matches 'no_such_test'; there are the stages unit, lint, ros"),
        (["-j", "0"], "N is '0'; it must be a whole number above 0"),
        (["-j", "two"], "N is 'two'"),
    ],
)
def test_arguments_that_cannot_be(arguments, words):
    status, text = said(*arguments)
    assert status not in (0, None) and words in text


def test_a_filter_is_a_stage_or_part_of_a_name():
    names = ["rest", "truck_rest", "lap"]
    items = [Job("ros", name, ()) for name in names] + [Job("unit", "xrosx", ())]
    assert [item.name for item in table.selected(items, ["rest"])] == ["rest", "truck_rest"]
    assert [item.name for item in table.selected(items, ["ros"])] == [*names, "xrosx"]
    assert table.selected(items, []) == items

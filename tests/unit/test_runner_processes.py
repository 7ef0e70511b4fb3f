"""The test runner's processes: how jobs end, what they leave, that they run side by side."""

import os
import pathlib
import subprocess
import sys
import threading
import time

import pytest
from runner import jobs as table
from runner import main, process, report
from runner.job import Job, Outcome
from runner.process import Runner, marked
from runner.schedule import Schedule
from runner_rig import LONG, job, use_directory, write_cases


@pytest.fixture(autouse=True)
def results(tmp_path, monkeypatch):
    """Puts the jobs' directories below tmp_path, and gives that."""
    use_directory(monkeypatch, tmp_path)
    return tmp_path


GOOD = '<testsuite><testcase classname="A" name="a"/></testsuite>'
BAD = '<testsuite><testcase classname="A" name="a"><failure message="no"/></testcase></testsuite>'


@pytest.mark.parametrize(
    "text, status, counted, passed, failures",
    [
        (GOOD, 0, True, 1, []),
        (BAD, 1, True, 0, ["A.a: no"]),
        (GOOD, 3, True, 1, ["python ended with exit status 3"]),
        ("", 0, True, 0, ["the runner ran no test at all"]),
        ("", 0, False, 1, []),
        ("", 1, False, 0, ["python ended with exit status 1"]),
    ],
)
def test_what_a_run_is_judged_by(results, text, status, counted, passed, failures):
    writing = f"open({str(results / 'unit' / 'some' / 'a.xml')!r}, 'w').write({text!r})\n"
    item = job(text=(writing if text else "") + f"sys.exit({status})", counted=counted)
    outcome = Runner().run(item, LONG)
    assert outcome.passed == passed
    assert [
        line.replace(pathlib.Path(sys.executable).name, "python") for line in outcome.failures
    ] == failures


def test_a_runner_that_is_missing_is_a_failure():
    outcome = Runner().run(Job("unit", "some", ("/no/such/runner",)), LONG)
    assert outcome.passed == 0 and "/no/such/runner" in outcome.failures[0]


@pytest.mark.parametrize("give", [table.tool, table.module])
def test_a_tool_that_is_missing_is_named_with_a_way_to_get_it(give):
    with pytest.raises(LookupError, match="no_such_tool is not installed.*run setup"):
        give("no_such_tool")


def test_files_of_an_earlier_run_do_not_count(results):
    write_cases(results / "unit" / "some", '<testcase classname="A" name="old"/>')
    assert Runner().run(job(), LONG).failures == ["the runner ran no test at all"]


SLEEPER = """
child = subprocess.Popen([sys.executable, "-c",
    "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); time.sleep(600)"], **{})
print(child.pid, flush=True)
"""


def ended(pid):
    """Whether a process has ended; a zombie has."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


@pytest.mark.parametrize("fields", [{}, {"start_new_session": True}])
def test_past_its_deadline_a_job_ends_with_all_that_it_started(fields):
    item = job(
        text=SLEEPER.format(fields) + "signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "time.sleep(600)"
    )
    outcome = Runner(stop_grace=0.2).run(item, 3.0)
    assert outcome.failures[0] == "did not end within 3 s"
    assert ended(int(item.log.read_text()))


def test_what_outlives_its_job_is_ended_and_a_failure(monkeypatch):
    monkeypatch.setattr(process, "END_GRACE", 0.2)
    item = job(text=SLEEPER.format({"start_new_session": True}), counted=False)
    [failure] = Runner().run(item, LONG).failures
    assert failure.startswith("left processes behind: ") and "time.sleep(600)" in failure
    assert ended(int(item.log.read_text()))


def test_jobs_share_no_temporary_directory_and_leave_none(results):
    text = "import tempfile; print(tempfile.mkdtemp(), os.environ['ROS_HOME'])"
    printed = []
    for name in ("one", "two"):
        item = job(name, text, counted=False)
        assert Runner().run(item, LONG).failures == []
        printed.append(item.log.read_text().split())
    for one, two in zip(*printed, strict=True):
        assert pathlib.Path(one).parent != pathlib.Path(two).parent
        assert not pathlib.Path(one).exists()


def test_closing_ends_what_runs_and_starts_nothing_more():
    runner, item = (
        Runner(stop_grace=0.2),
        job(text="print(os.getpid(), flush=True); time.sleep(600)"),
    )
    outcomes = []
    thread = threading.Thread(target=lambda: outcomes.append(runner.run(item, LONG)))
    thread.start()
    deadline = time.monotonic() + LONG
    while not (item.log.exists() and item.log.read_text().endswith("\n")):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    runner.close()
    thread.join(LONG)
    assert ended(int(item.log.read_text().split()[0])) and outcomes[0].failures
    assert "has been ended" in runner.run(job("other"), LONG).failures[0]


def test_marks_are_told_apart():
    environment = dict(os.environ, **{process.MARK: "this_one"})
    with subprocess.Popen(["sleep", "600"], env=environment) as child:
        try:
            assert list(marked("this_one")) == [child.pid] and marked("this") == {}
        finally:
            child.kill()


def test_jobs_run_side_by_side():
    """Each waits for the other's file, so one after the other they would not end."""
    text = """
open(sys.argv[1], "w").close()
end = time.monotonic() + 30
while not os.path.exists(sys.argv[2]) and time.monotonic() < end: time.sleep(0.01)
sys.exit(not os.path.exists(sys.argv[2]))
"""
    jobs = []
    for mine, other in (("a", "b"), ("b", "a")):
        item = job(mine, text, counted=False)
        paths = tuple(str(item.directory.parent / f"there_{name}") for name in (mine, other))
        jobs.append(Job("unit", mine, (*item.command, *paths), counted=False))
    outcomes = dict(main.run_all(Schedule(jobs, 2, {}), Runner(), 2.0))
    assert set(outcomes) == set(jobs)
    assert [outcome.failures for outcome in outcomes.values()] == [[], []]


def test_a_deadline_is_that_of_the_stage_times_the_factor(monkeypatch):
    given = {}

    class Fake:
        def run(self, item, deadline):
            given[item.stage] = deadline
            return Outcome(passed=1)

    jobs = [Job(stage, "a", ()) for stage in main.DEADLINES]
    list(main.run_all(Schedule(jobs, 2, {}), Fake(), 1.5))
    assert given == {stage: 1.5 * seconds for stage, seconds in main.DEADLINES.items()}


def test_a_failed_job_shows_the_end_of_its_log(results, capsys):
    item = job(text="print(*range(100), sep=chr(10)); sys.exit(1)", counted=False)
    report.one(item, Runner().run(item, LONG), 1, 2)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("[1/2] unit some ... FAILED (0 passed, 1 failed, ")
    assert [line for line in lines if "|" in line] == [f"    | {n}" for n in range(60, 100)]

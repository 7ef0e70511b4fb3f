"""Runs every test of the project and prints one sum: unit tests, catkin_lint, rostests.

Started by `./run test`, which sets the environment. Each stage is a table of jobs; a job is one
process with a deadline, a log file and JUnit files from which the results are counted. A runner
that is missing, or that ran nothing, is a failure and not a silence.
"""

import argparse
import os
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "test-results"
DEADLINES = {"unit": 600.0, "lint": 120.0, "ros": 240.0}  # wall time of one job [s]
STOP_GRACE = 20.0  # wall time between SIGINT and SIGKILL [s]


@dataclass(frozen=True)
class Job:
    """One process of the test run.

    Attributes:
        stage: "unit", "lint" or "ros".
        name: What is printed and what a filter matches.
        command: Argument list.
        environment: Variables beyond the inherited ones.
        counted: Whether the job leaves JUnit files; if not, its exit status is its one result.
    """

    stage: str
    name: str
    command: tuple
    environment: dict = field(default_factory=dict)
    counted: bool = True

    @property
    def directory(self):
        """Where the job's log and JUnit files go."""
        return results_directory(self.stage, self.name)


@dataclass
class Outcome:
    """What came of a job: counts, and the names of what failed."""

    passed: int = 0
    skipped: int = 0
    failures: list = field(default_factory=list)


def results_directory(stage, name):
    """Gives the directory of a job's log and JUnit files."""
    return RESULTS / stage / name.replace("/", "-")


def package_of(path):
    """Gives name and directory of the catkin package that a file belongs to."""
    for directory in path.parents:
        if (directory / "package.xml").is_file():
            return ElementTree.parse(directory / "package.xml").findtext("name"), directory
    raise LookupError(f"{path}: no package.xml in any directory above")


def unit_jobs():
    """One pytest per test directory: packages stay apart, their test files may share names."""
    directories = sorted({path.parent for path in ROOT.glob("src/**/test/test_*.py")})
    own = {ROOT / "tests" / "unit": "project", ROOT / "tests" / "physics": "physics"}
    for directory in [*own, *directories]:
        package = own.get(directory, directory.parent.name)
        report_file = results_directory("unit", package) / "pytest.xml"
        yield Job(
            "unit",
            package,
            (
                sys.executable,
                "-m",
                "pytest",
                "-q",
                "-p",
                "no:cacheprovider",
                "--color=no",
                f"--rootdir={directory}",
                f"--junitxml={report_file}",
                str(directory),
            ),
        )


def lint_jobs():
    """catkin_lint over all packages; warnings count as errors."""
    yield Job(
        "lint",
        "catkin_lint",
        (tool("catkin_lint"), "--strict", "-W1", str(ROOT / "src")),
        counted=False,
    )


def ros_jobs():
    """One rostest per .test file; rostest gives each a master on a port of its own."""
    files = sorted(ROOT.glob("tests/ros/*.test")) + sorted(ROOT.glob("src/**/test/*.test"))
    for path in files:
        package, directory = package_of(path)
        name = path.stem if package == "paddock_tests" else f"{package}/{path.stem}"
        results = results_directory("ros", name)
        yield Job(
            "ros",
            name,
            (tool("rostest"), f"--package={package}", f"--pkgdir={directory}", str(path)),
            {"ROS_TEST_RESULTS_DIR": str(results), "ROS_LOG_DIR": str(results / "log")},
        )


def tool(name):
    """Gives the path of a command that must be there."""
    path = shutil.which(name)
    if path is None:
        raise LookupError(f"{name} is not installed; config/apt.txt should bring it (./run setup)")
    return path


def run_job(job):
    """Runs a job to its end or its deadline and counts what it left.

    Returns:
        Outcome.
    """
    shutil.rmtree(job.directory, ignore_errors=True)
    job.directory.mkdir(parents=True)
    log = job.directory / "output.txt"
    environment = dict(os.environ, **job.environment)
    late = False
    with log.open("w") as stream:
        process = subprocess.Popen(
            job.command,
            stdout=stream,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            cwd=ROOT,
            env=environment,
            start_new_session=True,
        )
        try:
            status = process.wait(DEADLINES[job.stage])
        except subprocess.TimeoutExpired:
            late = True
            status = stop(process)
        except BaseException:
            stop(process)
            raise
    outcome = count(job.directory) if job.counted else Outcome()
    if late:
        outcome.failures.append(f"did not end within {DEADLINES[job.stage]:g} s")
    elif status != 0 and not outcome.failures:
        outcome.failures.append(f"{Path(job.command[0]).name} ended with exit status {status}")
    elif job.counted and outcome.passed + outcome.skipped + len(outcome.failures) == 0:
        outcome.failures.append("the runner ran no test at all")
    elif not job.counted and not outcome.failures:
        outcome.passed = 1
    return outcome


def stop(process):
    """Ends a job's process group: first as Ctrl-C would, then for good.

    Returns:
        Its exit status.
    """
    for number, grace in ((signal.SIGINT, STOP_GRACE), (signal.SIGKILL, STOP_GRACE)):
        try:
            os.killpg(process.pid, number)
        except ProcessLookupError:
            pass
        try:
            return process.wait(grace)
        except subprocess.TimeoutExpired:
            continue
    return -signal.SIGKILL


def count(directory):
    """Adds up the JUnit files below a directory."""
    outcome = Outcome()
    for path in sorted(directory.rglob("*.xml")):
        try:
            cases = list(ElementTree.parse(path).iter("testcase"))
        except ElementTree.ParseError as error:  # the runner died while it wrote
            outcome.failures.append(f"{path.name} is no complete JUnit file: {error}")
            continue
        for case in cases:
            problem = (
                case.find("failure") if case.find("failure") is not None else case.find("error")
            )
            if problem is not None:
                text = (problem.get("message") or problem.text or "").strip()
                outcome.failures.append(f"{case.get('classname')}.{case.get('name')}: {text}")
            elif case.find("skipped") is not None:
                outcome.skipped += 1
            elif case.get("classname") != "rostest.runner.RosTest":  # that one is the wrapper
                outcome.passed += 1
    return outcome


def report(job, outcome, seconds):
    """Prints a job's line, and for a failure what failed and the end of its log."""
    word = "FAILED" if outcome.failures else "ok"
    skipped = f", {outcome.skipped} skipped" if outcome.skipped else ""
    print(
        f"{word} ({outcome.passed} passed, {len(outcome.failures)} failed{skipped},"
        f" {seconds:.1f} s)",
        flush=True,
    )
    if not outcome.failures:
        return
    for failure in outcome.failures:
        print("    - " + failure.splitlines()[0])
    log = job.directory / "output.txt"
    print(f"    the end of {log.relative_to(ROOT)}:")
    for line in log.read_text(errors="replace").splitlines()[-40:]:
        print("    | " + line)
    sys.stdout.flush()


def selected(jobs, filters):
    """Keeps jobs whose stage is a filter or whose name contains one; all without filters."""
    return [
        job
        for job in jobs
        if not filters or any(word == job.stage or word in job.name for word in filters)
    ]


def main():
    """Runs the selected jobs; exit status 0 only if something ran and nothing failed."""
    parser = argparse.ArgumentParser(prog="./run test")
    parser.add_argument("filters", nargs="*", metavar="FILTER")
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    try:
        everything = [*unit_jobs(), *lint_jobs(), *ros_jobs()]
    except LookupError as error:
        sys.exit(f"run test: {error}")
    jobs = selected(everything, options.filters)
    if not jobs:
        names = ", ".join(job.name for job in everything)
        sys.exit(
            f"run test: nothing matches {' '.join(options.filters)!r}; there are the stages "
            f"unit, lint, ros, and the tests {names}"
        )
    if options.list:
        print("\n".join(f"{job.stage:5} {job.name}" for job in jobs))
        return
    paths = (str(ROOT / "tests"), os.environ.get("ROS_PACKAGE_PATH", ""))
    os.environ["ROS_PACKAGE_PATH"] = os.pathsep.join(paths)
    RESULTS.mkdir(exist_ok=True)
    started = time.monotonic()
    passed, skipped, failures = 0, 0, []
    for number, job in enumerate(jobs, 1):
        print(f"[{number}/{len(jobs)}] {job.stage} {job.name} ... ", end="", flush=True)
        begin = time.monotonic()
        outcome = run_job(job)
        report(job, outcome, time.monotonic() - begin)
        passed += outcome.passed
        skipped += outcome.skipped
        failures += [f"{job.stage} {job.name}: {text.splitlines()[0]}" for text in outcome.failures]
    if failures:
        print("\nfailed:")
        print("\n".join("  " + line for line in failures))
    print(f"\nlogs in {RESULTS.relative_to(ROOT)}/, {time.monotonic() - started:.0f} s")
    print(f"{passed} passed, {len(failures)} failed" + (f", {skipped} skipped" if skipped else ""))
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)

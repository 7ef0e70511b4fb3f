"""The table of all jobs: unit tests, linters, rostests; soak, trainings, browsers when asked."""

import importlib.util
import shutil
import sys
import xml.etree.ElementTree as ElementTree

from runner.job import ROOT, WAITS, Job, results_directory

# Stages that take minutes, or install more -> the name of their pytest job.
EXTRA = {"learning": "training", "desk": "browser", "tutorials": "pages", "long": "drives"}
ASKED = {*EXTRA, "soak"}  # stages that run only when they are asked for
# Jobs that wait for people's time (keys that are held, time-outs), for processes that start one
# after the other or for a package index, and not for the processor.
WAITING = (
    "back_faults",
    "check",
    "joystick",
    "keyboard",
    "keyboard_starts",
    "keyboard_x",
    "project",
)

SOAKING = 2  # slots: a dozen processes that are busy


def all_jobs():
    """Gives every job of the project.

    Raises:
        LookupError: A runner is not installed.
    """
    return [*unit_jobs(), *lint_jobs(), *ros_jobs(), soak_job(), *extra_jobs()]


def selected(jobs, filters):
    """Keeps jobs whose stage is a filter or whose name contains one.

    Without filters all are kept but those of ASKED stages.
    """
    return [
        job
        for job in jobs
        if (not filters and job.stage not in ASKED)
        or any(word == job.stage or word in job.name for word in filters)
    ]


def unit_jobs():
    """One pytest per test directory: packages stay apart, their test files may share names."""
    directories = sorted({path.parent for path in ROOT.glob("src/**/test/test_*.py")})
    own = {ROOT / "tests" / "unit": "project", ROOT / "tests" / "physics": "physics"}
    for directory in [*own, *directories]:
        yield pytest_job("unit", own.get(directory, directory.parent.name), directory)


def lint_jobs():
    """Linters of packages, Python and bash; each warning is an error."""
    catkin_lint = (tool("catkin_lint"), "--strict", "-W1", str(ROOT / "src"))
    scripts = [str(ROOT / name) for name in ("run", "setup.bash", ".ci/run")]
    for name, command in {
        "catkin_lint": catkin_lint,
        "ruff_check": (*module("ruff"), "check", "--no-cache"),
        "ruff_format": (*module("ruff"), "format", "--check", "--no-cache"),
        "mypy": (*module("mypy"), "--no-incremental"),
        "shellcheck": (tool("shellcheck"), *scripts),
    }.items():
        yield Job("lint", name, command, counted=False)


def ros_jobs():
    """One rostest per .test file, with a master on a port of its own; those of stage long, too."""
    files = [
        path
        for pattern in ("tests/ros/*.test", "tests/long/*.test", "src/**/test/*.test")
        for path in sorted(ROOT.glob(pattern))
    ]
    for path in files:
        package, directory = package_of(path)
        name = path.stem if package == "paddock_tests" else f"{package}/{path.stem}"
        stage = "long" if path.parent.name == "long" else "ros"
        results = results_directory(stage, name)
        yield Job(
            stage,
            name,
            (tool("rostest"), f"--package={package}", f"--pkgdir={directory}", str(path)),
            {"ROS_TEST_RESULTS_DIR": str(results), "ROS_LOG_DIR": str(results / "log")},
            slots=slots_of(name),
        )


def soak_job():
    """Two minutes of ./run soak, which leave their page among the results."""
    results = results_directory("soak", "soak")
    options = ("--minutes", "2", "--seed", "1", "--folder", str(results))
    command = (sys.executable, str(ROOT / "bench" / "soak.py"), *options)
    return Job("soak", "soak", command, counted=False, slots=SOAKING)


def extra_jobs():
    """Trainings, the desk in Chromium, the tutorials' commands, long drives: one pytest each."""
    for stage, name in EXTRA.items():
        yield pytest_job(stage, name, ROOT / "tests" / stage)


def pytest_job(stage, name, directory):
    """Gives a job that runs a directory's pytest files."""
    report_file = results_directory(stage, name) / "pytest.xml"
    options = ("-q", "-p", "no:cacheprovider", "--color=no", f"--rootdir={directory}")
    command = (sys.executable, "-m", "pytest", *options, f"--junitxml={report_file}")
    return Job(stage, name, (*command, str(directory)), slots=slots_of(name))


def slots_of(name):
    """Gives as how many jobs one counts among those that run side by side."""
    return WAITS if name in WAITING else 1


def package_of(path):
    """Gives name and directory of the catkin package that a file belongs to."""
    for directory in path.parents:
        if (directory / "package.xml").is_file():
            return ElementTree.parse(directory / "package.xml").findtext("name"), directory
    raise LookupError(f"{path}: no package.xml in any directory above")


def tool(name):
    """Gives the path of a command that must be there."""
    path = shutil.which(name)
    if path is None:
        raise LookupError(f"{name} is not installed; config/apt.txt should bring it (./run setup)")
    return path


def module(name):
    """Gives the words that start a Python module that must be there."""
    if importlib.util.find_spec(name) is None:
        raise LookupError(
            f"{name} is not installed; config/requirements.txt or config/apt.txt should bring it "
            "(./run setup)"
        )
    return sys.executable, "-m", name

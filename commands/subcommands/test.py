"""Runs the tests with pytest: unit tests, linters, and nodes on ROS graphs of their own.

FILTER is unit, lint, ros, the name of a folder (./run test standins: all tests below it) or part of
a file's name (./run test circle, ./run test bullet_sim). Seven stages run only when they are asked
for: ./run test soak (two minutes of ./run soak, as CI does), ./run test learning (trainings; it
installs torch, Ray and Optuna), ./run test desk and ./run test web (the desk and the page in
Chromium, which they install), ./run test tutorials (what the tutorials say to type) and ./run test
long (laps by each driver, longer drives, all keys, the install space; CI runs it), ./run test cpp
(plugins in C++, for which it brings Gazebo's libraries). What else starts
with a dash goes to pytest, such as -x or --durations=50. JUnit's file, logs and the launch files of
ROS tests are in test-results/. At the end come the slowest tests, the flaky ones (failed and passed
in their last ten runs) and what failed. The last line is the sum; the exit status is 0 only if
nothing failed.
"""

import os
import re

from commands import bootstrap, environment, processes
from commands.parsing import whole_number
from commands.paths import ROOT, SOURCES, VENV_PYTHON

USAGE = "[FILTER ...] [OPTIONS]"
PASSES_ON = True
STAGES = ("unit", "lint", "ros", "soak", "learning", "desk", "web", "tutorials", "long", "cpp")
RESULTS = os.path.join(ROOT, "test-results")
CPU_QUOTA = "/sys/fs/cgroup/cpu.max"  # "QUOTA PERIOD" [us], or "max PERIOD"
VALUED = ("-k", "-m", "-o", "-p", "-W", "--maxfail", "--deselect")  # of pytest, a value behind each
NAME_LIMIT = 200  # characters of the name of JUnit's file, which a file system limits to 255
MORE = 2  # processes than cores: ROS tests wait for processes that start, and for simulated time
BROWSER = 2  # cores of one browser that renders 3-D in software, and of its world


def add_arguments(parser):
    """Declares the options, for help and completion."""
    parser.add_argument(
        "-j",
        "--jobs",
        metavar="N",
        help="processes that run tests; by default two more than cores, of web one for two cores",
    )
    parser.add_argument("--failed", action="store_true", help="run what failed when it last ran")
    parser.add_argument("--list", action="store_true", help="only print the names")


def run(arguments):
    """Becomes pytest."""
    words, filters = options(arguments)
    bootstrap.need_own()
    environ = environment.ready()
    prepare_stages(filters)
    if "--collect-only" not in words:
        os.makedirs(RESULTS, exist_ok=True)
        words += ["--durations=10", "--durations-min=1", f"--junitxml={report(filters)}"]
    words += [word for name in filters for word in ("--select", name)]
    environ.pop("PYTHONDONTWRITEBYTECODE", None)  # see conftest.py
    processes.become([VENV_PYTHON, "-m", "pytest", f"--rootdir={ROOT}", "-q", *words], environ)


def report(filters):
    """Returns the path of JUnit's file."""
    name = "-".join(["junit", *filters]).replace("/", "-")
    return os.path.join(RESULTS, f"{name[:NAME_LIMIT]}.xml")


def options(arguments):
    """Reads the command line.

    Returns:
        Words for pytest, filters.

    Raises:
        UsageError: N is no whole number above 0.
    """
    words, filters, jobs, count = [], [], None, whole_number("-j N: N")
    rest = iter(arguments)
    for word in rest:
        if word in ("-j", "--jobs"):
            jobs = count(next(rest, ""))
        elif word.startswith(("-j", "--jobs=")):
            jobs = count(re.sub("^(--jobs=|-j)", "", word))
        elif word == "--failed":
            words += ["--last-failed", "--last-failed-no-failures=none"]
        elif word == "--list":
            words.append("--collect-only")
        elif word in VALUED:
            words += [word, next(rest, "")]
        elif word.startswith("-"):
            words.append(word)
        else:
            filters.append(word)
    if "--collect-only" not in words:
        words.append(f"--numprocesses={jobs or usual_jobs(filters)}")
    return words, filters


def usual_jobs(filters):
    """Returns the number of processes where none is given."""
    return max(1, cores() // BROWSER) if "web" in filters else cores() + MORE


def cores(quota=CPU_QUOTA):
    """Returns the number of cores that this process may use, at least 1.

    Args:
        quota: File with the control group's limit (cgroup v2), which a container may have.
    """
    number = len(os.sched_getaffinity(0))
    try:
        with open(quota, encoding="ascii") as stream:
            limit, period = stream.read().split()
        number = min(number, round(int(limit) / int(period)))
    except (OSError, ValueError):  # no such file, or "max": no limit
        pass
    return max(1, number)


def prepare_stages(filters):
    """Installs what tests need beyond ./run setup, those that have to be asked for some more."""
    from commands.bootstrap import packages, venv

    more = ("learning", "ray", "sweep", "tensorboard") if "learning" in filters else ()
    venv.prepare_extras("test", "lint", "gym", *more)
    packages.prepare(packages.DESK_SERVER_LIST)
    if "desk" in filters:
        packages.prepare(packages.DESK_LIST, packages.DESK_TEST_LIST)
    if "web" in filters:
        packages.prepare(packages.DESK_TEST_LIST)
    if "cpp" in filters:
        from commands import gazebo_libraries

        gazebo_libraries.add()
        bootstrap.prepare()


def complete(_words):
    """Lists the stages, the files of ROS tests and the packages with unit tests."""
    import glob

    files = glob.glob(f"{ROOT}/tests/ros/test_*.py")
    names = {os.path.basename(path)[5:-3] for path in files}
    folders = {
        os.path.dirname(path) for path in glob.glob(f"{SOURCES}/**/test/test_*.py", recursive=True)
    }
    names |= {os.path.basename(os.path.dirname(folder)) for folder in folders}
    return [*STAGES, *sorted(names | {"project", "physics"})]

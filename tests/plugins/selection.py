"""Which tests run, in which order: `./run test FILTER`, the longest files first, flaky tests.

Each folder of tests belongs to a stage, which is a marker, too. A filter is a stage, the name of a
folder that the file is below, or part of the file's name, such as standins, circle, bullet_sim or
bullet_sim/test_skid.
"""

import functools
import gc
import json
import pathlib
import re

import pytest

STAGES = {  # stage -> what it holds
    "unit": "one process, no ROS graph",
    "lint": "linters",
    "ros": "nodes on a ROS graph",
    "soak": "two minutes of ./run soak",
    "learning": "trainings",
    "desk": "the desk in Chromium",
    "web": "the page in Chromium",
    "tutorials": "the commands of docs/tutorials",
    "long": "laps, longer drives, all keys, the install space",
    "cpp": "plugins in C++",
}
ASKED = {
    "soak",
    "learning",
    "desk",
    "web",
    "tutorials",
    "long",
    "cpp",
}  # that run only when they are asked for
STANDINS = ("src", "standins")  # the folder of theirs
SECONDS = "paddock/seconds"  # in pytest's cache: file -> wall time of its tests in the last run [s]
WORLD = re.compile(r"^from shared_worlds import (\w+) as LAUNCH\b", re.MULTILINE)
OUTCOMES = "paddock/outcomes"  # there: test that has failed -> whether it passed, run by run
RUNS = 10  # of a test that are kept
# Wall time of files of tests [s], until a run here has measured them: those of a run on a bare
# Debian with two busy cores, copied from pytest's cache.
EXPECTED = json.loads(pathlib.Path(__file__).with_name("seconds.json").read_text())


def pytest_addoption(parser):
    """Declares the filters."""
    parser.addoption(
        "--select", action="append", default=[], metavar="FILTER", help="see selection.py"
    )


def pytest_configure(config):
    """Registers a marker for each stage, and what the last runs have told."""
    # The order is that of pytest_collection_modifyitems(). The pytest-xdist for Python 3.8 does not
    # know this: it puts the files with most tests first.
    config.option.loadscopereorder = False
    for stage, text in STAGES.items():
        config.addinivalue_line("markers", f"{stage}: {text}")
    if hasattr(config, "cache") and not hasattr(config, "workerinput"):
        config.pluginmanager.register(Memory(config), "memory-of-runs")


@functools.lru_cache(maxsize=None)
def stage_of(path, root):
    """The stage of a test file or of a folder of them; None of other folders."""
    parts = path.relative_to(root).parts
    if parts[:1] == ("src",):
        return "unit"
    if parts[:1] != ("tests",) or len(parts) == 1:
        return None
    return "unit" if parts[1] == "physics" else parts[1] if parts[1] in STAGES else None


def name_of(path, root):
    """What a filter is looked for in: package and file, such as bullet_sim/test_skid."""
    parts = path.relative_to(root).parts
    if parts[0] == "src":
        return f"{path.parent.parent.name}/{path.stem}"
    stage = parts[1]
    name = re.sub("^test_", "", path.stem)
    return name if stage == "ros" else f"{ {'unit': 'project'}.get(stage, stage) }/{path.stem}"


def pytest_ignore_collect(collection_path, config):
    """Leaves out files that no filter matches, stages that are not asked for, and the tests of
    stand-ins that give way to real packages of the ROS below: what they test is not there."""
    root = config.rootpath
    if root not in collection_path.parents or collection_path in given_paths(config):
        return None
    stage, filters = stage_of(collection_path, root), config.option.select
    if stage is None:
        return None
    standin = pathlib.Path(*collection_path.relative_to(root).parts[:3])
    if standin.parts[:2] == STANDINS and (root / standin / "CATKIN_IGNORE").exists():
        return True
    if stage in ASKED and stage not in filters:
        inside = any(
            collection_path in (p, *p.parents) or p in collection_path.parents
            for p in given_paths(config)
        )
        return None if inside else True
    if filters and collection_path.is_file() and stage not in filters and stage != "lint":
        name, folders = name_of(collection_path, root), collection_path.relative_to(root).parts[:-1]
        words = [word for word in filters if word not in STAGES]
        return None if any(word in name or word in folders for word in words) else True
    return None


def given_paths(config):
    """Paths on the command line."""
    if config.args_source is not pytest.Config.ArgsSource.ARGS:
        return []
    return [
        (config.invocation_params.dir / str(word).split("::")[0]).resolve() for word in config.args
    ]


@pytest.hookimpl(tryfirst=True)
def pytest_collection():
    """Keeps the garbage collector from what is imported: a third of the time of collecting."""
    gc.disable()


@pytest.hookimpl(trylast=True)
def pytest_collection_finish():
    """Lets it look at what tests make from now on."""
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(config, items):
    """Marks tests with their stage, leaves out linters, puts the longest files first."""
    filters = config.option.select
    cached = config.cache.get(SECONDS, {}) if hasattr(config, "cache") else {}
    seconds = {**EXPECTED, **cached}
    left_out = []
    for item in items:
        stage = stage_of(item.path, config.rootpath)
        if stage:
            item.add_marker(stage)
        if stage == "lint" and filters and not {"lint"} & set(filters):
            if not any(word in item.name for word in filters):
                left_out.append(item)
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]
    units, first = {}, {}  # what runs one after the other: file or world -> wall time, place
    places = {}  # of each file, by which items are sorted
    for number, path in enumerate(dict.fromkeys(item.path for item in items)):
        unit = unit_of(path)
        units[unit] = units.get(unit, 0.0) + expected(path, config.rootpath, seconds)
        first.setdefault(unit, number)
        places[path] = unit
    places = {path: (-units[unit], first[unit]) for path, unit in places.items()}
    items.sort(key=lambda item: places[item.path])


@functools.lru_cache(maxsize=None)
def world_of(path):
    """Name in shared_worlds.py of the launch that a file of tests shares with others, or None."""
    if not path.is_file():
        return None
    found = WORLD.search(path.read_text(encoding="utf-8"))
    return found and found.group(1)


def unit_of(path):
    """What one process runs in one go: the world that a file shares, or the file."""
    return world_of(path) or str(path)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Gives a process files, or all files of a world, one unit after the other."""
    from xdist.scheduler import LoadScopeScheduling

    class ByUnit(LoadScopeScheduling):
        """As --dist=loadfile, but for files that share a world."""

        def _split_scope(self, nodeid):
            return unit_of(config.rootpath / nodeid.split("::")[0])

    return ByUnit(config, log)


def expected(path, root, seconds):
    """Wall time of a file's tests [s]."""
    default = 10.0 if stage_of(path, root) in ("ros", "long") else 1.0
    return seconds.get(str(path.relative_to(root)), default) if root in path.parents else 0.0


class Memory:
    """Remembers how long files took, and which tests have failed and passed."""

    def __init__(self, config):
        self._config = config
        self._seconds, self._passed = {}, {}

    def pytest_runtest_logreport(self, report):
        """Counts a report."""
        file = report.nodeid.split("::")[0]
        self._seconds[file] = self._seconds.get(file, 0.0) + report.duration
        self._passed[report.nodeid] = self._passed.get(report.nodeid, True) and not report.failed

    def pytest_terminal_summary(self, terminalreporter, exitstatus):
        """Stores it; prints the flaky tests, and what a filter can be where none matches."""
        filters = self._config.option.select
        if filters and exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
            terminalreporter.write_line(
                f"nothing matches {', '.join(map(repr, filters))}; there are the stages "
                f"{', '.join(STAGES)}, and parts of files' names: ./run test --list"
            )
        cache = self._config.cache
        rounded = {file: round(seconds, 1) for file, seconds in self._seconds.items()}
        cache.set(SECONDS, {**cache.get(SECONDS, {}), **rounded})
        outcomes = cache.get(OUTCOMES, {})
        for test, passed in self._passed.items():
            if test in outcomes or not passed:
                outcomes[test] = [*outcomes.get(test, []), passed][-RUNS:]
        outcomes = {test: runs for test, runs in outcomes.items() if not all(runs)}
        cache.set(OUTCOMES, outcomes)
        for test, runs in outcomes.items():
            if test in self._passed and any(runs):
                terminalreporter.write_line(
                    f"flaky: {test} failed in {runs.count(False)} of its last {len(runs)} runs"
                )

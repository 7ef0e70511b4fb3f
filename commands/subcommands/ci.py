"""Builds and tests the packages at and below PATH as a CI does it: from nothing to JUnit files.

Sets up what is missing, installs the Debian packages that their package.xml files ask for (as root
or through sudo), builds them in a workspace of its own on top of this one, and runs what is in
their folders test/ and tests/: each .test by rostest, test_*.py by pytest. JUnit files and logs go
to --out, and so does what tests write to the folder PADDOCK_RESULTS, such as films. Exits 0 only if
at least one test ran and none failed. docs/ci.md has a workflow file.
"""

import glob
import hashlib
import os
import shutil
import subprocess
import time
import xml.etree.ElementTree as ElementTree

from commands import environment, locks, processes
from commands.errors import CommandError, UsageError, say
from commands.paths import KEPT, SYSTEM_PATH, VENV_PYTHON, tail
from commands.subcommands import deps

USAGE = "[--out FOLDER] [PATH]"
FOLDERS = ("test", "tests")
LOG_LINES = 40  # shown of the log of what failed
WRAPPER = "rostest.runner.RosTest"  # rostest's own case around the cases of a test node
DEADLINE = 1200.0  # of one file of tests [s]


def add_arguments(parser):
    """Declares path and --out."""
    parser.add_argument(
        "path", nargs="?", default=".", metavar="PATH", help="a package or a workspace (.)"
    )
    parser.add_argument(
        "--out", default="paddock-results", metavar="FOLDER", help="of results (paddock-results)"
    )


def run(options, _rest):
    """Builds and tests.

    Raises:
        CommandError: Something does not build, or a test failed.
    """
    from commands.bootstrap import venv

    if not os.path.isdir(options.path):
        raise UsageError(f"path is {options.path!r}; it must be a folder")
    workspace = Workspace(options.path)
    environ = environment.ready()
    venv.prepare_extras("test")
    install_dependencies(options.path, environ)
    tests = Tests(workspace, environ, options.out)
    workspace.build(tests.run_logged, environ)
    tests.run()
    say(f"results in {options.out}/: {tests.passed} passed, {len(tests.failed)} files failed")
    if tests.failed:
        raise CommandError(f"tests failed: {', '.join(tests.failed)}")
    if not tests.passed:
        raise CommandError(
            "there is no test to run", "Put a .test or test_*.py into the package's folder test/"
        )


class Workspace:
    """The packages at and below a folder, in .cache/ci.

    Attributes:
        packages: Dict from name to folder.
        setup: Path of its setup.bash, once it is built.
    """

    def __init__(self, folder):
        """Links the packages into it.

        Raises:
            UsageError: It has none.
            CommandError: Another ./run builds them.
        """
        files = deps.find_manifests(os.path.realpath(folder))
        self.packages = {deps.read_manifest(path)[0]: os.path.dirname(path) for path in files}
        name = hashlib.sha256(os.path.realpath(folder).encode()).hexdigest()[:12]
        self._root = os.path.join(KEPT, "ci", name)
        self.setup = os.path.join(self._root, "devel", "setup.bash")
        locks.take_results(self._root)
        sources = os.path.join(self._root, "src")
        shutil.rmtree(sources, ignore_errors=True)  # links only
        os.makedirs(sources)
        for package, place in self.packages.items():
            os.symlink(place, os.path.join(sources, package))

    def build(self, run, environ):
        """Builds it.

        Raises:
            CommandError: It does not build.
        """
        command = ["catkin_make", "-C", self._root, f"-DPYTHON_EXECUTABLE={VENV_PYTHON}"]
        if run("build", command, environ) != 0:
            raise CommandError("the packages do not build", "What the compiler said is above.")

    def command(self, words):
        """Returns the command line that runs something with the workspace active."""
        return ["bash", "-c", '. "$0" && exec "$@"', self.setup, *words]


def install_dependencies(folder, environ):
    """Installs the Debian packages that package.xml files ask for; says what there is none of.

    Raises:
        CommandError: apt-get failed.
    """
    answer = deps.find(folder)
    for name, askers in answer.nowhere.items():
        say(f"neither Debian nor Paddock has {name}, which {', '.join(askers)} asks for")
    names = deps.to_install(answer)
    if not names:
        return
    say(f"Debian packages: {' '.join(names)}")
    as_root = [] if os.geteuid() == 0 else ["sudo"]
    variables = ["env", "DEBIAN_FRONTEND=noninteractive", f"PATH={SYSTEM_PATH}"]
    install = ["apt-get", "install", "-qq", "-y", "--no-install-recommends", *names]
    if processes.run_child([*as_root, *variables, *install], env=environ, session=False) != 0:
        raise CommandError("apt-get could not install them", f"As root: {' '.join(install)}")


class Tests:
    """Runs tests and keeps what they leave.

    Attributes:
        failed: Names of the files of tests that failed.
    """

    def __init__(self, workspace, environ, out):
        """Makes the folder of the results.

        Args:
            out: Folder: NAME.xml and NAME.txt of each file of tests; what tests write to
                PADDOCK_RESULTS, such as films.
        """
        self._workspace, self._out = workspace, os.path.realpath(out)
        self._environ = {
            **environ,
            "PADDOCK_RESULTS": self._out,
            "QT_QPA_PLATFORM": "offscreen",
            "ROS_IP": "127.0.0.1",
        }
        self._environ.pop("ROS_HOSTNAME", None)
        self.failed, self.passed = [], 0
        locks.take_results(self._out)
        os.makedirs(self._out, exist_ok=True)

    def run_logged(self, name, command, environ, deadline=None):
        """Runs a command; its output goes to NAME.txt, and its end is shown if it fails.

        Returns:
            Its exit status; None past the deadline [s].
        """
        log = os.path.join(self._out, f"{name}.txt")
        begin = time.monotonic()
        with open(log, "wb") as stream:
            try:
                status = processes.run_child(
                    command,
                    deadline=deadline,
                    env=environ,
                    stdin=subprocess.DEVNULL,
                    stdout=stream,
                    stderr=subprocess.STDOUT,
                )
            except processes.DeadlineExceeded:
                status = None
        word = "ok" if status == 0 else "FAILED"
        say(f"{name} ... {word} ({time.monotonic() - begin:.0f} s)")
        if status != 0:
            for line in tail(log, LOG_LINES):
                say(f"    | {line}")
        return status

    def run(self):
        """Runs every test of every package."""
        for package, folder in self._workspace.packages.items():
            for path in _files(folder, "*.test"):
                self._run(f"{package}-{_stem(path)}", package, folder, path)
            units = _files(folder, "test_*.py")
            if units:
                self._run(f"{package}-unit", package, folder, *units)

    def _run(self, name, package, folder, *paths):
        results = os.path.join(self._out, f"{name}.results")
        shutil.rmtree(results, ignore_errors=True)
        if paths[0].endswith(".test"):
            words = ["rostest", f"--package={package}", f"--pkgdir={folder}", *paths]
        else:
            report = os.path.join(results, "pytest.xml")
            words = [VENV_PYTHON, "-m", "pytest", "-q", f"--junitxml={report}", *paths]
        environ = {**self._environ, "ROS_TEST_RESULTS_DIR": results}
        environ["ROS_LOG_DIR"] = os.path.join(results, "log")
        status = self.run_logged(name, self._workspace.command(words), environ, DEADLINE)
        passed, failures = counted(results)
        for failure in failures:
            say(f"    - {failure}")
        self.passed += passed
        if status != 0 or failures or not passed:
            self.failed.append(name)
            if status == 0 and not failures:
                say("    - no test ran")
        _gather(results, os.path.join(self._out, name))


def counted(folder):
    """Counts the JUnit files below a folder.

    Returns:
        (number of tests that passed, first lines of those that failed).
    """
    passed, failures = 0, []
    for path in sorted(glob.glob(f"{folder}/**/*.xml", recursive=True)):
        try:
            cases = list(ElementTree.parse(path).iter("testcase"))
        except ElementTree.ParseError as error:  # the runner died while it wrote
            failures.append(f"{os.path.basename(path)} is no complete JUnit file: {error}")
            continue
        for case in cases:
            problems = [problem for name in ("failure", "error") for problem in case.iter(name)]
            if problems:
                text = (problems[0].get("message") or problems[0].text or "").strip()
                name = f"{case.get('classname')}.{case.get('name')}"
                failures.append(f"{name}: {text}".partition("\n")[0])
            elif case.find("skipped") is None and case.get("classname") != WRAPPER:
                passed += 1
    return passed, failures


def _gather(results, target):
    """Moves the JUnit files next to each other and drops the rest."""
    paths = sorted(glob.glob(f"{results}/**/*.xml", recursive=True))
    for number, path in enumerate(paths):
        shutil.move(path, f"{target}{f'-{number}' if number else ''}.xml")
    shutil.rmtree(results, ignore_errors=True)


def _files(folder, pattern):
    return sorted(p for name in FOLDERS for p in glob.glob(os.path.join(folder, name, pattern)))


def _stem(path):
    return os.path.splitext(os.path.basename(path))[0]

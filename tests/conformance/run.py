"""Runs test suites of the packages that Paddock stands in for, from clones that you bring.

    ./run exec python tests/conformance/run.py --sources FOLDER [--clients FOLDER]
        [--pace F] [SUITE ...]

--sources has a clone of each repository (branch noetic-devel), e.g. FOLDER/ros_control; --clients
has the test programs in C++ that you have compiled, as FOLDER/PACKAGE/NAME, which is how a
workspace's devel/lib has them. Launch files and scripts of a suite are copied into a package in a
temporary folder; `$(find PACKAGE)/test` and the package of its test programs become that package,
and a robot in C++ becomes Paddock with a robot of this folder. Nothing else is changed, and nothing
is written into the clones. Prints a table and what did not pass, and to standard error what each
file came to; exits 0 if all passed.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from suites import SUITES, WITHOUT  # noqa: E402

LIMIT = 600.0  # time of one launch file or module [s], wall time at a real-time factor of 1
PACE = "CONFORMANCE_PACE"  # variable with the real-time factor, which launch files of robots read
SHOWN = 300  # characters of a failure
PACKAGE = """<package format="2"><name>{name}</name><version>0.0.1</version>
<description>tests</description><maintainer email="a@b.org">a</maintainer>
<license>BSD</license></package>
"""


@dataclass(frozen=True)
class Case:
    """One test: its name and why it did not pass; "": it passed."""

    name: str
    reason: str = ""


def rewrite(text, suite, package, copied, programs):
    """A launch file of a suite, for the copies of its test files.

    Args:
        package: name of the suite's package.
        copied: name of the package with the copies.
        programs: names of the copied scripts and of the compiled programs.
    """
    text = text.replace(f"$(find {package})/test", f"$(find {copied})/test")
    limit = LIMIT / float(os.environ.get(PACE, "1")) - 60.0
    for (owner, kind), launch in suite.nodes.items():
        file, *arguments = shlex.split(launch)
        include = f'<include file="{HERE / file}">'
        for argument in arguments:
            name, _, value = argument.partition(":=")
            include += f'<arg name="{name}" value="{value}"/>'
        pattern = rf'<node\b(?=[^>]*pkg="{owner}")(?=[^>]*type="{kind}")[^>]*/>'
        text = re.sub(pattern, include + "</include>", text)

    def owned(match):
        kind = re.search(r'type="([^"]*)"', match.group(0))
        if kind is None or kind.group(1) not in programs:
            return match.group(0)
        tag = match.group(0).replace(f'pkg="{package}"', f'pkg="{copied}"')
        if tag.startswith("<test"):
            if suite.service:
                tag = f'<test launch-prefix="{HERE / "wait_for"} {suite.service}"' + tag[5:]
            # rostest's own limit is 60 s, and a simulator starts slower than a robot in C++
            tag = re.sub(r'\s*time-limit="[^"]*"', "", tag)
            tag = f'<test time-limit="{limit:g}"' + tag[5:]
        return tag

    text = re.sub(r"<(?:test|node)\b[^>]*>", owned, text)
    pace = os.environ.get(PACE, "1")
    if suite.simulator and float(pace) < 1.0:
        slower = f'<param name="/{suite.simulator}/real_time_factor" value="{pace}"/>'
        text = text.replace("</launch>", f"  {slower}\n</launch>")
    return text


def copy_package(suite, sources, package, folder, clients=None):
    """Copies the test files of a suite into a package; returns (its folder, its name).

    Args:
        clients: folder of the compiled test programs; None: there are none.
    """
    name = package if suite.own_name else f"conformance_{package}"
    source = sources / suite.repository / suite.package
    target = folder / name
    for each in suite.folders:
        shutil.copytree(source / each, target / each)
    (target / "package.xml").write_text(PACKAGE.format(name=name), encoding="utf-8")
    files = [path for path in target.rglob("*") if path.is_file()]
    scripts = {path.name for path in files if path.read_bytes().startswith(b"#!")}
    programs = set(scripts)
    if clients is not None and (clients / package).is_dir():
        shutil.copytree(clients / package, target / "clients")
        programs |= {path.name for path in (target / "clients").iterdir()}
    for path in files:
        if path.name in scripts:
            path.chmod(0o755)
            text = path.read_text(encoding="utf-8")
            for old, new in suite.edits:
                text = text.replace(old, new)
            path.write_text(text, encoding="utf-8")
        if path.suffix in (".test", ".launch", ".xml"):
            text = path.read_text(encoding="utf-8")
            path.write_text(rewrite(text, suite, package, name, programs), encoding="utf-8")
    return target, name


def environment(sources, suite, folder):
    """Environment of the tests: the copies and the suite's sources in front."""
    source = sources / suite.repository
    packages = [str(folder), str(HERE), *filter(None, [os.environ.get("ROS_PACKAGE_PATH")])]
    if (suite.nodes or suite.plugin or suite.in_place) and not suite.own_name:
        packages.insert(0, str(source / suite.package))
    robots = [HERE / name / "src" for name in ("dummy_robot", "kinematic_robot")]
    paths = [*robots, source / suite.package / "src"]
    python = [str(path) for path in paths if path.is_dir() and suite.nodes]
    python += [str(HERE)] if suite.plugin else []
    return dict(
        os.environ,
        ROS_HOME=str(folder / "ros"),
        ROS_PACKAGE_PATH=os.pathsep.join(packages),
        PYTHONPATH=os.pathsep.join([*python, os.environ.get("PYTHONPATH", "")]),
    )


def run_rostest(path, name, environ, _suite):
    """Cases of a launch file; rostest's own case of each <test> counts if that left no others."""
    results = Path(environ["ROS_HOME"]) / "test_results"
    shutil.rmtree(results, ignore_errors=True)
    try:
        done = subprocess.run(
            ["rostest", str(path)],
            env=environ,
            cwd=path.parent,
            text=True,
            capture_output=True,
            timeout=LIMIT / float(environ.get(PACE, "1")),
            check=False,
        )
    except subprocess.TimeoutExpired:
        return [Case(name, f"did not end within {LIMIT:g} s")]
    cases = [case for file in sorted(results.rglob("*.xml")) for case in read_junit(file, name)]
    cases = list({case.name: case for case in cases}.values())
    own = [case for case in cases if "RosTest." not in case.name]
    cases = own or cases
    return cases or [Case(name, "no result: " + (done.stdout + done.stderr).strip()[-300:])]


def run_module(path, name, environ, suite):
    """Cases of a Python file: functions NAME_test, too, as nose found them."""
    junit = Path(environ["ROS_HOME"]) / "module.xml"
    junit.parent.mkdir(parents=True, exist_ok=True)
    options = ["-q", "-c", os.devnull, "-p", "no:cacheprovider", f"--junitxml={junit}"]
    options += ["-p", suite.plugin] if suite.plugin else []
    options += ["-o", "python_functions=test_* *_test", "-o", "python_files=*.py"]
    try:
        done = subprocess.run(
            [sys.executable, "-m", "pytest", *options, path.name],
            env=environ,
            cwd=path.parent,
            text=True,
            capture_output=True,
            timeout=LIMIT,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return [Case(name, f"did not end within {LIMIT:g} s")]
    cases = read_junit(junit, name) if junit.exists() else []
    return cases or [Case(name, "no result: " + (done.stdout + done.stderr).strip()[-300:])]


def read_junit(path, name):
    """Cases of a file of JUnit's format; skipped ones did not pass."""
    cases: list[Case] = []
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:  # the test was killed while it wrote
        return [Case(name, f"its result {path.name} is no XML: {error}")]
    for element in root.iter("testcase"):
        bad = next((it for it in element if it.tag in ("failure", "error", "skipped")), None)
        reason = "" if bad is None else (bad.get("message") or bad.text or bad.tag).strip()
        title = f"{name}::{element.get('classname', '')}.{element.get('name', '')}"
        cases.append(Case(title, short(reason)))
    return cases


def short(reason):
    """What a failure says: the last line of a traceback, or all that gtest says in one line."""
    lines = [line.strip() for line in reason.splitlines() if line.strip()]
    if not lines:
        return ""
    return " ".join(lines)[:SHOWN] if ".cpp:" in lines[0] else lines[-1]


def missing_client(path, copy, package):
    """Name of a test program that a launch file starts and that is not there; "" if none."""
    there = {each.name for each in copy.rglob("*") if os.access(each, os.X_OK)}
    for tag in re.findall(r"<test\b[^>]*>", path.read_text(encoding="utf-8")):
        name = re.search(r'type="([^"]*)"', tag).group(1)
        if f'pkg="{package}"' in tag and name not in there:
            return name
    return ""


def run_suite(package, suite, sources, clients=None):
    """Cases of a suite; `clients`: see copy_package."""
    source = sources / suite.repository / suite.package / "test"
    if not source.is_dir():
        return [Case(package, f"there is no {source}; clone {suite.repository} into {sources}")]
    with tempfile.TemporaryDirectory(prefix="conformance-") as made:
        folder = Path(made)
        copy, _ = copy_package(suite, sources, package, folder, clients)
        environ = environment(sources, suite, folder)
        cases = []
        for patterns, run in ((suite.rostests, run_rostest), (suite.modules, run_module)):
            for path in sorted(file for pattern in patterns for file in copy.glob(pattern)):
                if path.name in suite.not_applicable:
                    continue
                client = missing_client(path, copy, package) if run is run_rostest else ""
                if client:
                    text = (
                        f"compile {client} (--clients FOLDER, with {package}/{client}): it is C++"
                    )
                    cases.append(Case(path.name, text))
                    continue
                made_here = run(path, path.name, environ, suite)
                cases += made_here
                passed = sum(not case.reason for case in made_here)
                print(f"{package}: {path.name}: {passed} of {len(made_here)}", file=sys.stderr)
    return cases


def table(results):
    """Lines: how many cases of each suite passed, then those that did not, and what cannot apply.

    Args:
        results: suite's name -> Cases.
    """
    lines = [f"{'suite':28} passed"]
    for package, cases in results.items():
        passed = sum(not case.reason for case in cases)
        lines.append(f"{package:28} {passed} of {len(cases)}")
    for package, cases in results.items():
        lines += [f"  {package}: {case.name}: {case.reason}" for case in cases if case.reason]
        for test, reason in SUITES[package].not_applicable.items():
            lines.append(f"  {package}: not applicable: {test}: {reason}")
    return lines


def main(arguments=None):
    """Runs the suites; returns 0 if all cases passed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--sources", required=True, type=Path, help="folder with the clones")
    parser.add_argument("--clients", type=Path, help="folder with compiled test programs")
    parser.add_argument(
        "--pace",
        type=float,
        default=1.0,
        help="real-time factor of Paddock in tests; lower on a machine that has other work (1)",
    )
    parser.add_argument("suites", nargs="*", metavar="SUITE", help=", ".join(SUITES))
    options = parser.parse_args(arguments)
    unknown = [name for name in options.suites if name not in SUITES]
    if unknown:
        parser.error(f"suite {unknown[0]!r} is not one of {', '.join(SUITES)}")
    if not 0.0 < options.pace <= 1.0:
        parser.error(f"--pace is {options.pace}, must be above 0, at most 1")
    os.environ[PACE] = f"{options.pace:g}"
    sources, clients = options.sources.resolve(), options.clients and options.clients.resolve()
    results = {
        name: run_suite(name, SUITES[name], sources, clients)
        for name in options.suites or list(SUITES)
    }
    print("\n".join(table(results)))
    if not options.suites:
        print("\n".join(f"  not run: {tests}: {reason}" for tests, reason in WITHOUT.items()))
    return int(any(case.reason for cases in results.values() for case in cases))


if __name__ == "__main__":
    sys.exit(main())

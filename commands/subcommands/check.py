"""Starts a launch file of yours and tells what came up, on one page.

./run check PACKAGE FILE.launch [ARG:=VALUE ...]: nodes that could not start and the package they
need, controllers, each sensor's topic with its nominal and its measured rate (in simulated time),
what is missing or was ignored, whether the robots stand still and upright, the real-time factor.
It runs on a ROS master of its own and without a screen: windows such as rviz are not looked at.
Exits 0 if nothing is wrong, 1 if something is. The log of the launch is in .cache/ros/check-PORT/.
"""

import json
import os
import shutil
import subprocess

from commands import environment, processes
from commands.errors import CommandError, UsageError, say
from commands.launching import headless
from commands.paths import ROOT, VENV_PYTHON, relative

USAGE = "PACKAGE FILE.launch [--json] [--seconds N] [ARG:=VALUE ...]"
OBSERVER = os.path.join(ROOT, "commands", "checking", "observer.py")
LIMIT = 240.0  # wall time beyond the seconds of watching [s]


def add_arguments(parser):
    """Declares package, file and options."""
    parser.add_argument("package", metavar="PACKAGE", help="a catkin package")
    parser.add_argument("file", metavar="FILE.launch", help="its launch file")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    parser.add_argument(
        "--seconds", metavar="N", type=_seconds, default=8.0, help="how long it is watched (8)"
    )


def run(options, rest):
    """Runs the check; raises CommandError where something is wrong."""
    from commands.checking import verdict

    for argument in rest:
        if ":=" not in argument:
            raise UsageError(f"unknown argument {argument!r}; launch arguments are NAME:=VALUE")
    environ = environment.ready()
    _, port = headless.use_own_master(environ)
    folder = os.path.join(environment.LOG_FOLDER, f"check-{port}")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        environ.pop(name, None)
    environ.update(ROS_LOG_DIR=folder, QT_QPA_PLATFORM="offscreen")
    result, log = (os.path.join(folder, name) for name in ("result.json", "roslaunch.txt"))
    command = [VENV_PYTHON, OBSERVER, result, log, port, str(options.seconds)]
    words = [options.package, options.file, *rest]
    try:
        processes.run_child(
            [*command, *words],
            deadline=options.seconds + LIMIT,
            env=environ,
            stdin=subprocess.DEVNULL,
        )
    except processes.DeadlineExceeded:
        raise CommandError(
            "the check did not end in time", f"logs in {relative(folder)}/"
        ) from None
    if not os.path.exists(result):
        raise CommandError("the check came to no result", f"logs in {relative(folder)}/")
    with open(result, encoding="utf-8") as stream:
        found = json.load(stream)
    found.update(problems=verdict.problems(found), notes=verdict.notes(found), log=log)
    if options.json:
        say(json.dumps(found, indent=2))
    else:
        say("\n".join([*verdict.page(found, options.seconds), f"log: {relative(log)}"]))
    if found["problems"]:
        raise SystemExit(1)


def _seconds(text):
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds <= 3600.0:
        raise UsageError(f"seconds is {text!r}; it must be a number above 0, at most 3600")
    return seconds

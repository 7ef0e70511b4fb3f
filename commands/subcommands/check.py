"""Starts a launch file of yours and tells what came up, on one page.

./run check PACKAGE FILE.launch [ARG:=VALUE ...]: nodes that could not start and the package they
need, controllers, each sensor's topic with its nominal and its measured rate (in simulated time),
what is missing or was ignored, whether the robots stand still and upright, the real-time factor.
The first line says whether the file works, works without something, or does not work or drive, and
why. Problems come in the order of their causes, with what would replace what cannot work.
Behind a + there may be another file, which is started beside it: a world, + its navigation. What is
judged is what comes up of all together.
It runs on a ROS master of its own and without a screen: windows such as rviz are not looked at.
out/check/PACKAGE/FILE.html shows in 3-D, in any browser, what happened meanwhile.
Exits 0 if nothing is wrong, 1 if something is. The log of the launch is in .cache/ros/check-PORT/.
"""

import collections
import contextlib
import glob
import json
import os
import pathlib
import re
import shutil
import subprocess

from commands import (
    check_companions,
    check_remedies,
    check_verdict,
    environment,
    launching,
    parsing,
    processes,
    supervisor,
)
from commands.check_roslaunch import TOGETHER
from commands.errors import CommandError, UsageError, say
from commands.paths import OUT, ROOT, VENV_PYTHON, read, relative
from commands.subcommands import deps

USAGE = "PACKAGE FILE.launch [--json] [--seconds N] [ARG:=VALUE ...] [+ PACKAGE FILE.launch ...]"
LAUNCH = None  # takes the arguments of any launch file
OBSERVER = os.path.join(ROOT, "commands", "check_observer.py")
LOG = "roslaunch.txt"  # what roslaunch and its nodes have written
LIMIT = 420.0  # wall time beyond the seconds of watching [s]: what the observer may wait in all

BUILT = (("build", "CMakeCache.txt"), ("devel", ".catkin"))  # where a build says of which folder


def add_arguments(parser):
    """Declares package, file and options."""
    parser.add_argument("package", metavar="PACKAGE", help="a catkin package")
    parser.add_argument("file", metavar="FILE.launch", help="its launch file")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    seconds = parsing.number("seconds", 3600)
    parsing.add_options(parser, ("--seconds", "N", seconds, 8.0, "how long it is watched (8)"))


def run(options, rest):
    """Runs the check; raises SystemExit where something is wrong, CommandError without a result."""
    files = files_of(options.package, options.file, rest)
    environ = environment.ready()
    _, port = launching.use_own_master(environ)
    folder = os.path.join(environment.LOG_FOLDER, f"check-{port}")
    report = observed(files, environ, port, folder, options.seconds)
    missing = check_remedies.missing_packages(report)
    report["remedies"] = {name: check_remedies.for_package(name) for name in missing}
    report["checked"] = [options.package, options.file]
    place, checked = _folder(options.package, environ), {file[:2] for file in files}
    packages = environ.get("ROS_PACKAGE_PATH", "")
    report["companions"] = check_companions.find(place, packages, checked)
    report["stale"] = built_elsewhere(place)
    for name in ("problems", "notes", "verdict"):
        report[name] = getattr(check_verdict, name)(report)
    report["log"] = os.path.join(folder, LOG)
    report["replay"] = kept_replay(folder, options.package, options.file)
    if options.json:
        say(json.dumps(report, indent=2))
    else:
        lines = [*page(report, options.seconds), "", f"log: {relative(report['log'])}"]
        if report["replay"]:
            lines.append(f"replay: {relative(report['replay'])}")
        say("\n".join(lines))
    if report["problems"]:
        raise SystemExit(1)


def observed(files, environ, port, folder, seconds):
    """Starts launch files and returns what check_observer.py has written of them.

    Args:
        files: See files_of().
        environ: Changed in place.
        port: Of the master, as text.
        folder: For logs; emptied first.
        seconds: How long it is watched [s].

    Raises:
        CommandError: A file is not there, or the check did not end, or came to no result.
    """
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        environ.pop(name, None)
    environ.update(ROS_LOG_DIR=folder, QT_QPA_PLATFORM="offscreen")
    for file in files:
        _launch_file(*file[:2], environ)
    words = [*files[0][:2], *files[0][2]]
    if len(files) > 1:
        words = [together(files, os.path.join(folder, "together.launch"), environ)]
        environ[TOGETHER] = "true"
    result, log = (os.path.join(folder, name) for name in ("result.json", LOG))
    command, where = [VENV_PYTHON, OBSERVER, result, log, port], f"logs in {relative(folder)}/"
    supervisor.start(environ, "the check")  # roslaunch and its nodes are in sessions of their own
    try:
        processes.run_child(
            [*command, str(seconds), *words],
            deadline=seconds + LIMIT,
            env=environ,
            stdin=subprocess.DEVNULL,
        )
    except processes.DeadlineExceeded:
        raise CommandError("the check did not end in time", where) from None
    text = read(result)
    if not text:
        raise CommandError("the check came to no result", where)
    return json.loads(text)


def files_of(package, file, rest):
    """Parts the command line into launch files.

    Args:
        package, file: Of the first one.
        rest: What is behind it.

    Returns:
        List of (package, file, list of NAME:=VALUE).

    Raises:
        UsageError: A word is no argument, or a + has no package and file behind it.
    """
    files = [(package, file, [])]
    words = iter(rest)
    for word in words:
        if word == "+":
            package, file = next(words, ""), next(words, "")
            if not file or ":=" in package + file or "+" in (package, file):
                raise UsageError("behind + there must be PACKAGE FILE.launch")
            files.append((package, file, []))
        elif ":=" in word:
            files[-1][2].append(word)
        else:
            raise UsageError(f"unknown argument {word!r}; launch arguments are NAME:=VALUE")
    return files


def together(files, path, environ):
    """Writes a launch file that includes several.

    Args:
        files: See files_of().
        path: Where it is written.
        environ: In which rospack finds packages.

    Returns:
        Its path.

    Raises:
        CommandError: A package or a file is not there.
    """
    from xml.sax.saxutils import quoteattr

    lines = ["<launch>"]
    for package, file, arguments in files:
        lines.append(f"  <include file={quoteattr(_launch_file(package, file, environ))}>")
        for argument in arguments:
            name, _, value = argument.partition(":=")
            lines.append(f"    <arg name={quoteattr(name)} value={quoteattr(value)}/>")
        lines.append("  </include>")
    with open(path, "w", encoding="utf-8") as stream:
        stream.write("\n".join([*lines, "</launch>\n"]))
    return path


def built_elsewhere(folder):
    """A sentence where a package's workspace has the build of another machine, else None."""
    pattern = re.compile(r"^(?:CMAKE_HOME_DIRECTORY:INTERNAL=)?(/.*)/src(?:;|$)", re.MULTILINE)
    for workspace in map(str, pathlib.Path(folder).parents):
        built = pattern.search("\n".join(read(os.path.join(workspace, *mark)) for mark in BUILT))
        if built and os.path.realpath(built[1]) == os.path.realpath(workspace):
            return None
        if built:
            return (
                f"the workspace {workspace} was built as {built[1]}; catkin_make builds it after "
                f"rm -rf {workspace}/build {workspace}/devel"
            )
    return None


def _folder(package, environ):
    done = subprocess.run(
        ["rospack", "find", package], env=environ, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise CommandError(
            f"there is no package {package!r}",
            "If it is in a workspace, source that first; else "
            + check_remedies.for_package(package),
        )
    return done.stdout.strip()


def _launch_file(package, file, environ):
    folder = _folder(package, environ)
    named = f"{glob.escape(folder)}/**/{glob.escape(file)}"
    for path in sorted(glob.glob(named, recursive=True)):
        return path
    there = list(map(os.path.basename, deps.launch_files(folder)))
    raise CommandError(
        f"the package {package!r} has no file {file!r}",
        f"It has {check_verdict.listed(there)}" if there else "It has no launch files",
    )


def kept_replay(folder, package, file):
    """Moves the replay of a check to where that of the last check of the same file is.

    Args:
        folder: Of the check's files.
        package, file: What was checked.

    Returns:
        Its path, or None where the check has left none: no simulator came up, or nothing could be
        recorded.
    """
    name = re.sub(r"\.launch$", "", os.path.basename(file))
    kept = os.path.join(OUT, "check", package, f"{name}.html")
    try:
        os.makedirs(os.path.dirname(kept), exist_ok=True)
        shutil.move(os.path.join(folder, "replay.html"), kept)
    except OSError:
        with contextlib.suppress(OSError):
            os.remove(kept)  # of another check
        return None
    return kept


def page(report, seconds):
    """Lines of the page: the verdict, robots, sensors, what was ignored, problems."""
    lines, verdict = [], check_verdict.verdict(report)
    if report["simulator"]:
        factor = report["real_time_factor"]
        factor = "unknown: no /clock" if factor is None else f"{factor:.2f}"
        lines.append(
            f"world {report['world']}, watched for {seconds:g} s, real-time factor {factor}"
        )
        for model in check_verdict.robots(report):
            lines += _robot(model)
        lines += _sensors(report)
        lines += _ignored(report)
    notes = check_verdict.notes(report)
    if notes:
        lines += ["", "worth knowing:", *(f"  {sentence}" for sentence in notes)]
    wrong = [text for text in check_verdict.problems(report) if not verdict.endswith(text)]
    if wrong:
        more = " more" if " because " in verdict else ""
        count = f"{len(wrong)}{more} problem{'s' if len(wrong) > 1 else ''}:"
        lines += ["", count, *(f"  - {text}" for text in wrong)]
    return [verdict, *([""] if lines and lines[0] else []), *lines]


def _robot(model):
    after = model.get("after")
    where = [round(value, 2) + 0.0 for value in after["position"]] if after else []  # no -0.00
    place = " at ({:.2f}, {:.2f}, {:.2f})".format(*where) if after else ""
    driven = (
        f", driven by {check_verdict.listed(model['driven_by'])}" if model.get("driven_by") else ""
    )
    lines = ["", f"robot {model['name']}{place}{driven}"]
    for name, kind, state in model.get("controllers") or ():
        lines.append(f"  {state:11} {name:40} {kind}")
    lines += [f"  your own: {sentence}" for sentence in model.get("extensions", ())]
    return lines


def _sensors(report):
    models = [model for model in report["models"] if model["sensors"]]
    if not models:
        return []
    lines = ["", f"  {'topic':40} {'type':28} {'nominal':>9} {'measured':>9}"]
    for model in models:
        if len(models) > 1:
            lines.append(f"  of {model['name']}:")
        for row in model["sensors"]:
            measured = "-" if row["measured"] is None else f"{row['measured']:.1f} Hz"
            lines.append(f"  {row['topic']:40} {row['type']:28} {row['rate']:6g} Hz {measured:>9}")
    return lines


def _ignored(report):
    texts = collections.Counter(report.get("warnings", ()))
    texts.update(text for model in report["models"] for text in model["warnings"])
    if not texts:
        return []
    lines = ["", "ignored or repaired:"]
    return lines + [
        f"  {count} x {text}" if count > 1 else f"  {text}" for text, count in texts.items()
    ]

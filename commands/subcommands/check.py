"""Starts a launch file of yours and tells what came up, on one page.

./run check PACKAGE FILE.launch [ARG:=VALUE ...]: nodes that could not start and the package they
need, controllers, each sensor's topic with its nominal and its measured rate (in simulated time),
what is missing or was ignored, whether the robots stand still and upright, the real-time factor.
Problems come in the order in which to mend them, with what would replace what cannot work. The last
line says whether the file works, works without something, or does not work, and why.
Behind a + there may be another file, which is started beside it: a world, + its navigation. What is
judged is what comes up of all together.
It runs on a ROS master of its own and without a screen: windows such as rviz are not looked at.
out/check/PACKAGE/FILE.html shows in 3-D, in any browser, what happened meanwhile.
Exits 0 if nothing is wrong, 1 if something is. The log of the launch is in .cache/ros/check-PORT/.
"""

import collections
import contextlib
import json
import math
import os
import re
import shutil
import subprocess

from commands import check_companions, check_remedies, environment, launching, processes
from commands.check_roslaunch import TOGETHER
from commands.errors import CommandError, UsageError, say
from commands.paths import OUT, ROOT, VENV_PYTHON, relative
from commands.windows import needs_screen

USAGE = "PACKAGE FILE.launch [--json] [--seconds N] [ARG:=VALUE ...] [+ PACKAGE FILE.launch ...]"
LAUNCH = None  # takes the arguments of any launch file
OBSERVER = os.path.join(ROOT, "commands", "check_observer.py")
LIMIT = 240.0  # wall time beyond the seconds of watching [s]
SLOW = 0.9  # of the nominal rate, below which a sensor is too slow
STILL = 0.05  # [m] that a robot nobody drives may move while it is watched
UPRIGHT = 30.0  # [degrees] of tilt up to which a robot stands upright
LISTED = 3  # names that a sentence gives
LOWEST = -1.0  # [m] below which a robot has fallen out of the world


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
    files = files_of(options.package, options.file, rest)
    environ = environment.ready()
    _, port = launching.use_own_master(environ)
    folder = os.path.join(environment.LOG_FOLDER, f"check-{port}")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        environ.pop(name, None)
    environ.update(ROS_LOG_DIR=folder, QT_QPA_PLATFORM="offscreen")
    result, log = (os.path.join(folder, name) for name in ("result.json", "roslaunch.txt"))
    command = [VENV_PYTHON, OBSERVER, result, log, port, str(options.seconds)]
    if len(files) == 1:
        words = [options.package, options.file, *rest]
    else:
        words = [together(files, os.path.join(folder, "together.launch"), environ)]
        environ[TOGETHER] = "true"
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
    missing = check_remedies.missing_packages(found)
    found["remedies"] = {name: check_remedies.for_package(name) for name in missing}
    found["companions"] = _companions(files, environ)
    found.update(problems=problems(found), notes=notes(found), verdict=verdict(found), log=log)
    found["replay"] = kept_replay(folder, options.package, options.file)
    if options.json:
        say(json.dumps(found, indent=2))
    else:
        lines = [*page(found, options.seconds), f"log: {relative(log)}"]
        if found["replay"]:
            lines.append(f"replay: {relative(found['replay'])}")
        lines.append(found["verdict"])
        say("\n".join(lines))
    if found["problems"]:
        raise SystemExit(1)


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
    found = [(package, file, [])]
    words = iter(rest)
    for word in words:
        if word == "+":
            package, file = next(words, ""), next(words, "")
            if not file or ":=" in package + file or "+" in (package, file):
                raise UsageError("behind + there must be PACKAGE FILE.launch")
            found.append((package, file, []))
        elif ":=" in word:
            found[-1][2].append(word)
        else:
            raise UsageError(f"unknown argument {word!r}; launch arguments are NAME:=VALUE")
    return found


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


def _companions(files, environ):
    """Launch files that may bring what is missing, of the packages beside the first one."""
    try:
        folder = _folder(files[0][0], environ)
    except CommandError:
        return {}
    checked = {(package, file) for package, file, _ in files}
    return check_companions.find(folder, environ.get("ROS_PACKAGE_PATH", ""), checked)


def _folder(package, environ):
    done = subprocess.run(
        ["rospack", "find", package], env=environ, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise CommandError(f"there is no package {package!r}", check_remedies.for_package(package))
    return done.stdout.strip()


def _launch_file(package, file, environ):
    for directory, below, names in os.walk(_folder(package, environ)):
        below.sort()
        if file in names:
            return os.path.join(directory, file)
    raise CommandError(f"the package {package!r} has no file {file!r}")


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


def _seconds(text):
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds <= 3600.0:
        raise UsageError(f"seconds is {text!r}; it must be a number above 0, at most 3600")
    return seconds


def problems(found):
    """Sentences about what did not come up or does not work; empty: all is well.

    In the order in which to mend them: what roslaunch refuses, programs and packages that are
    missing, plugins, controllers, robots, sensors, nodes that died.

    Args:
        found: What observer.py has written.
    """
    return [sentence for sentence, _ in _findings(found)]


def verdict(found):
    """One line: works, works without what, or does not work and why."""
    findings = _findings(found)
    for sentence, without in findings:
        if without is None:
            return f"does not work because {sentence}"
    if not findings:
        return "works"
    return "works without " + _listed(list(dict.fromkeys(without for _, without in findings)))


def _findings(found):
    """(sentence, what is missing; None: nothing works then) of each problem, in order."""
    said = []

    def add(sentences, without):
        said.extend((sentence, without) for sentence in sentences if sentence)

    if found.get("refused"):
        add([_refused(found)], None)
    for script, interpreter in found.get("interpreters", ()):
        add([_without_interpreter(script, interpreter)], None)
    cannot = [node for node in found["cannot"] if not needs_screen(node[1])]
    for package, kind in sorted(cannot, key=lambda node: _is_installed(found, node[1])):
        add([_cannot(found, package, kind)], f"node {package}/{kind}")
    for name in found.get("unable", ()):
        add([f"node {name} has a program that cannot be run"], f"node {name}")
    if not found["simulator"] and not found.get("refused"):
        question = ": does the file include gazebo_ros's empty_world.launch?"
        hint = check_companions.hint(found, "world", question)
        add([f"no simulator came up{hint}"], None)
    for name in check_remedies.unspawned(found):
        remedy = found.get("remedies", {}).get(name, check_remedies.GENERIC)
        text = f"package {name} is not there, so that what names its files is not spawned; {remedy}"
        add([text], None)
    if found["simulator"]:
        _add_models(found, add)
    for name, code, program in found["died"]:
        if not needs_screen(program):
            text = f"node {name} ({program}) died with exit code {code}"
            why = _raised(found, program) or _reason(found, program) or _before(found, name)
            add([text + why], f"node {name}")
    return said


def _add_models(found, add):
    """Adds the findings about plugins, robots, their controllers and sensors."""
    if not robots(found):
        add(["no robot was spawned" + check_companions.hint(found, "robot")], None)
    for text in losses(found):
        add([_lost(found, text)], _subject(text))
    for model in robots(found):
        some_run = any(state == "running" for _, _, state in model.get("controllers") or ())
        for sentence in _controllers(found, model):
            add([sentence], sentence.partition(" is ")[0] if some_run else None)
    for model in robots(found):
        add(_stance(model), None)
    for model in found["models"]:
        for sensor in model["sensors"]:
            add([_sensor(model, sensor)], f"sensor {sensor['topic']}")


def notes(found):
    """Sentences about what is worth knowing and no fault of the package or of the simulator."""
    said = [
        f"node {name} ({program}) needs a screen or a terminal and was not looked at"
        for name, _, program in found["died"]
        if needs_screen(program)
    ]
    said += [
        f"node {package}/{kind}, a window, is not installed"
        for package, kind in found["cannot"]
        if needs_screen(kind)
    ]
    if found.get("was_paused"):
        said.append("the file starts the world paused; the check let it go on")
    factor = found.get("real_time_factor")
    if found["simulator"] and factor is not None and 0.0 < factor < SLOW:
        said.append(f"this machine simulates {factor:.2f} s in a second")
    restless = _restless(found) if found["simulator"] else []
    if restless:
        said.append(f"loose things move, fall or lie: {_listed(restless)}")
    for model in found.get("models", ()):
        said += [
            f"this machine draws {sensor['topic']} {sensor['measured']:.1f} times a simulated "
            f"second, {sensor['rate']:g} are wanted"
            for sensor in model["sensors"]
            if sensor.get("is_camera") and _is_slow(sensor)
        ]
    return said


def robots(found):
    """The models that can move and are no loose things.

    Loose are furniture of the world file and, beside a robot with controllers, sensors or plugins,
    what was spawned without any: crates, pallets.
    """
    spawned = [m for m in found["models"] if not m["static"] and not m.get("furniture")]
    return [m for m in spawned if _is_equipped(m)] or spawned


def _is_equipped(model):
    """Whether a model has what makes it a robot, if only in its file."""
    has = (model.get(name) for name in ("sensors", "extensions", "lost"))
    return any(has) or model["control_namespace"] is not None


def _restless(found):
    """Names of the loose things that do not stay where they are."""
    others = [model["name"] for model in robots(found)]
    loose = [m for m in found["models"] if not m["static"] and m["name"] not in others]
    return [model["name"] for model in loose if _stance(model)]


def _listed(names):
    shown = ", ".join(names[:LISTED])
    return shown if len(names) <= LISTED else f"{shown} and {len(names) - LISTED} more"


def losses(found):
    """What the files name and is not there, once each."""
    texts = [text for model in found["models"] for text in model.get("lost", ())]
    return list(dict.fromkeys([*found.get("lost", ()), *texts]))


LIBRARY = re.compile(r"lib[\w.+-]+\.so")
NAMED = re.compile(r"(controller|world file|plugin) '([^']+)'")
LOGGED = re.compile(r"\[?(?:ERROR|FATAL)\]?:? (?:\[[^]]*\]: )?(.*)")  # a line of a node's log
IMAGE = re.compile(r'failed to open image file "(/[^"]+)"')  # map_server's error


def _subject(text):
    """What is missing, of a sentence that says that it is."""
    said = check_remedies.finding(text)
    library, named = LIBRARY.search(said), NAMED.match(said)
    if library:
        return f"plugin {library.group()}"
    return " ".join(named.groups()) if named else text


def _raised(found, program):
    """The exception that ended a Python program, or ""."""
    said = found.get("raised", {}).get(program)
    return f": {said}" if said else ""


def _reason(found, program):
    """What a program has said of its end: the last error that begins with its name, or "".

    Where several nodes of it have died, all that they have said: whose it was is not logged.
    """
    begins = re.compile(rf"{re.escape(program)}[: ]")
    texts = [LOGGED.fullmatch(line) for line in found.get("errors", ())]
    said = [text.group(1) for text in texts if text and begins.match(text.group(1))]
    if len({name for name, _, other in found["died"] if other == program}) == 1:
        said = said[-1:]
    return f": {' | '.join(dict.fromkeys(said))}" if said else ""


def _before(found, name):
    """The error that was logged just before a node died, or ""."""
    text = LOGGED.fullmatch(found.get("before", {}).get(name, ""))
    return f"; just before: {text.group(1)}{_elsewhere(text.group(1))}" if text else ""


def _elsewhere(text):
    """What helps where map_server's error names an image in a folder of its author's machine."""
    image = IMAGE.search(text)
    if not image or os.path.isdir(os.path.dirname(image.group(1))):
        return ""
    return (
        f"; there is no such folder here: with 'image: {os.path.basename(image.group(1))}' in the "
        "map's YAML file it is looked for beside that file"
    )


def _lost(found, text):
    library = LIBRARY.search(check_remedies.finding(text))
    if library is None or "which is no link" in text:  # a known plugin, a fault of the file
        return text
    remedy = check_remedies.for_plugin(library.group())
    for name, (package, *_) in found.get("builders", {}).items():
        if f"lib{name}.so" == library.group():
            return f"{text}: it is C++ of package {package}; {remedy}"
    return text if "did you mean" in text else f"{text}; {remedy}"


def _refused(found):
    """What roslaunch refuses, and where the packages come from that it misses."""
    sentence = f"roslaunch refuses the file: {found['refused']}"
    named = dict.fromkeys(check_remedies.named_packages(found["refused"]))
    remedies = [f"{name}: {found.get('remedies', {}).get(name)}" for name in named]
    return "; ".join([sentence, *(text for text in remedies if not text.endswith(": None"))])


def _is_installed(found, kind):
    """Whether the package of a node that cannot start is there; those that are not come first."""
    return found.get("builders", {}).get(kind, (None, True))[1]


def _cannot(found, package, kind):
    builder = found.get("builders", {}).get(kind)
    if builder is None:
        return (
            f"node {package}/{kind} cannot start: package {package} has no such node; is the type "
            "spelt as its file, and the file executable?"
        )
    package_of_it, is_there, against = (*builder, "")[:3]
    if not is_there:
        remedy = found.get("remedies", {}).get(package, check_remedies.GENERIC)
        return f"node {package}/{kind} cannot start: package {package} is not installed; {remedy}"
    if against:
        return (
            f"node {package}/{kind} cannot start: it is C++ of {package_of_it}, which asks for "
            f"{against}, and that does not exist here; a node in Python can take its place"
        )
    return (
        f"node {package}/{kind} cannot start: it is C++ of {package_of_it}, which is not built; "
        "build the workspace with catkin_make"
    )


def _without_interpreter(script, interpreter):
    remedy = "install it, or change the script's first line"
    if interpreter == "/usr/bin/python":
        remedy = "apt install python-is-python3, or change the first line to #!/usr/bin/env python3"
    return (
        f"script {script} begins with #!{interpreter}, which this machine does not have, and "
        f"roslaunch ends everything: {remedy}"
    )


def tilt(orientation):
    """Angle [degrees] between a model's z axis and the world's."""
    x, y, _, _ = orientation
    return math.degrees(math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y)))))


def _stance(model):
    before, after = model.get("before"), model.get("after")
    if before is None or after is None:
        return [f"robot {model['name']} cannot be asked where it is"]
    said, name = [], model["name"]
    if not all(map(math.isfinite, after["position"])):
        return [f"robot {name} is nowhere: its position is not finite"]
    way = math.dist(before["position"], after["position"])
    if way > STILL:
        said.append(f"robot {name} moves by itself: {way:.2f} m while it was watched")
    if tilt(after["orientation"]) > UPRIGHT:
        said.append(f"robot {name} is tilted by {tilt(after['orientation']):.0f} degrees")
    if after["position"][2] < LOWEST:
        said.append(f"robot {name} has fallen to z = {after['position'][2]:.1f} m")
    return said


def _controllers(found, model):
    if model["control_namespace"] is None:
        return []
    where = f"{model['control_namespace'] or '/'}"
    if model.get("controllers") is None:
        return [f"the controller_manager of {model['name']} in {where} does not answer"]
    if not model["controllers"]:
        question = ": is there a spawner, and its YAML?"
        hint = check_companions.hint(found, "controllers", question)
        return [f"no controller is loaded in {where}{hint}"]
    return [
        f"controller {name} in {where} is {state}"
        for name, _, state in model["controllers"]
        if state != "running"
    ]


def _sensor(model, sensor):
    if not sensor["count"]:
        return f"sensor on {sensor['topic']} of {model['name']} sends nothing"
    if _is_slow(sensor) and not sensor.get("is_camera"):
        return (
            f"sensor on {sensor['topic']} sends {sensor['measured']:.1f} of {sensor['rate']:g} Hz"
        )
    return None


def _is_slow(sensor):
    return sensor["measured"] is not None and sensor["measured"] < SLOW * sensor["rate"]


def page(found, seconds):
    """Lines of the page: robots, sensors, what was ignored, problems."""
    lines = []
    if found["simulator"]:
        factor = found["real_time_factor"]
        factor = "unknown: no /clock" if factor is None else f"{factor:.2f}"
        lines.append(
            f"world {found['world']}, watched for {seconds:g} s, real-time factor {factor}"
        )
        for model in robots(found):
            lines += _robot(model)
        lines += _sensors(found)
        lines += _ignored(found)
    told = notes(found)
    if told:
        lines += ["", "worth knowing:", *(f"  {sentence}" for sentence in told)]
    wrong = problems(found)
    count = "1 problem:" if len(wrong) == 1 else f"{len(wrong)} problems:"
    lines += ["", count if wrong else "no problems"]
    return lines + [f"  - {sentence}" for sentence in wrong]


def _robot(model):
    after = model.get("after")
    where = [round(value, 2) + 0.0 for value in after["position"]] if after else []  # no -0.00
    place = " at ({:.2f}, {:.2f}, {:.2f})".format(*where) if after else ""
    lines = ["", f"robot {model['name']}{place}"]
    for name, kind, state in model.get("controllers") or ():
        lines.append(f"  {state:11} {name:40} {kind}")
    lines += [f"  your own: {sentence}" for sentence in model.get("extensions", ())]
    return lines


def _sensors(found):
    rows = [sensor for model in found["models"] for sensor in model["sensors"]]
    if not rows:
        return []
    lines = ["", f"  {'topic':40} {'type':28} {'nominal':>9} {'measured':>9}"]
    for row in rows:
        measured = "-" if row["measured"] is None else f"{row['measured']:.1f} Hz"
        lines.append(f"  {row['topic']:40} {row['type']:28} {row['rate']:6g} Hz {measured:>9}")
    return lines


def _ignored(found):
    texts = collections.Counter(found.get("warnings", ()))
    texts.update(text for model in found["models"] for text in model["warnings"])
    if not texts:
        return []
    lines = ["", "ignored or repaired:"]
    return lines + [
        f"  {count} x {text}" if count > 1 else f"  {text}" for text, count in texts.items()
    ]

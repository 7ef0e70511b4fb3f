"""What ./run check says of what it has observed: problems in the order of their causes, a verdict.

First files and packages, then models and ground, plugins, controllers, nodes; a robot that moves by
itself or lies on its side comes last, since one of these may be why.
"""

import math
import re
from dataclasses import dataclass, replace

from commands import check_companions, check_remedies, sources
from commands.windows import needs_screen

SLOW = 0.9  # of the nominal rate, below which a sensor is too slow
STILL = 0.05  # [m] that a robot nobody drives may move while it is watched
UPRIGHT = 30.0  # [degrees] of tilt up to which a robot stands upright
LISTED = 3  # names that a sentence gives
LOWEST = -1.0  # [m] below which a robot has fallen out of the world
FIRST = 3.0  # periods in which a sensor sends its first message
LIBRARY = re.compile(r"lib[\w.+-]+\.so")
DRIVE = re.compile(r"drive|planar_move|hand_of_god|steer|kobuki")  # in libraries that move a robot
NAMED = re.compile(r"(controller|world file|plugin) '([^']+)'")
MASSLESS = re.compile(r"links of '[^']+' without mass are left out.*, as in Gazebo: ([^;]*)")
PATH = re.compile(r"/\S*[^\s:]")
MODEL = re.compile(r"model:/{2,3}([^/\s']+)")


@dataclass(frozen=True)
class Problem:
    """What is wrong.

    Attributes:
        text: Sentence.
        without: What is missing, in a few words; empty: nothing works then.
        explains: Whether a robot may move by itself for it.
        drives: Whether a robot does not drive for it.
    """

    text: str
    without: str = ""
    explains: bool = True
    drives: bool = False


def problems(report):
    """Sentences about what did not come up or does not work; empty: all is well.

    Args:
        report: What check_observer.py has written.
    """
    return [problem.text for problem in _problems(report)]


def verdict(report):
    """One line: works, works without what, or does not work or drive and why."""
    said = _problems(report)
    for problem in said:
        if not problem.without:
            causes = [other for other in said if other.explains]
            cause = problem if problem.explains else (causes or [problem])[0]
            return f"does not work because {cause.text}"
    for problem in said:
        if problem.drives:
            return f"does not drive because {problem.text}"
    if not said:
        return "works"
    return "works without " + listed(list(dict.fromkeys(other.without for other in said)))


def _problems(report):
    """Lists the problems of a report, in the order of their causes."""
    places = report.get("moved", {})
    return [replace(found, text=_with_places(places, found.text)) for found in _found(report)]


def _found(report):
    if report.get("refused"):
        yield Problem(_refused(report))
    for script, interpreter in report.get("interpreters", ()):
        yield Problem(_without_interpreter(script, interpreter))
    cannot = [node for node in report["cannot"] if not needs_screen(node[1])]
    builders = report.get("builders", {})  # those of packages that are not there come first
    for package, kind in sorted(cannot, key=lambda node: builders.get(node[1], (None, True))[1]):
        yield Problem(_cannot(report, package, kind), f"node {package}/{kind}")
    for name in report.get("unable", ()):
        yield Problem(f"node {name} has a program that cannot be run", f"node {name}")
    if not report["simulator"] and not report.get("refused"):
        question = ": does the file include gazebo_ros's empty_world.launch?"
        hint = check_companions.hint(report, "world", question)
        yield Problem(f"no simulator came up{hint}")
    for name in check_remedies.unspawned(report):
        remedy = report.get("remedies", {}).get(name, check_remedies.GENERIC)
        text = f"package {name} is not there, so that what names its files is not spawned; {remedy}"
        yield Problem(text)
    parts = (_files, _plugins, _controllers, _died, _sensors, _motion)
    for part in parts if report["simulator"] else (_died,):
        yield from part(report)


def _with_places(moved, text):
    """A sentence, and where files are that it names by their places on another machine."""
    places = [place for path, place in moved.items() if path in text]
    return f"{text}; here it is {' and '.join(places)}" if places else text


def _files(report):
    """Models, heightmaps and meshes that are missing."""
    missing, database, stands = {}, set(), False  # stands: a robot may stand on one of them
    for part in (report, *report.get("models", ())):
        for cause, items in part.get("missing", {}).items():
            rest = missing.setdefault(cause, {})
            for item in items:
                name = MODEL.search(item)
                if name and name[1] in sources.database():
                    database.add(name[1])
                    stands = stands or not cause.startswith("mesh")
                else:
                    rest[item.strip("'")] = True
    if database:
        names = sorted(database)
        count = "1 model" if len(names) == 1 else f"{len(names)} models"
        verb = "is" if len(names) == 1 else "are"
        text = f"{count} of Gazebo's database {verb} missing: {listed(names)}"
        yield Problem(f"{text}; ./run add models {' '.join(names)}", count, stands)
    for cause, rest in missing.items():
        nouns, what = cause.replace("included ", "").split(" ", 1)
        noun, rest = {"meshes": "mesh"}.get(nouns, nouns[:-1]), list(rest)
        if len(rest) == 1:
            what, without = what.replace("are ", "is "), f"{noun} {rest[0].rpartition('/')[2]}"
            yield Problem(f"{noun} {rest[0]} {what}", without, noun != "mesh")
        elif rest:
            without = f"{len(rest)} {nouns}"
            yield Problem(f"{without} {what}: {listed(rest)}", without, noun != "mesh")


def _plugins(report):
    if not robots(report):
        spawner = next((node for node in report["died"] if _is_spawner(node)), None)
        why = f": {spawner['why']}" if spawner else check_companions.hint(report, "robot")
        yield Problem("no robot was spawned" + why)
    obeys = any(
        state == "running" and DRIVE.search(kind)
        for model in robots(report)
        for _, kind, state in model.get("controllers") or ()
    )
    for text in losses(report):
        without = _subject(text)
        drives = not obeys and bool(LIBRARY.search(without) and DRIVE.search(without))
        yield Problem(_lost(report, text), without, True, drives)


def _controllers(report):
    for model in robots(report):
        if model["control_namespace"] is None:
            continue
        where, loaded = model["control_namespace"] or "/", model.get("controllers")
        if loaded is None:
            text = f"the controller_manager of {model['name']} in {where} does not answer"
            yield Problem(text)
        elif not loaded:
            question = ": is there a spawner, and its YAML?"
            hint = check_companions.hint(report, "controllers", question)
            without = f"controllers in {where}" if model.get("commands") else ""  # plugins obey
            yield Problem(f"no controller is loaded in {where}{hint}", without)
        states = [state for _, _, state in loaded or ()]
        for name, _, state in loaded or ():
            if state != "running":
                who = f"controller {name} in {where}"
                yield Problem(f"{who} is {state}", who if "running" in states else "")


def _died(report):
    is_explained = report["simulator"] and not robots(report)  # by the robot that is missing
    for node in report["died"]:
        if not node["screen"] and not (is_explained and _is_spawner(node)):
            times = f", {node['times']} times" if node.get("times", 1) > 1 else ""
            why = f": {node['why']}" if node.get("why") else ""
            text = f"node {node['name']} ({node['program']}) died with exit code {node['code']}"
            drives = node.get("drives", False)
            yield Problem(f"{text}{times}{why}", f"node {node['name']}", True, drives)


def _is_spawner(node):
    """Whether a node that has died would have spawned a robot, and has said why it did not."""
    return node["program"].startswith("spawn_") and bool(node["why"])


def _sensors(report):
    for model in report["models"]:
        for sensor in model["sensors"]:
            name = f"sensor {sensor['topic']}"
            if not sensor["count"] and not _is_early(report, sensor):
                text = f"sensor on {sensor['topic']} of {model['name']} sends nothing"
                yield Problem(text, name, False)
            elif sensor["count"] and _is_slow(sensor) and not sensor.get("is_camera"):
                rates = f"{sensor['measured']:.1f} of {sensor['rate']:g} Hz"
                yield Problem(f"sensor on {sensor['topic']} sends {rates}", name, False)


def _motion(report):
    return [Problem(text, "", False) for model in robots(report) for text in _stance(model)]


def notes(report):
    """Sentences about what is worth knowing and no fault of the package or of the simulator."""
    return list(_notes(report))


def _notes(report):
    for node in report["died"]:
        if node["screen"]:
            who = f"node {node['name']} ({node['program']})"
            yield f"{who} wants a screen or terminal and was not looked at"
    for package, kind in report["cannot"]:
        if needs_screen(kind):
            yield f"node {package}/{kind}, a window, is not installed"
    if report.get("stale"):
        yield report["stale"]
    if sum("./run add " in text for text in report.get("problems", ())) > 1:
        words = " ".join(report["checked"])
        yield f"./run add --for {words} brings all of these packages and models at once"
    if report.get("was_paused"):
        yield "the file starts the world paused; the check let it go on"
    factor = report.get("real_time_factor")
    if report["simulator"] and factor is not None and 0.0 < factor < SLOW:
        yield f"this machine simulates {factor:.2f} s in a second"
    restless = _restless(report) if report["simulator"] else []
    if restless:
        yield f"loose things move, fall or lie: {listed(restless)}"
    for model in report.get("models", ()):
        for sensor in model["sensors"]:
            if not sensor["count"] and _is_early(report, sensor):
                yield f"this machine was too slow for a first message on {sensor['topic']}"
            elif sensor.get("is_camera") and sensor["count"] and _is_slow(sensor):
                times = f"{sensor['topic']} {sensor['measured']:.1f} times a simulated second"
                yield f"this machine draws {times}, {sensor['rate']:g} are wanted"


def robots(report):
    """The models that can move and are no loose things.

    Loose are furniture of the world file and, beside a robot with controllers, sensors or plugins,
    what was spawned without any: crates, pallets.
    """
    spawned = [m for m in report["models"] if not m["static"] and not m.get("furniture")]
    return [m for m in spawned if _is_equipped(m)] or spawned


def _is_equipped(model):
    """Whether a model has what makes it a robot, if only in its file."""
    has = (model.get(name) for name in ("sensors", "extensions", "lost"))
    return any(has) or model["control_namespace"] is not None


def _restless(report):
    """Names of the loose things that do not stay where they are."""
    others = [model["name"] for model in robots(report)]
    loose = [m for m in report["models"] if not m["static"] and m["name"] not in others]
    return [model["name"] for model in loose if _stance(model)]


def listed(names):
    """The first of some names, and how many more."""
    shown = ", ".join(names[:LISTED])
    return shown if len(names) <= LISTED else f"{shown} and {len(names) - LISTED} more"


def losses(report):
    """What the files name and is not there, once each."""
    texts = [text for model in report.get("models", ()) for text in model.get("lost", ())]
    return list(dict.fromkeys([*report.get("lost", ()), *texts]))


def _subject(text):
    """What is missing, of a sentence that says that it is."""
    said = check_remedies.finding(text)
    library, named, massless = LIBRARY.search(said), NAMED.match(said), MASSLESS.search(said)
    if massless:  # with all of them nothing works
        names = [name.partition(" ")[0] for name in massless[1].split(", ")]
        return "" if text.startswith("all ") else f"links without mass: {listed(names)}"
    if library:
        return f"plugin {library.group()}"
    if not named and (path := PATH.match(said)):
        return f"file {path[0]}"
    return " ".join(named.groups()) if named else text


def _lost(report, text):
    library = LIBRARY.search(check_remedies.finding(text))
    if library is None or "is not known here" not in text:  # a known plugin, a fault of the file
        return text
    for name, (package, *_) in report.get("builders", {}).items():
        if f"lib{name}.so" == library.group():
            remedy = check_remedies.for_plugin(library.group(), has_sources=True)
            return f"{text}: it is C++ of package {package}; {remedy}"
    remedy = check_remedies.for_plugin(library.group())
    return text if "did you mean" in text else f"{text}; {remedy}"


def _refused(report):
    """What roslaunch refuses, and where the packages come from that it misses."""
    sentence = f"roslaunch refuses the file: {report['refused']}"
    named = dict.fromkeys(check_remedies.named_packages(report["refused"]))
    remedies = [f"{name}: {report.get('remedies', {}).get(name)}" for name in named]
    return "; ".join([sentence, *(text for text in remedies if not text.endswith(": None"))])


def _cannot(report, package, kind):
    owner, is_there, against = (*report.get("builders", {}).get(kind, ("", True)), "")[:3]
    if not owner:
        why = f"package {package} has no such node; "
        why += "is the type spelt as its file, and the file executable?"
    elif not is_there:
        remedy = report.get("remedies", {}).get(package, check_remedies.GENERIC)
        why = f"package {package} is not installed; {remedy}"
    elif against:
        why = f"it is C++ of {owner}, which asks for {against}, "
        why += "and that does not exist here; a node in Python can take its place"
    else:
        why = f"it is C++ of {owner}, which is not built; build the workspace with catkin_make"
    return f"node {package}/{kind} cannot start: {why}"


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
    if way > STILL and not model.get("driven_by"):
        said.append(f"robot {name} moves by itself: {way:.2f} m while it was watched")
    can_move = model.get("joints", 1) or model.get("commands") or said  # no camera that hangs so
    if tilt(after["orientation"]) > UPRIGHT and can_move:
        said.append(f"robot {name} is tilted by {tilt(after['orientation']):.0f} degrees")
    if after["position"][2] < LOWEST:
        said.append(f"robot {name} has fallen to z = {after['position'][2]:.1f} m")
    return said


def _is_slow(sensor):
    return sensor["measured"] is not None and sensor["measured"] < SLOW * sensor["rate"]


def _is_early(report, sensor):
    """Whether a machine that is too slow has not come to a sensor's first message."""
    factor, simulated = report.get("real_time_factor"), report.get("simulated")
    if factor is None or simulated is None or factor >= SLOW:
        return False
    return sensor.get("is_camera") or simulated * sensor["rate"] < FIRST

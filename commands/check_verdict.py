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
DRIVE = re.compile(r"drive|planar_move|hand_of_god|steer")  # in libraries that move a robot
NAMED = re.compile(r"(controller|world file|plugin) '([^']+)'")
MASSLESS = re.compile(r"links of '[^']+' without mass are left out.*, as in Gazebo: ([^;]*)")
MODEL = re.compile(r"model://([^/\s']+)")


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
    said = []
    if report.get("refused"):
        said.append(Problem(_refused(report)))
    for script, interpreter in report.get("interpreters", ()):
        said.append(Problem(_without_interpreter(script, interpreter)))
    cannot = [node for node in report["cannot"] if not needs_screen(node[1])]
    for package, kind in sorted(cannot, key=lambda node: _is_installed(report, node[1])):
        said.append(Problem(_cannot(report, package, kind), f"node {package}/{kind}"))
    for name in report.get("unable", ()):
        text = f"node {name} has a program that cannot be run"
        said.append(Problem(text, f"node {name}"))
    if not report["simulator"] and not report.get("refused"):
        question = ": does the file include gazebo_ros's empty_world.launch?"
        hint = check_companions.hint(report, "world", question)
        said.append(Problem(f"no simulator came up{hint}"))
    for name in check_remedies.unspawned(report):
        remedy = report.get("remedies", {}).get(name, check_remedies.GENERIC)
        text = f"package {name} is not there, so that what names its files is not spawned; {remedy}"
        said.append(Problem(text))
    if report["simulator"]:
        said += [*_files(report), *_plugins(report), *_controllers_of_all(report)]
    said += _died(report)
    if report["simulator"]:
        said += [*_sensors(report), *_motion(report)]
    return [replace(problem, text=_with_places(report, problem.text)) for problem in said]


def _with_places(report, text):
    """A sentence, and where files are that it names by their places on another machine."""
    places = [place for path, place in report.get("moved", {}).items() if path in text]
    return f"{text}; here it is {' and '.join(places)}" if places else text


def _files(report):
    """Models, heightmaps and meshes that are missing."""
    said, models, parts = [], [], [report, *report.get("models", ())]
    missing = {}
    for part in parts:
        for cause, items in part.get("missing", {}).items():
            missing.setdefault(cause, []).extend(items)
    for cause, items in missing.items():
        rest = []
        for item in dict.fromkeys(items):
            name = MODEL.search(item)
            if name and name[1] in sources.database():
                models.append(name[1])
            else:
                rest.append(item.strip("'"))
        if rest:
            noun, what = _noun(cause)
            explains = noun != "mesh"
            if len(rest) == 1:
                without = f"{noun} {rest[0].rpartition('/')[2]}"
                text = f"{noun} {rest[0]} {what.replace('are ', 'is ')}"
            else:
                without = f"{len(rest)} {noun}{'es' if noun == 'mesh' else 's'}"
                text = f"{without} {what}: {listed(rest)}"
            said.append(Problem(text, without, explains))
    if models:
        names = sorted(set(models))
        count = "1 model" if len(names) == 1 else f"{len(names)} models"
        verb = "is" if len(names) == 1 else "are"
        text = f"{count} of Gazebo's database {verb} missing: {listed(names)}"
        remedy = f"./run add models {' '.join(names)}"
        said.insert(0, Problem(f"{text}; {remedy}", count))
    return said


def _noun(cause):
    """What is missing, in the singular, and what is said of it."""
    words = cause.replace("included ", "").split(" ", 1)
    return {"models": "model", "meshes": "mesh", "heightmaps": "heightmap"}[words[0]], words[1]


def _plugins(report):
    said = []
    if not robots(report):
        spawner = next((node for node in report["died"] if _is_spawner(node)), None)
        why = f": {spawner['why']}" if spawner else check_companions.hint(report, "robot")
        said.append(Problem("no robot was spawned" + why))
    for text in losses(report):
        without = _subject(text)
        drives = bool(LIBRARY.search(without) and DRIVE.search(without))
        said.append(Problem(_lost(report, text), without, True, drives))
    return said


def _controllers_of_all(report):
    said = []
    for model in robots(report):
        some_run = any(state == "running" for _, _, state in model.get("controllers") or ())
        for text in _controllers(report, model):
            said.append(Problem(text, text.partition(" is ")[0] if some_run else ""))
    return said


def _died(report):
    said = []
    is_explained = report["simulator"] and not robots(report)  # by the robot that is missing
    for node in report["died"]:
        if not node["screen"] and not (is_explained and _is_spawner(node)):
            times = f", {node['times']} times" if node.get("times", 1) > 1 else ""
            why = f": {node['why']}" if node.get("why") else ""
            text = f"node {node['name']} ({node['program']}) died with exit code {node['code']}"
            drives = node.get("drives", False)
            said.append(Problem(f"{text}{times}{why}", f"node {node['name']}", True, drives))
    return said


def _is_spawner(node):
    """Whether a node that has died would have spawned a robot, and has said why it did not."""
    return node["program"].startswith("spawn_") and bool(node["why"])


def _sensors(report):
    said = []
    for model in report["models"]:
        for sensor in model["sensors"]:
            name = f"sensor {sensor['topic']}"
            if not sensor["count"] and not _is_early(report, sensor):
                text = f"sensor on {sensor['topic']} of {model['name']} sends nothing"
                said.append(Problem(text, name, False))
            elif sensor["count"] and _is_slow(sensor) and not sensor.get("is_camera"):
                rates = f"{sensor['measured']:.1f} of {sensor['rate']:g} Hz"
                said.append(Problem(f"sensor on {sensor['topic']} sends {rates}", name, False))
    return said


def _motion(report):
    return [Problem(text, "", False) for model in robots(report) for text in _stance(model)]


def notes(report):
    """Sentences about what is worth knowing and no fault of the package or of the simulator."""
    said = [
        f"node {node['name']} ({node['program']}) wants a screen or terminal and was not looked at"
        for node in report["died"]
        if node["screen"]
    ]
    said += [
        f"node {package}/{kind}, a window, is not installed"
        for package, kind in report["cannot"]
        if needs_screen(kind)
    ]
    if report.get("stale"):
        said.append(report["stale"])
    if sum("./run add " in text for text in report.get("problems", ())) > 1:
        words = " ".join(report["checked"])
        said.append(f"./run add --for {words} brings all of these packages and models at once")
    if report.get("was_paused"):
        said.append("the file starts the world paused; the check let it go on")
    factor = report.get("real_time_factor")
    if report["simulator"] and factor is not None and 0.0 < factor < SLOW:
        said.append(f"this machine simulates {factor:.2f} s in a second")
    restless = _restless(report) if report["simulator"] else []
    if restless:
        said.append(f"loose things move, fall or lie: {listed(restless)}")
    for model in report.get("models", ()):
        for sensor in model["sensors"]:
            if not sensor["count"] and _is_early(report, sensor):
                said.append(f"this machine was too slow for a first message on {sensor['topic']}")
            elif sensor.get("is_camera") and sensor["count"] and _is_slow(sensor):
                said.append(
                    f"this machine draws {sensor['topic']} {sensor['measured']:.1f} times a "
                    f"simulated second, {sensor['rate']:g} are wanted"
                )
    return said


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
    texts = [text for model in report["models"] for text in model.get("lost", ())]
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
    return " ".join(named.groups()) if named else text


def _lost(report, text):
    library = LIBRARY.search(check_remedies.finding(text))
    if library is None or "is not known here" not in text:  # a known plugin, a fault of the file
        return text
    remedy = check_remedies.for_plugin(library.group())
    for name, (package, *_) in report.get("builders", {}).items():
        if f"lib{name}.so" == library.group():
            return f"{text}: it is C++ of package {package}; {remedy}"
    return text if "did you mean" in text else f"{text}; {remedy}"


def _refused(report):
    """What roslaunch refuses, and where the packages come from that it misses."""
    sentence = f"roslaunch refuses the file: {report['refused']}"
    named = dict.fromkeys(check_remedies.named_packages(report["refused"]))
    remedies = [f"{name}: {report.get('remedies', {}).get(name)}" for name in named]
    return "; ".join([sentence, *(text for text in remedies if not text.endswith(": None"))])


def _is_installed(report, kind):
    """Whether the package of a node that cannot start is there; those that are not come first."""
    return report.get("builders", {}).get(kind, (None, True))[1]


def _cannot(report, package, kind):
    builder = report.get("builders", {}).get(kind)
    if builder is None:
        return (
            f"node {package}/{kind} cannot start: package {package} has no such node; is the type "
            "spelt as its file, and the file executable?"
        )
    package_of_it, is_there, against = (*builder, "")[:3]
    if not is_there:
        remedy = report.get("remedies", {}).get(package, check_remedies.GENERIC)
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
    if way > STILL and not model.get("driven_by"):
        said.append(f"robot {name} moves by itself: {way:.2f} m while it was watched")
    if tilt(after["orientation"]) > UPRIGHT:
        said.append(f"robot {name} is tilted by {tilt(after['orientation']):.0f} degrees")
    if after["position"][2] < LOWEST:
        said.append(f"robot {name} has fallen to z = {after['position'][2]:.1f} m")
    return said


def _controllers(report, model):
    if model["control_namespace"] is None:
        return []
    where = f"{model['control_namespace'] or '/'}"
    if model.get("controllers") is None:
        return [f"the controller_manager of {model['name']} in {where} does not answer"]
    if not model["controllers"]:
        question = ": is there a spawner, and its YAML?"
        hint = check_companions.hint(report, "controllers", question)
        return [f"no controller is loaded in {where}{hint}"]
    return [
        f"controller {name} in {where} is {state}"
        for name, _, state in model["controllers"]
        if state != "running"
    ]


def _is_slow(sensor):
    return sensor["measured"] is not None and sensor["measured"] < SLOW * sensor["rate"]


def _is_early(report, sensor):
    """Whether a machine that is too slow has not come to a sensor's first message."""
    factor, simulated = report.get("real_time_factor"), report.get("simulated")
    if factor is None or simulated is None or factor >= SLOW:
        return False
    return sensor.get("is_camera") or simulated * sensor["rate"] < FIRST

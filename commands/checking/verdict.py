"""What is wrong with what came up, and the page that tells it."""

import collections
import math

SLOW = 0.9  # of the nominal rate, below which a sensor is too slow
STILL = 0.05  # [m] that a robot nobody drives may move while it is watched
UPRIGHT = 30.0  # [degrees] of tilt up to which a robot stands upright
LOWEST = -1.0  # [m] below which a robot has fallen out of the world


def problems(found):
    """Sentences about what did not come up or does not work; empty: all is well.

    Args:
        found: What observer.py has written.
    """
    said = []
    if found.get("refused"):
        said.append(f"roslaunch refuses the file: {found['refused']}")
    for package, kind in found["cannot"]:
        said.append(
            f"node {package}/{kind} cannot start: is the package {package} there and built?"
        )
    for name, code in found["died"]:
        said.append(f"node {name} died with exit code {code}")
    if not found["simulator"]:
        return [
            *said,
            "no simulator came up: does the file include gazebo_ros's empty_world.launch?",
        ]
    robots = [model for model in found["models"] if not model["static"]]
    if not robots:
        said.append("no robot was spawned")
    for model in robots:
        said += _stance(model)
        said += _controllers(model)
    for model in found["models"]:
        said += [_sensor(model, sensor) for sensor in model["sensors"]]
    return [sentence for sentence in said if sentence]


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


def _controllers(model):
    if model["control_namespace"] is None:
        return []
    where = f"{model['control_namespace'] or '/'}"
    if model.get("controllers") is None:
        return [f"the controller_manager of {model['name']} in {where} does not answer"]
    if not model["controllers"]:
        return [f"no controller is loaded in {where}: is there a spawner, and its YAML?"]
    return [
        f"controller {name} in {where} is {state}"
        for name, _, state in model["controllers"]
        if state != "running"
    ]


def _sensor(model, sensor):
    if not sensor["count"]:
        return f"sensor on {sensor['topic']} of {model['name']} sends nothing"
    measured = sensor["measured"]
    if measured is not None and measured < SLOW * sensor["rate"]:
        return f"sensor on {sensor['topic']} sends {measured:.1f} of {sensor['rate']:g} Hz"
    return None


def page(found, seconds):
    """Lines of the page: robots, sensors, what was ignored, problems."""
    lines = []
    if found["simulator"]:
        factor = found["real_time_factor"]
        factor = "unknown: no /clock" if factor is None else f"{factor:.2f}"
        lines.append(
            f"world {found['world']}, watched for {seconds:g} s, real-time factor {factor}"
        )
        for model in found["models"]:
            if not model["static"]:
                lines += _robot(model)
        lines += _sensors(found)
        lines += _ignored(found)
    wrong = problems(found)
    lines += ["", f"{len(wrong)} problems:" if wrong else "no problems"]
    return lines + [f"  - {sentence}" for sentence in wrong]


def _robot(model):
    after = model.get("after")
    place = "" if after is None else " at ({:.2f}, {:.2f}, {:.2f})".format(*after["position"])
    lines = ["", f"robot {model['name']}{place}"]
    for name, kind, state in model.get("controllers") or ():
        lines.append(f"  {state:11} {name:40} {kind}")
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
    texts = collections.Counter(text for model in found["models"] for text in model["warnings"])
    if not texts:
        return []
    lines = ["", "ignored or mended:"]
    return lines + [
        f"  {count} x {text}" if count > 1 else f"  {text}" for text, count in texts.items()
    ]

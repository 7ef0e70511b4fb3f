"""<joint> elements of a URDF -> joints that make a tree."""

from bullet_sim.description.parts import MOVABLE_TYPES, Joint, Mimic
from bullet_sim.formats.joints import closes_loop, set_stops, unit_axis
from bullet_sim.formats.xml_read import bound_of, floats_of, number_of, urdf_origin

UNSUPPORTED_TYPES = ("floating", "planar")
JOINT_TYPES = MOVABLE_TYPES + ("fixed",) + UNSUPPORTED_TYPES
LEFT_OUT = "joints are left out"


def read_joints(robot, model):
    """Add every <joint> of a <robot> that can be one to the model; others are warnings.

    Args:
        robot: the root element.
        model: ModelDescription with its links.
    """
    for element in robot.findall("joint"):
        joint = _joint(element, model)
        if joint is not None:
            model.joints[joint.name] = joint


def _joint(element, model):
    name = element.get("name") or ""
    what = f"joint '{name}' of '{model.name}'"
    parent, child = (
        found.get("link") if found is not None else None
        for found in (element.find("parent"), element.find("child"))
    )
    fault = _fault(name, parent, child, model)
    if fault:
        element.warn(f"{what} {fault}; it is left out", LEFT_OUT, f"'{name}'")
        return None
    joint = Joint(name, _kind(element, what), parent, child, origin=urdf_origin(element, what))
    axis = element.find("axis")
    if axis is not None:
        vector = floats_of(axis, "xyz", 3, f"{what} axis", (1.0, 0.0, 0.0))
        if joint.kind in MOVABLE_TYPES:
            joint.axis = unit_axis(vector, joint.axis, what, element)
    _limit(element, joint, what)
    dynamics = element.find("dynamics")
    if dynamics is not None:
        joint.damping = max(0.0, number_of(dynamics, "damping", what, 0.0))
        joint.friction = max(0.0, number_of(dynamics, "friction", what, 0.0))
    joint.mimic = _mimic(element, joint, what)
    return joint


def _mimic(element, joint, what):
    mimic = element.find("mimic")
    if mimic is None or joint.kind not in MOVABLE_TYPES:
        return None
    return Mimic(
        mimic.get("joint") or "",
        number_of(mimic, "multiplier", f"{what} mimic", 1.0),
        number_of(mimic, "offset", f"{what} mimic", 0.0),
    )


def check_mimics(model):
    """Drop a <mimic> of a joint that does not exist, with a warning, or of a commanded joint."""
    for joint in model.joints.values():
        if joint.mimic is None:
            continue
        other = model.joints.get(joint.mimic.joint)
        if other is None or other is joint or other.kind not in MOVABLE_TYPES:
            model.warn(
                f"joint '{joint.name}' of '{model.name}' mimics '{joint.mimic.joint}', which is no "
                "other joint that moves; it moves freely",
                "joints mimic what is no other joint that moves, and move freely",
                f"'{joint.name}'",
            )
            joint.mimic = None
        elif joint.name in model.transmissions:
            joint.mimic = None  # controllers move it


def _fault(name, parent, child, model):
    """Why an element is no joint, or ''."""
    if not name:
        return "has no name"
    if name in model.joints:
        return "is there already: there are two joints of that name"
    for end, link in (("parent", parent), ("child", child)):
        if link not in model.links:
            return f"has {end} link '{link}', which does not exist; links are " + ", ".join(
                model.links
            )
    if any(joint.child == child for joint in model.joints.values()):
        return f"gives link '{child}' more than one parent joint"
    return "closes a loop" if closes_loop(model, parent, child) else ""


def _kind(element, what):
    kind = element.get("type")
    if kind in JOINT_TYPES:
        return kind
    lower = str(kind).strip().lower()
    used = lower if lower in JOINT_TYPES else "fixed"
    element.warn(
        f"{what} has type '{kind}', must be one of {', '.join(JOINT_TYPES)}; {used} is used",
        "joints have a type that does not exist",
        f"'{element.get('name')}'",
    )
    return used


def _limit(element, joint, what):
    limit = element.find("limit")
    bounded = joint.kind in ("revolute", "prismatic")
    if limit is None:
        if bounded:
            element.warn(
                f"{what} has no <limit>; it moves without stops",
                "joints that need a <limit> have none and move without stops",
                f"'{joint.name}'",
            )
        return
    joint.effort = abs(bound_of(limit, "effort", f"{what} limit") or 0.0)
    joint.velocity = abs(bound_of(limit, "velocity", f"{what} limit") or 0.0)
    for key in ("effort", "velocity"):
        if limit.get(key) is None and joint.kind != "fixed":
            limit.warn(
                f"{what} limit has no {key}, which URDF demands; it has no such limit",
                f"joint limits have no {key}, which URDF demands, and count as unlimited",
                f"'{joint.name}'",
            )
    if not bounded:
        return
    lower = bound_of(limit, "lower", f"{what} limit", 0.0)
    upper = bound_of(limit, "upper", f"{what} limit", 0.0)
    set_stops(joint, lower, upper, what, element)

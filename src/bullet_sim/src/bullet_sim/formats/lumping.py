"""Which links of a URDF fixed joints merge, and which links are left out, as sdformat 9.3 does it.

Sources: ReduceFixedJoints, FixedJointShouldBeReduced and CreateSDF in parser_urdf.cc.
"""

from __future__ import annotations

from bullet_sim.description.model import Joint, Link, ModelDescription
from bullet_sim.errors import ModelError
from bullet_sim.formats.extensions import is_yes
from bullet_sim.xml_reader import Node

LEAVE_OUT, KEEP = MASSLESS = ("leave_out", "keep")  # what happens to links without mass
NO_MASS = 1e-6  # [kg] up to which a mass counts as 0
CAUSE = "links have no mass and are left out, as in Gazebo"


def check_massless(value: str) -> None:
    """Raise a ModelError where a text is none of MASSLESS."""
    if value not in MASSLESS:
        raise ModelError(f"massless_links is '{value}', must be one of {', '.join(MASSLESS)}")


def says(element: Node, tag: str) -> bool:
    """Whether one of the flags of a <gazebo> element with this tag is set."""
    return any(is_yes(child.get("value", child.text)) for child in element.findall(tag))


def keep_joints(robot: Node, model: ModelDescription, massless: str) -> None:
    """Keep the fixed joints that sdformat is told not to merge: as fixed ones, or, with
    <disableFixedJointLumping> alone, as hinges about z with limits of 0.

    Args:
        massless: of MASSLESS; KEEP: a link without mass is merged nevertheless.
    """
    fixed, hinges = set(), set()
    for element in robot.findall("gazebo"):
        name = element.get("reference") or ""
        if says(element, "preserveFixedJoint"):
            fixed.add(name)
        if says(element, "disableFixedJointLumping"):
            hinges.add(name)
    hinges -= fixed
    for name in sorted(fixed | hinges):
        joint = model.joints.get(name)
        if joint is None or joint.kind != "fixed" or joint.parent == "world":
            continue
        if massless == KEEP and model.links[joint.child].mass <= NO_MASS:
            model.warn(
                f"joint '{name}' is to be kept, but its link '{joint.child}' has no mass; it is "
                "merged, Gazebo leaves it out",
                "joints are to be kept whose links have no mass; these are merged, Gazebo leaves "
                "them out",
                f"'{name}'",
            )
        elif name in fixed:
            model.kept.add(name)
        else:
            joint.kind, joint.axis, joint.lower, joint.upper = "revolute", (0.0, 0.0, 1.0), 0.0, 0.0


def merges(joint: Joint, model: ModelDescription) -> bool:
    """Whether a joint merges its links."""
    return joint.kind == "fixed" and joint.name not in model.kept


def leave_out(model: ModelDescription, hint: str = "") -> set[str]:
    """Leave out links without mass, with their joints and all that hangs on them.

    What fixed joints merge counts together. What turns on a merged link is left out with it where
    that one and what is merged into it have no mass, though its shapes stay.

    Returns:
        Names of the links and joints that are gone.
    """
    above, below = model.above(), model.below()
    order = [model.root]
    for name in order:
        order += [joint.child for joint in below.get(name, ())]
    into = {
        name: above[name].parent
        for name in order[1:]
        if merges(above[name], model) and above[name].parent != "world"
    }
    masses = {name: model.links[name].mass for name in order}
    for name in reversed(order):
        if name in into:
            masses[into[name]] += masses[name]
    reason: dict[str, str] = {}  # link -> the one without mass that it is, or hangs on
    gone: list[str] = []
    for name in order:
        up = above[name].parent if name in above else ""
        if up in reason:
            reason[name] = reason[up]
        elif name != "world" and masses[name] <= NO_MASS:
            reason[name] = name
        if name in into:
            if into[name] in gone:
                gone.append(name)
        elif name in reason:
            gone.append(name)
    all_gone = not model.links.keys() - {*gone, "world"}
    lost = _without(model, gone, reason, all_gone, hint if all_gone else "") if gone else set()
    if all_gone:
        model.links, model.is_empty, model.static = {model.root: Link(model.root)}, True, True
    return lost


def _without(
    model: ModelDescription, gone: list[str], reason: dict[str, str], all_gone: bool, hint: str
) -> set[str]:
    """Remove links and their joints, with one warning."""
    said = [name if reason[name] == name else f"{name} (behind {reason[name]})" for name in gone]
    model.warn(
        f"{'all ' if all_gone else ''}links of '{model.name}' without mass are left out, with "
        f"their joints and all behind them, as in Gazebo: {', '.join(said)}; an <inertial> with an "
        f"<inertia> and a mass above {NO_MASS:g} keeps a link, massless_links 'keep' keeps all"
        f"{hint}",
        CAUSE,
        f"{', '.join(said)} of '{model.name}'",
    )
    lost = {name for name, joint in model.joints.items() if joint.child in gone}
    model.joints = {name: joint for name, joint in model.joints.items() if name not in lost}
    model.links = {name: link for name, link in model.links.items() if name not in gone}
    model.kept -= lost
    return lost | set(gone)

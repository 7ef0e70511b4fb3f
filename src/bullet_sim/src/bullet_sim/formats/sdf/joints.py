"""<joint> elements of SDF models."""

import numpy as np

from bullet_sim.description.parts import Joint, Link
from bullet_sim.formats.joints import closes_loop, set_stops, unit_axis
from bullet_sim.formats.xml_read import (
    child_bound,
    child_flag,
    child_floats,
    child_number,
    child_text,
)
from bullet_sim.pose import Pose

# Joints of several axes become a chain of hinges: the tags of their axes, or the axes.
CHAINS = {
    "universal": ("axis", "axis2"),
    "revolute2": ("axis", "axis2"),
    "ball": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
}
SHARE = 0.01  # of its child's mass and inertia that a link within such a chain has
JOINT_TYPES = ("fixed", "revolute", "prismatic", "continuous", *CHAINS)
LEFT_OUT = "joints are left out"
_UP = (0.0, 0.0, 1.0)


def read_joint(element, reader, prefix, frames, version):
    """Add a <joint> to the model of a reader (model.py), or warn why it is none.

    Args:
        element: the <joint>.
        reader: has the model and the poses of its links.
        prefix: of the names of the nested model that the joint is in.
        frames: Frames of that model.
        version: of the SDF document.
    """
    model, poses = reader.model, reader.poses
    name = prefix + (element.get("name") or "joint")
    what = f"joint '{name}' of '{model.name}'"
    parent, child = child_text(element, "parent"), child_text(element, "child")
    kind = _kind(element, what)
    if child == "world" and kind == "fixed":
        parent, child = child, parent
    if parent == "world" and prefix + str(child) in model.links:
        if kind == "fixed":
            model.fixed_base = True
            return
        model.links.setdefault("world", Link("world"))
        poses.setdefault("world", Pose())
        model.fixed_base, parent = True, "world"
    else:
        parent = prefix + str(parent)
    child = prefix + str(child)
    fault = _fault(model, parent, child)
    if fault:
        element.warn(f"{what} {fault}; it is left out", LEFT_OUT, f"'{name}' of '{model.name}'")
        return
    anchor = Pose()
    if element.find("pose") is not None:
        default = child_text(element, "child", "")
        anchor = frames.pose(default).inverse() * frames.place(element, default, what)
    origin = poses[parent].inverse() * poses[child]
    joint = Joint(name, kind, parent, child, origin, anchor=anchor)
    if kind in CHAINS:
        _chain(element, joint, reader, what, frames, version)
        return
    if kind != "fixed":
        _axis(element, joint, what, frames, version)
    model.joints[name] = joint


def _chain(element, whole, reader, what, frames, version):
    """Add the hinges that make up a joint of several axes, with small links between them.

    The first has the joint's name, the others a number behind it. A ball's middle axis must not
    turn by a quarter.
    """
    model, child, axes = reader.model, reader.model.links[whole.child], CHAINS[whole.kind]
    parent, origin = whole.parent, whole.origin * whole.anchor
    for number, axis in enumerate(axes, 1):
        last = number == len(axes)
        name = whole.name if number == 1 else f"{whole.name}__{number}"
        link = whole.child if last else f"{whole.name}__link{number}"
        if last:
            origin = origin * whole.anchor.inverse()
        joint = Joint(
            name, "continuous", parent, link, origin, anchor=whole.anchor if last else Pose()
        )
        if isinstance(axis, str):
            joint.kind = "revolute"
            _axis(element, joint, what, frames, version, axis, whole.anchor)
        else:
            joint.axis = axis
        model.joints[name] = joint
        if not last:
            moment = SHARE * max(float(child.inertia.trace()) / 3.0, 1e-6)
            model.links[link] = Link(
                link, mass=SHARE * max(child.mass, 1e-3), inertia=moment * np.eye(3)
            )
            reader.poses[link] = reader.poses[whole.child] * whole.anchor
        parent, origin = link, Pose()


def _kind(element, what):
    kind = element.get("type")
    if kind in JOINT_TYPES:
        return kind
    lower = str(kind).strip().lower()
    used = lower if lower in JOINT_TYPES else "fixed"
    element.warn(
        f"{what} has type '{kind}', must be one of {', '.join(JOINT_TYPES)}; {used} is used",
        f"joints have type '{kind}', which is not known here, and are {used}",
        what,
    )
    return used


def _fault(model, parent, child):
    """Why a joint between two links cannot be, or ''."""
    if child not in model.links or parent not in model.links:
        return f"joins '{parent}' and '{child}', links are {', '.join(model.links)}"
    taken = any(joint.child == child for joint in model.joints.values())
    if taken or closes_loop(model, parent, child):
        return f"closes a loop at link '{child}', which cannot be simulated here"
    return ""


def _axis(element, joint, what, frames, version, tag="axis", anchor=None):
    """Read an axis with its limits; anchor: the joint's frame in the child's, if not joint's."""
    anchor = joint.anchor if anchor is None else anchor
    vector = child_floats(element, f"{tag}/xyz", 3, f"{what} {tag}", _UP)
    of_model = child_flag(element, f"{tag}/use_parent_model_frame", what, version < (1, 5))
    found = element.find(f"{tag}/xyz")
    frame = found.get("expressed_in") if found is not None else None
    if of_model or frame:
        own = frames.pose(child_text(element, "child", "")) * anchor
        turn = frames.pose(frame, found) if frame else Pose()
        vector = own.matrix.T @ turn.matrix @ vector
    joint.axis = unit_axis(vector, _UP, what, element)
    if joint.kind != "continuous":
        lower = child_bound(element, f"{tag}/limit/lower", what)
        upper = child_bound(element, f"{tag}/limit/upper", what)
        set_stops(joint, lower, upper, what, element)
    joint.effort = max(0.0, child_bound(element, f"{tag}/limit/effort", what) or 0.0)
    joint.velocity = max(0.0, child_bound(element, f"{tag}/limit/velocity", what) or 0.0)
    joint.damping = max(0.0, child_number(element, f"{tag}/dynamics/damping", what, 0.0))
    joint.friction = max(0.0, child_number(element, f"{tag}/dynamics/friction", what, 0.0))

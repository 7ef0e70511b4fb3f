"""The tree of links that mirrors of a world have: renderers, the page, PyBullet beside `ode`.

Their joints rotate or slide. So a screw and a link that moves freely are chains of such joints, and
a joint that closes a loop ends in a link of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from bullet_sim.description.lump import LumpedModel
from bullet_sim.description.model import Joint, Light, Shape, VisualLink
from bullet_sim.pose import Pose

_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_CHAIN_AXES = (_X, _Y, _Z, _Z, _Y, _X)


def links_between(joint: Joint) -> tuple[str, ...]:
    """Names of the links that mirrors have besides, of a joint: within the chain, and the one at
    the end of a joint that closes a loop. What holds a link in the world is none of theirs."""
    count = {"free": 5, "screw": 1}.get(joint.kind, 0)
    end = end_of(joint)
    names = tuple(f"{end}::free{number}" for number in range(1, count + 1))
    return (*names, end) if joint.closes and not joint.holds else names


def end_of(joint: Joint) -> str:
    """Name of the link that mirrors have below a joint: one without shapes where it closes a
    loop."""
    return f"{joint.name}::end" if joint.closes else joint.child


def chain_of(joint: Joint) -> tuple[Joint, ...]:
    """Joints without limits that put a link where a joint has it that mirrors do not know.

    Of a loose link six, along x, y and z, about z, y and x; of a screw one along its axis, beside
    its own joint, which turns.
    """
    names = (*links_between(joint), joint.child)
    if joint.kind == "screw":
        return (Joint(names[0], "prismatic", joint.parent, names[0], joint.origin, joint.axis),)
    kinds = ("prismatic", "prismatic", "prismatic", "continuous", "continuous", "continuous")
    parts = enumerate(zip(kinds, _CHAIN_AXES, (joint.parent, *names), names), 1)
    return tuple(
        Joint(
            f"{joint.child}::free{number}",
            kind,
            parent,
            child,
            joint.origin if number == 1 else Pose(),
            axis,
        )
        for number, (kind, axis, parent, child) in parts
    )


def mirrored_joints(lumped: LumpedModel) -> list[Joint]:
    """The joints that mirrors move."""
    joints: list[Joint] = []
    for joint in (*lumped.joints, *lumped.welds, *lumped.loose):
        if joint.kind in ("free", "screw"):
            joints += chain_of(joint)
        if joint.kind == "screw":
            parent, origin = links_between(joint)[0], Pose()
            joint = replace(joint, kind="continuous", parent=parent, origin=origin)
        if joint.kind != "free" and not joint.holds:
            joints.append(replace(joint, child=end_of(joint)))
    return joints


def free_coordinates(joint: Joint, root: Pose, pose: Pose) -> tuple[float, ...]:
    """Positions [m, rad] of the joints of chain_of() where a loose link has a pose and the root
    another one."""
    here = (root * joint.origin).inverse() * pose
    return (*here.position, *reversed(here.rpy))


def visual_links(
    lumped: LumpedModel,
    order: Sequence[str],
    visuals: Mapping[str, Iterable[Shape]] | None = None,
) -> tuple[VisualLink, ...]:
    """VisualLinks of a LumpedModel.

    Args:
        order: of mirrored_links().
        visuals: link name -> Shapes to use instead of the links' own.

    Returns:
        Tuple of VisualLink; parents are before their children if they are in `order`.
    """
    joints = {joint.child: joint for joint in mirrored_joints(lumped)}
    rows = {name: row for row, name in enumerate(order)}
    links = []
    for name in order:
        shapes: tuple[Shape, ...] = ()
        lights: tuple[Light, ...] = ()
        if name in lumped.links:
            shapes = tuple(lumped.links[name].visuals if visuals is None else visuals[name])
            lights = tuple(lumped.links[name].lights)
        joint = joints.get(name)
        if joint is None:
            links.append(VisualLink(shapes=shapes, lights=lights))
            continue
        kind = {"prismatic": "prismatic", "fixed": "fixed"}.get(joint.kind, "revolute")
        row = rows[joint.parent]
        links.append(VisualLink(row, joint.origin, kind, joint.axis, shapes, lights))
    return tuple(links)


def mirrored_links(lumped: LumpedModel) -> list[str]:
    """Names of the links that mirrors have: the root, then each followed by those below it."""
    below: dict[str, list[str]] = {}
    for joint in mirrored_joints(lumped):
        below.setdefault(joint.parent, []).append(joint.child)
    pending, names = [lumped.root], []
    while pending:
        name = pending.pop()
        names.append(name)
        pending += reversed(below.get(name, ()))
    return names

"""Links that fixed joints connect, merged into one; inertias that joints have to move.

Lumping: links on fixed joints are merged into their parent, as in Gazebo. Otherwise PyBullet gives
links without <inertial> 1 kg; fewer links also make a step cheaper.
"""

from dataclasses import dataclass, replace

import numpy as np

from bullet_sim.description.model import Joint, Link, ModelDescription, Surface
from bullet_sim.pose import Array, Pose

MIN_MASS = 1e-3  # [kg] of a movable part without mass
TINY_RADIUS = 1e-5  # [m] radius of gyration below which an inertia is an error
WELD_AXIS = (1.0, 0.0, 0.0)  # of the joint that measures the forces in a stiff one
MIN_RADIUS = 5e-3  # [m] least half size of the block whose inertia an impossible one becomes


@dataclass(frozen=True)
class LumpedModel:
    """A model without fixed joints.

    Attributes:
        links: the remaining links by name.
        joints: the movable joints, in the original's order.
        root: name of the root link.
        frames: for every original link: the link it is merged into and its pose in that.
        welds: fixed joints that are not merged, for sensors to measure; continuous ones that a
            motor is to hold, as Bullet's fixed joints lose the contacts beyond them.
    """

    links: dict[str, Link]
    joints: tuple[Joint, ...]
    root: str
    frames: dict[str, tuple[str, Pose]]
    welds: tuple[Joint, ...] = ()


def lump(model: ModelDescription) -> LumpedModel:
    """Merge all fixed joints (of a static model: all joints, at their zero position)."""
    frames = {model.root: (model.root, Pose())}
    links = {model.root: _copy(model.links[model.root])}
    joints: list[Joint] = []
    welds: list[Joint] = []
    pending = [model.root]
    while pending:
        name = pending.pop(0)
        parent, pose = frames[name]
        for joint in model.joints_of(name):
            welded = joint.name in model.measured and not model.static and _is_stiff(joint)
            if not welded and (joint.kind == "fixed" or model.static):
                frames[joint.child] = (parent, pose * joint.origin)
                _merge(links[parent], model.links[joint.child], pose * joint.origin)
            else:
                inner = joint.anchor.inverse()  # the link's frame in the joint's
                frames[joint.child] = (joint.child, inner)
                links[joint.child] = moved(model.links[joint.child], inner)
                kept = replace(
                    joint,
                    kind="continuous" if welded else joint.kind,
                    axis=WELD_AXIS if welded else joint.axis,
                    lower=None if welded else joint.lower,
                    parent=parent,
                    anchor=Pose(),
                    origin=pose * joint.origin * joint.anchor,
                )
                (welds if welded else joints).append(kept)
            pending.append(joint.child)
    if not model.static:
        for link in links.values():
            if model.fixed_base and link.name == model.root and link.mass <= 0:
                link.mass, link.inertia = MIN_MASS, np.eye(3) * MIN_MASS  # fixed to the world
            _mend_inertia(link, model)
    order = list(model.joints)
    joints.sort(key=lambda joint: order.index(joint.name))
    return LumpedModel(links, tuple(joints), model.root, frames, tuple(welds))


def _is_stiff(joint: Joint) -> bool:
    """Whether a joint holds its links: fixed, or with both stops at one place."""
    return joint.kind == "fixed" or (joint.lower is not None and joint.lower == joint.upper == 0.0)


def _copy(link: Link) -> Link:
    return replace(
        link,
        centre=link.centre.copy(),
        inertia=link.inertia.copy(),
        visuals=list(link.visuals),
        collisions=list(link.collisions),
        surface=Surface(**vars(link.surface)),
    )


def moved(link: Link, pose: Pose) -> Link:
    """A copy of a link whose frame gets the given pose in the new one."""
    copy = _copy(link)
    if pose != Pose():
        copy.centre = np.asarray(pose.position) + pose.matrix @ link.centre
        copy.inertia = pose.matrix @ link.inertia @ pose.matrix.T
        copy.visuals = [shape.at(pose) for shape in link.visuals]
        copy.collisions = [shape.at(pose) for shape in link.collisions]
        copy.surface = _turned(link.surface, pose)
    return copy


def _turned(surface: Surface, pose: Pose) -> Surface:
    """A copy of a link's surface in a frame in which the link's frame has the given pose."""
    copy = Surface(**vars(surface))
    if copy.direction is not None:
        x, y, z = (pose.matrix @ np.asarray(copy.direction)).tolist()
        copy.direction = (x, y, z)
    return copy


def _merge(into: Link, link: Link, pose: Pose) -> None:
    """Add a link at a pose to another: parallel-axis theorem about the common centre."""
    mass = into.mass + link.mass
    if link.mass > 0:
        centre = np.asarray(pose.position) + pose.matrix @ link.centre
        common = (into.mass * into.centre + link.mass * centre) / mass
        turned = pose.matrix @ link.inertia @ pose.matrix.T
        into.inertia = (
            into.inertia
            + _shift(into.mass, into.centre - common)
            + turned
            + _shift(link.mass, centre - common)
        )
        into.mass, into.centre = mass, common
    for source, target in ((link.visuals, into.visuals), (link.collisions, into.collisions)):
        target.extend(shape.at(pose) for shape in source)
    into.self_collide |= link.self_collide
    if into.surface.friction is None and link.collisions:
        into.surface = _turned(link.surface, pose)


def _shift(mass: float, arm: Array) -> Array:
    """Inertia (3, 3) of a point mass at an arm (3,) [m]."""
    return mass * (float(arm @ arm) * np.eye(3) - np.outer(arm, arm))


def _mend_inertia(link: Link, model: ModelDescription) -> None:
    if link.mass <= 0:
        model.warn(
            f"link '{link.name}' moves but has no mass; it gets {MIN_MASS} kg",
            f"links move but have no mass; each gets {MIN_MASS} kg",
            f"'{link.name}' of '{model.name}'",
        )
        link.mass = MIN_MASS
    if not np.isfinite(link.inertia).all():  # sums of numbers that are too great
        link.inertia = np.zeros((3, 3))
    moments = np.linalg.eigvalsh(link.inertia)
    if moments[0] <= link.mass * TINY_RADIUS**2:
        link.inertia = _block(link)
        diagonal = " ".join(f"{moment:.3g}" for moment in np.diag(link.inertia))
        model.warn(
            f"link '{link.name}' has an inertia that is impossible or tiny (smallest moment "
            f"{moments[0]:.3g} kg m^2); it gets that of a block of its size, {diagonal}",
            "links have an impossible or tiny inertia and get that of a block of their size",
            f"'{link.name}' of '{model.name}'",
        )


def _block(link: Link) -> Array:
    """Inertia (3, 3) of a solid block with a link's mass that holds its simple collisions.

    A body of size whose inertia is next to nothing spins instead of resting on what it hits, and
    sinks in. Meshes do not count here: their files are not read yet.
    """
    half = np.full(3, MIN_RADIUS)
    for shape in link.collisions:
        size = np.zeros(3)
        if shape.geometry.kind == "box":
            size = np.asarray(shape.geometry.size) / 2.0
        elif shape.geometry.kind == "sphere":
            size = np.full(3, shape.geometry.size[0])
        elif shape.geometry.kind == "cylinder":
            radius, length = shape.geometry.size
            size = np.array((radius, radius, length / 2.0))
        reach = np.abs(shape.pose.matrix) @ size
        half = np.maximum(half, reach + np.abs(np.asarray(shape.pose.position) - link.centre))
    squares = half**2
    return np.diag(link.mass / 3.0 * (squares.sum() - squares))


def joint_inertias(lumped: LumpedModel, fixed_base: bool) -> dict[str, float]:
    """Inertia that an effort of each joint has to move, all joints at 0 and nothing touching.

    Args:
        fixed_base: whether the root link is held by the world.

    Returns:
        Dict of joint name -> [kg m^2], of a prismatic joint [kg]: the reduced inertia of both
        sides, each as one rigid body.
    """
    frames = {lumped.root: Pose()}
    waiting = [*lumped.joints, *lumped.welds]
    while waiting:
        waiting, before = [], waiting
        for joint in before:
            if joint.parent in frames:
                frames[joint.child] = frames[joint.parent] * joint.origin
            else:
                waiting.append(joint)
    result = {}
    for joint in lumped.joints:
        beyond = _descendants(lumped, joint.child)
        frame = frames[joint.child]
        own, rest = (
            sum(_about(lumped.links[name], frames[name], joint, frame) for name in names)
            for names in (
                [name for name in lumped.links if name in beyond],  # in order: the same last bits
                [name for name in lumped.links if name not in beyond],
            )
        )
        result[joint.name] = own if fixed_base or not rest > 0 else own * rest / (own + rest)
    return result


def _descendants(lumped: LumpedModel, link: str) -> set[str]:
    found = {link}
    joints = (*lumped.joints, *lumped.welds)
    for _ in joints:
        found |= {joint.child for joint in joints if joint.parent in found}
    return found


def _about(link: Link, pose: Pose, joint: Joint, frame: Pose) -> float:
    """Inertia of a link at a pose about a joint's axis, or its mass along it."""
    if joint.kind == "prismatic":
        return link.mass
    axis = frame.matrix @ np.asarray(joint.axis)
    arm = np.asarray(pose.position) + pose.matrix @ link.centre - np.asarray(frame.position)
    across = np.cross(axis, arm)
    turned = pose.matrix @ link.inertia @ pose.matrix.T
    return float(axis @ turned @ axis + link.mass * (across @ across))

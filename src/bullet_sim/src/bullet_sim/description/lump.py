"""Links that fixed joints connect, merged into one; reduced inertias of joints.

Lumping: a URDF's links on fixed joints are merged into their parent, as in Gazebo; those of an SDF
stay bodies there, and so do links that are held in the world. Fewer links make a step faster.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bullet_sim.description.held import in_world, on_joints
from bullet_sim.description.model import (
    WORLD_LINK,
    Gears,
    Joint,
    Link,
    ModelDescription,
    Shape,
    Surface,
    fixed_joint,
)
from bullet_sim.pose import Array, Pose, Quat, Vec3, rpy_from_quaternion

MIN_MASS = 1e-3  # [kg] of a movable link without mass
TINY_RADIUS = 1e-5  # [m] radius of gyration below which an inertia is an error
WELD_AXIS = (1.0, 0.0, 0.0)  # of the joint that replaces a fixed one to measure its forces
MIN_RADIUS = 5e-3  # [m] minimum half size of the block whose inertia replaces an impossible one


@dataclass(frozen=True)
class LumpedModel:
    """A model without fixed joints.

    Attributes:
        links: parents first, or in the order of an SDF.
        joints: the movable joints, in the original's order. What closes a loop has the pose of its
            frame in the child's as its anchor, of others it is none.
        frames: for every original link: the link it is merged into and its pose in that link.
        welds: fixed joints that are not merged: continuous ones that a motor has to hold, as
            Bullet drops the contacts of links below its fixed joints.
        loose: of links that move freely: from the root to where each starts, kind 'free'.
        gears: of these links.
        fixed_base: its root never moves.
    """

    links: dict[str, Link]
    joints: tuple[Joint, ...]
    root: str
    frames: dict[str, tuple[str, Pose]]
    welds: tuple[Joint, ...] = ()
    loose: tuple[Joint, ...] = ()
    gears: tuple[Gears, ...] = ()
    fixed_base: bool = False

    def tree(self) -> list[Joint]:
        """Its joints that make a tree, one above each link but the root and what is loose."""
        return [joint for joint in (*self.joints, *self.welds) if not joint.closes]


def lump(model: ModelDescription, as_in_gazebo: bool = False, is_rigid: bool = True) -> LumpedModel:
    """Merge fixed joints (of a static model: all joints, at their zero position).

    Args:
        as_in_gazebo: links in the order in which Gazebo creates them, and its reading of inertias
            that are not positive definite, loose links move, loops are closed; False: those next to
            the root first, in the order of the file, loose links are fixed to the root.
        is_rigid: merge those of an SDF, too, and have what they hold in the world never move.
    """
    is_rigid = is_rigid or model.static or not as_in_gazebo
    given, model = model.links, _prepared(model, as_in_gazebo, is_rigid)
    frames = {root: (root, Pose()) for root in model.loose}
    links = {root: _copy(model.links[root]) for root in model.loose}
    frames[model.root] = model.root, model.root_pose
    links = {model.root: moved(model.links[model.root], model.root_pose), **links}
    joints: list[Joint] = []
    welds: list[Joint] = []
    for joint in as_created(model) if as_in_gazebo else _parents_first(model):
        parent, pose = frames[joint.parent]
        welded = _is_welded(joint, model, is_rigid)
        if not welded and (joint.kind == "fixed" or model.static):
            frames[joint.child] = (parent, pose * joint.origin)
            _merge(links[parent], model.links[joint.child], pose * joint.origin)
        else:
            inner = joint.anchor.inverse()  # the link's frame in the joint's
            frames[joint.child] = (joint.child, inner)
            links[joint.child] = moved(model.links[joint.child], inner)
            (welds if welded else joints).append(_without_anchor(joint, parent, pose, welded))
    if not model.static:
        for joint in (joint for joint in model.joints.values() if joint.closes):
            closing = _closing(joint, frames)
            if closing.parent != closing.child:
                (welds if joint.kind == "fixed" else joints).append(closing)
        for link in links.values():
            _repair_inertia(link, model, as_in_gazebo)
    order = {name: number for number, name in enumerate(model.joints)}
    joints.sort(key=lambda joint: order[joint.name])
    loose = tuple(
        Joint(f"{name}::free", "free", model.root, name, pose) for name, pose in model.loose.items()
    )
    if as_in_gazebo and not model.is_urdf:
        links = {name: links[name] for name in model.links if name in links}
    elif loose:
        links = _sorted(links, list(model.links), [j for j in (*joints, *welds) if not j.closes])
    gears = () if model.static else tuple(_merged(g, frames) for g in model.gears.values())
    if WORLD_LINK in given:  # a root that is none any more
        frames.setdefault(WORLD_LINK, (model.root, Pose()))
    return LumpedModel(
        links, tuple(joints), model.root, frames, tuple(welds), loose, gears, model.fixed_base
    )


def _prepared(model: ModelDescription, as_in_gazebo: bool, is_rigid: bool) -> ModelDescription:
    """A model of what a solver knows, before links are merged; arguments of lump()."""
    model = in_world(model) if is_rigid else on_joints(model, as_created(model))
    if model.loose and (model.static or not as_in_gazebo):
        model = _with_loose_links_fixed(model)
    return model if as_in_gazebo else _without_loops(_without_threads(model))


def _closing(joint: Joint, frames: Mapping[str, tuple[str, Pose]]) -> Joint:
    """A joint that closes a loop, between links that remain, which may be the same."""
    parent, pose = frames.get(joint.parent, (joint.parent, Pose()))
    child, inside = frames[joint.child]
    closing = _without_anchor(joint, parent, pose, joint.kind == "fixed" and not joint.holds)
    closing.child, closing.anchor = child, inside * joint.anchor
    return closing


def _without_anchor(joint: Joint, parent: str, pose: Pose, welded: bool) -> Joint:
    """A joint whose child's frame is that of the joint.

    Args:
        parent: link that remains of its parent, which has there the pose.
        welded: it does not move.
    """
    return replace(
        joint,
        kind="continuous" if welded else joint.kind,
        axis=WELD_AXIS if welded else joint.axis,
        lower=None if welded else joint.lower,
        parent=parent,
        anchor=Pose(),
        origin=pose * joint.origin * joint.anchor,
    )


def _merged(gears: Gears, frames: Mapping[str, tuple[str, Pose]]) -> Gears:
    """Gears of the links that remain."""
    first, pose = frames[gears.first]
    second, second_pose = frames[gears.second]
    (a, b, c), (d, e, f) = (
        (pose.matrix @ np.array(gears.axis)).tolist(),
        (second_pose.matrix @ np.array(gears.second_axis)).tolist(),
    )
    base = frames[gears.base][0]
    return replace(
        gears, first=first, second=second, base=base, axis=(a, b, c), second_axis=(d, e, f)
    )


def _without_threads(model: ModelDescription) -> ModelDescription:
    """A model whose screws are fixed and that has no gears, with warnings: Bullet has none."""
    joints = dict(model.joints)
    for joint in model.joints.values():
        if joint.kind == "screw":
            joints[joint.name] = replace(joint, kind="fixed")
    held = [name for name, joint in model.joints.items() if joint.kind == "screw"]
    for name in (*held, *model.gears):
        model.warn(
            f"joint '{name}' of '{model.name}' is a screw or a gearbox, which the solver 'bullet' "
            "does not have; it is fixed, or left out",
            "joints are screws or gearboxes, which the solver 'bullet' does not have",
            f"'{name}' of '{model.name}'",
        )
    return replace(model, joints=joints, gears={})


def _without_loops(model: ModelDescription) -> ModelDescription:
    """A model without the joints that close loops, with warnings: Bullet's bodies are trees."""
    for joint in model.joints.values():
        if joint.closes and not model.static:
            model.warn(
                f"joint '{joint.name}' of '{model.name}' closes a loop at link '{joint.child}', "
                "which the solver 'bullet' cannot simulate; it is left out",
                "joints close loops and are left out by the solver 'bullet'",
                f"'{joint.name}' of '{model.name}'",
            )
    joints = {name: joint for name, joint in model.joints.items() if not joint.closes}
    return replace(model, joints=joints)


def _with_loose_links_fixed(model: ModelDescription) -> ModelDescription:
    """A model whose loose links are fixed to its root; a warning tells of each that could move."""
    joints = dict(model.joints)
    for name, pose in model.loose.items():
        held = fixed_joint(model.root, model.root_pose, name, pose)
        joints[held.name] = held
        if not model.static:
            model.warn(
                f"link '{name}' of '{model.name}' has no joint; it is fixed to '{model.root}'",
                "links have no joint and are fixed to the first link of their model",
                f"'{name}' of '{model.name}'",
            )
    return replace(model, joints=joints, loose={})


def _sorted(
    links: dict[str, Link], order: Sequence[str], joints: Iterable[Joint]
) -> dict[str, Link]:
    """Links in the order of the file, if there parents come first."""
    placed = {name: number for number, name in enumerate(order) if name in links}
    if any(placed[joint.parent] > placed[joint.child] for joint in joints):
        return links
    return {name: links[name] for name in placed}


def _parents_first(model: ModelDescription) -> list[Joint]:
    """Joints, those next to the root first."""
    below = model.below()
    found = [*below.get(model.root, ())]
    for joint in found:
        found += below.get(joint.child, ())
    return found


def as_created(model: ModelDescription) -> list[Joint]:
    """Joints in the order in which Gazebo creates them and their links.

    Those of a URDF as sdformat writes them: from the root, depth first, the joints of each link by
    their names; also what is merged comes in this order. Those of an SDF as they are in the file,
    as far as parents come first.
    """
    found: list[Joint] = []
    below, roots = model.below(), (*model.loose, model.root)
    if model.is_urdf:
        for joints in below.values():
            joints.sort(key=lambda joint: joint.name, reverse=True)
        pending = [joint for root in roots for joint in below.get(root, ())]
        while pending:
            found.append(pending.pop())
            pending += below.get(found[-1].child, ())
        return found
    order = {name: number for number, name in enumerate(model.above())}
    ready = [order[joint.child] for root in {*roots} for joint in below.get(root, ())]
    heapq.heapify(ready)
    joints = list(model.above().values())
    while ready:
        joint = joints[heapq.heappop(ready)]
        found.append(joint)
        for each in below.get(joint.child, ()):
            heapq.heappush(ready, order[each.child])
    return found


def as_printed(model: LumpedModel) -> LumpedModel:
    """A model of a URDF with the numbers that it has in Gazebo.

    Gazebo loads the SDF that sdformat has made of the URDF, where a number has six digits, of a
    pose at most six after the point. A rim that touches the ground earlier than the other one by a
    micrometer turns a robot elsewhere.
    """
    links = {
        name: replace(
            link,
            mass=_printed(link.mass),
            center=np.array(_printed_vector(link.center)),
            inertia=np.array([[_printed(value) for value in row] for row in link.inertia]),
            collisions=[_printed_shape(shape) for shape in link.collisions],
        )
        for name, link in model.links.items()
    }
    joints, welds, loose = (
        tuple(
            replace(
                joint,
                origin=_printed_pose(joint.origin),
                axis=_printed_vector(joint.axis),
                anchor=_printed_pose(joint.anchor),
                lower=None if joint.lower is None else _printed(joint.lower),
                upper=None if joint.upper is None else _printed(joint.upper),
            )
            for joint in some
        )
        for some in (model.joints, model.welds, model.loose)
    )
    return replace(model, links=links, joints=joints, welds=welds, loose=loose)


def _printed(value: float) -> float:
    return float(f"{value:.6g}")


def _printed_vector(vector: Iterable[float]) -> Vec3:
    x, y, z = (_printed(round(float(value), 6)) for value in vector)
    return x, y, z


def _printed_pose(pose: Pose, rpy: Vec3 | None = None) -> Pose:
    rpy = _upright_rpy(pose.orientation) if rpy is None else rpy
    return Pose.from_xyz_rpy(_printed_vector(pose.position), _printed_vector(rpy))


def _upright_rpy(quaternion: Quat) -> Vec3:
    """As Quaternion::Euler of ignition-math: at a pitch of 90 degrees the yaw is 0."""
    x, y, z, w = quaternion
    sine = 2.0 * (w * y - x * z)
    if 1.0 - abs(sine) >= 1e-15:
        return rpy_from_quaternion(quaternion)
    side = math.copysign(1.0, sine)
    roll = math.atan2(2.0 * side * (x * y - z * w), w * w - x * x + y * y - z * z)
    return roll, side * 0.5 * math.pi, 0.0


def _snapped_rpy(quaternion: Quat) -> Vec3:
    """As Rotation::getRPY of urdfdom_headers: a pitch within 0.26 degrees of 90 is 90 degrees."""
    x, y, z, w = quaternion
    sine = 2.0 * (w * y - x * z)
    if abs(sine) < 0.99999:
        return rpy_from_quaternion(quaternion)
    side = math.copysign(1.0, sine)
    return 0.0, side * 0.5 * math.pi, 2.0 * math.atan2(-side * x, side * y)


def _printed_shape(shape: Shape) -> Shape:
    geometry = replace(shape.geometry, size=tuple(map(_printed, shape.geometry.size)))
    snapped = Pose.from_xyz_rpy((0.0, 0.0, 0.0), _snapped_rpy(shape.pose.orientation))
    pose = _printed_pose(shape.pose, _upright_rpy(snapped.orientation))
    return replace(shape, geometry=geometry, pose=pose)


def _is_welded(joint: Joint, model: ModelDescription, is_rigid: bool) -> bool:
    """Whether a joint is kept though it cannot move: it is fixed, or both of its limits are 0."""
    kept = joint.name in model.measured or joint.name in model.kept
    kept |= not (is_rigid or model.is_urdf) and joint.kind == "fixed"
    stiff = joint.kind == "fixed" or (joint.lower is not None and joint.lower == joint.upper == 0.0)
    return kept and stiff and not model.static


def _copy(link: Link) -> Link:
    return replace(
        link,
        center=link.center.copy(),
        inertia=link.inertia.copy(),
        visuals=list(link.visuals),
        lights=list(link.lights),
        collisions=_collisions(link),
        surface=Surface(**vars(link.surface)),
    )


def _collisions(link: Link) -> list[Shape]:
    """A link's collisions, each with its surface."""
    return [replace(shape, surface=shape.surface or link.surface) for shape in link.collisions]


def moved(link: Link, pose: Pose) -> Link:
    """A copy of a link whose frame gets the given pose in the new one."""
    copy = _copy(link)
    if pose != Pose():
        copy.center = np.asarray(pose.position) + pose.matrix @ link.center
        copy.inertia = pose.matrix @ link.inertia @ pose.matrix.T
        copy.visuals = [shape.at(pose) for shape in link.visuals]
        copy.collisions = [shape.at(pose) for shape in copy.collisions]
        copy.lights = [light.at(pose) for light in link.lights]
        copy.surface = _rotated(link.surface, pose)
    return copy


def _rotated(surface: Surface, pose: Pose) -> Surface:
    """A copy of a link's surface in a frame in which the link's frame has the given pose."""
    copy = Surface(**vars(surface))
    if copy.direction is not None:
        x, y, z = (pose.matrix @ np.asarray(copy.direction)).tolist()
        copy.direction = (x, y, z)
    return copy


def _merge(into: Link, link: Link, pose: Pose) -> None:
    """Add a link at a pose to another: parallel-axis theorem about the common center."""
    mass = into.mass + link.mass
    if link.mass > 0:
        center = np.asarray(pose.position) + pose.matrix @ link.center
        common = (into.mass * into.center + link.mass * center) / mass
        rotated = pose.matrix @ link.inertia @ pose.matrix.T
        into.inertia = (
            into.inertia
            + _shift(into.mass, into.center - common)
            + rotated
            + _shift(link.mass, center - common)
        )
        into.mass, into.center = mass, common
    for source, target in ((link.visuals, into.visuals), (_collisions(link), into.collisions)):
        target.extend(shape.at(pose) for shape in source)
    into.lights.extend(light.at(pose) for light in link.lights)
    into.self_collide |= link.self_collide
    into.kinematic |= link.kinematic
    if into.surface.friction is None and link.collisions:
        into.surface = _rotated(link.surface, pose)


def _shift(mass: float, arm: Array) -> Array:
    """Inertia (3, 3) of a point mass at an arm (3,) [m]."""
    return mass * (float(arm @ arm) * np.eye(3) - np.outer(arm, arm))


def _repair_inertia(link: Link, model: ModelDescription, as_in_gazebo: bool) -> None:
    if model.fixed_base and link.name == model.root and link.mass <= 0:
        link.mass, link.inertia = MIN_MASS, np.eye(3) * MIN_MASS  # fixed to the world
    given = link.mass > 0 and np.isfinite(link.inertia).all()
    if link.mass <= 0:
        model.warn(
            f"link '{link.name}' moves but has no mass; it gets {MIN_MASS} kg",
            f"links move but have no mass; each gets {MIN_MASS} kg",
            f"'{link.name}' of '{model.name}'",
        )
        link.mass = MIN_MASS
    if not np.isfinite(link.inertia).all():  # sums of numbers that are too large
        link.inertia = np.zeros((3, 3))
    moments = np.linalg.eigvalsh(link.inertia)
    if as_in_gazebo and given and moments[0] <= 0.0:
        link.inertia = np.eye(3)  # ODE (dBodySetMass) takes the identity for its inverse
        model.warn(
            f"link '{link.name}' has an inertia that is not positive definite (smallest moment "
            f"{moments[0]:.3g} kg m^2); it turns like 1 kg m^2 about each axis, as in Gazebo",
            "links have an inertia that is not positive definite and turn like 1 kg m^2",
            f"'{link.name}' of '{model.name}'",
        )
    elif moments[0] <= link.mass * TINY_RADIUS**2:
        link.inertia = _block(link)
        diagonal = " ".join(f"{moment:.3g}" for moment in np.diag(link.inertia))
        model.warn(
            f"link '{link.name}' has an inertia that is impossible or tiny (smallest moment "
            f"{moments[0]:.3g} kg m^2); it gets that of a block of its size, {diagonal}",
            "links have an impossible or tiny inertia and get that of a block of their size",
            f"'{link.name}' of '{model.name}'",
        )


def _block(link: Link) -> Array:
    """Inertia (3, 3) of a solid block with a link's mass that contains its simple collisions.

    A body whose inertia is far too small for its size spins instead of coming to rest on what it
    hits, and sinks in. Meshes are ignored: their files are not read yet.
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
        extent = np.abs(shape.pose.matrix) @ size
        half = np.maximum(half, extent + np.abs(np.asarray(shape.pose.position) - link.center))
    squares = half**2
    return np.diag(link.mass / 3.0 * (squares.sum() - squares))


def joint_inertias(
    lumped: LumpedModel, fixed_base: bool, names: Collection[str]
) -> dict[str, float]:
    """Inertia that an effort of some joints accelerates, all joints at 0 and without contacts.

    Args:
        fixed_base: whether the root link is fixed to the world.
        names: of the joints.

    Returns:
        Dict of joint name -> [kg m^2], of a prismatic joint [kg]: the reduced inertia of both
        sides, each as one rigid body.
    """
    if not names:
        return {}
    tree, frames = lumped.tree(), {lumped.root: Pose()}
    below: dict[str, list[Joint]] = {}
    for joint in (*tree, *lumped.loose):
        below.setdefault(joint.parent, []).append(joint)
    for name in (pending := [lumped.root]):
        for joint in below.get(name, ()):
            frames[joint.child] = frames[name] * joint.origin
            pending.append(joint.child)
    bodies = _Bodies(lumped, frames)
    connected = {}  # link -> the root or loose link above it
    for start in (lumped.root, *(joint.child for joint in lumped.loose)):
        connected.update(dict.fromkeys(_descendants(tree, start), start))
    result = {}
    for joint in (joint for joint in lumped.joints if joint.name in names):
        inside, start = _descendants(tree, joint.child), connected[joint.child]
        about = bodies.about(joint, frames[joint.child] * joint.anchor)
        child_side, parent_side = 0.0, 0.0  # in the links' order: reproducible rounding
        for name, inertia in zip(lumped.links, about):
            if name in inside:
                child_side += inertia
            elif connected[name] == start:
                parent_side += inertia
        result[joint.name] = (
            child_side
            if fixed_base and start == lumped.root or not parent_side > 0
            else child_side * parent_side / (child_side + parent_side)
        )
    return result


def _descendants(tree: Iterable[Joint], link: str) -> set[str]:
    """Names of a link and of those below it."""
    below: dict[str, list[str]] = {}
    for joint in tree:
        below.setdefault(joint.parent, []).append(joint.child)
    found = [link]
    for name in found:
        found += below.get(name, ())
    return set(found)


class _Bodies:
    """Centers and inertias of a model's links in the world, at poses of their frames."""

    def __init__(self, lumped: LumpedModel, frames: Mapping[str, Pose]) -> None:
        poses = [(link, frames[name]) for name, link in lumped.links.items()]
        self._masses = np.array([link.mass for link, _ in poses])
        self._centers = np.array(
            [np.asarray(pose.position) + pose.matrix @ link.center for link, pose in poses]
        )
        self._inertias = np.array(
            [pose.matrix @ link.inertia @ pose.matrix.T for link, pose in poses]
        )

    def about(self, joint: Joint, frame: Pose) -> list[float]:
        """Inertia of each link about a joint's axis, or its mass along it."""
        if joint.kind == "prismatic":
            masses: list[float] = self._masses.tolist()
            return masses
        axis = frame.matrix @ np.asarray(joint.axis)
        across = np.cross(axis, self._centers - np.asarray(frame.position))
        own = np.matmul((axis @ self._inertias)[:, None, :], axis[:, None])[:, 0, 0]
        far = np.matmul(across[:, None, :], across[:, :, None])[:, 0, 0]
        inertias: list[float] = (own + self._masses * far).tolist()
        return inertias

"""A loaded model: its body in the engine, its links, whether its state is plausible."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Tuple

import numpy as np

from bullet_sim.controllers.limits import UNLIMITED_EFFORT, UNLIMITED_SPEED
from bullet_sim.controllers.manager import Manager
from bullet_sim.description.collisions import collision_names
from bullet_sim.description.lump import joint_inertias, visual_links
from bullet_sim.description.model import (
    EVERYTHING,
    Joint,
    Link,
    ModelDescription,
    Shape,
)
from bullet_sim.errors import ModelError
from bullet_sim.meshes.prepare import prepare_meshes
from bullet_sim.models.joints import Joints, Mimics
from bullet_sim.models.urdf_writer import prepared_urdf
from bullet_sim.pose import (
    PLACEABLE,
    Array,
    Motion,
    Pose,
    Quat,
    Vec3,
    Vector,
    cross,
    velocity_at,
)
from bullet_sim.snapshot import BodySource, BodyState

if TYPE_CHECKING:
    from bullet_sim.engine import Engine

FARTHEST = 2e3  # [m] from the origin
FASTEST = 200.0  # [m/s]
PERIOD = 0.25  # [s] of simulated time between two checks


def implausible_state(model: Model, engine: Engine) -> str | None:
    """Describe what is implausible about a model's position and velocity, or None.

    Returns:
        A message that names the model.
    """
    position, _, linear, _ = engine.link_motion(model.body, -1)
    text = ", ".join(f"{value:.4g}" for value in position)
    if not all(math.isfinite(value) for value in (*position, *linear)):
        return (
            f"model '{model.name}' has no finite position or velocity any more ({text}); delete "
            "and spawn it again, and look at its masses, inertias and gains"
        )
    speed = math.hypot(*linear)
    if speed > FASTEST:
        return (
            f"model '{model.name}' moves at {speed:.4g} m/s at ({text}), faster than makes sense "
            f"(above {FASTEST:g} m/s); look at its masses, inertias, gains and where it was spawned"
        )
    if math.hypot(*position) > FARTHEST:
        return (
            f"model '{model.name}' has left: it is at ({text}), more than {FARTHEST:g} m from the "
            "origin; is there a ground below it?"
        )
    return None


MAX_VELOCITY = 1e6  # [m/s, rad/s] bound of set_state along each axis
_REST = (0.0, 0.0, 0.0)
_SAME = Pose()
_HULL_OVERLAP = 1e-3  # [m]
Placed = Tuple[Pose, Vector, Vector]  # pose and velocities of set_state


def _has_mesh(link: Link) -> bool:
    return any(shape.geometry.kind == "mesh" for shape in link.collisions)


class Model:
    """A loaded ModelDescription.

    Args:
        key: identifier in snapshots.
        pose: world Pose of the root link's frame.
        folder: where the prepared URDF is written.

    Attributes:
        body: its index in the engine.
        loaded_links: names of the engine's links, the root first, which source.links describes.
        measured: joint name -> number of the engine's, of joints that are measured.
        bodies: names of the links that Gazebo has: of a URDF those into which fixed joints merge
            others; in the place of `world` those that are fixed to it.

    Raises:
        ModelError: PyBullet refuses it.
    """

    def __init__(
        self, engine: Engine, key: int, description: ModelDescription, pose: Pose, folder: str
    ) -> None:
        self.name = description.name
        self.description = description
        self.initial_pose = pose
        self.engine = engine
        self._key = key
        self._state: BodyState | None = None  # of what is static ...
        self._placements = -1  # ... as of these of the engine
        self._changes: dict[tuple[str, str], Callable[[], None]] = {}
        # mass, center of mass and inertia of links as they were set last
        self.told: dict[str, tuple[float, Array, Array]] = {}
        self._lumped = engine.lump(description)
        visuals = prepare_meshes(self._lumped, folder, description.warn)
        path = os.path.join(folder, f"{key}.urdf")
        with open(path, "w", encoding="utf-8") as file:
            file.write(prepared_urdf(self._lumped, description.static))
        self.source = BodySource(key, path, description.static or description.fixed_base)
        self.loaded_links = self._load()
        links = visual_links(self._lumped, self.loaded_links, visuals)
        self.source = replace(self.source, links=links)
        self.bodies = self._bodies()
        self._at_parts = all(self.link_in_body(body)[1] == _SAME for body in self.bodies)
        self.joints = Joints(engine, self.body, self._lumped.joints)
        mimics = {joint.name: joint.mimic for joint in self._lumped.joints if joint.mimic}
        inertias = joint_inertias(self._lumped, description.fixed_base, mimics)
        self.mimics = Mimics(self.joints, mimics, inertias)
        self.manager = (
            None if description.control_namespace is None else Manager(self.joints, description)
        )
        if self.manager is not None:
            self.manager.hardware.restart()

    def _load(self) -> list[str]:
        """Load it; gives the names of the engine's links, the root first, in its order."""
        self.placed: Placed | None = None  # what set_state has set since it was loaded
        self._moved: set[int] = set()  # links that set_link_state has placed since then
        engine, lumped, description = self.engine, self._lumped, self.description
        pose, links = self.initial_pose, lumped.links
        pairs = self._self_colliding()
        self.body = body = engine.load(
            self.source.path,
            pose.position,
            pose.orientation,
            self.source.fixed_base,
            self_collide=bool(pairs),
            static=description.static,
        )
        found = dict.fromkeys(links, -1) if description.static else engine.link_indices(body)
        self._links = index = {name: found[name] for name in found if name in links}
        if pairs:
            for one, other in itertools.combinations(links, 2):
                if (one, other) not in pairs:
                    engine.set_pair_collision(body, index[one], body, index[other], False)
            pairs = self._separate_hulls(pairs)
        engine.take(body, lumped, index, description, pairs)
        for name, link in links.items():
            if link.surface.bitmask != EVERYTHING:
                engine.set_bitmask(body, index[name], link.surface.bitmask)
        names = engine.joint_names(body)
        self.measured = {
            joint.name: names.index(joint.name)
            for joint in (*lumped.joints, *lumped.welds)
            if joint.name in description.measured
        }
        for number in self.measured.values():
            engine.measure_joint(body, number)
        for joint in lumped.welds:
            number = names.index(joint.name)
            engine.drive_position(body, number, 0.0, UNLIMITED_EFFORT, UNLIMITED_SPEED)
        for change in self._changes.values():
            change()
        self._start = engine.joint_positions(body)  # of its joints
        return sorted(found, key=found.__getitem__)

    def _self_colliding(self) -> list[tuple[str, str]]:
        """Pairs of links that collide with each other, in the order of the links.

        None that a joint connects. As in Gazebo it is enough that one has self_collide; where one
        has a mesh, whose hull counts here, both need it.
        """
        links = self._lumped.links
        joints = (*self._lumped.joints, *self._lumped.welds)
        neighbors = {frozenset((joint.parent, joint.child)) for joint in joints}
        every = self.description.self_collide
        wanted = {name for name, link in links.items() if every or link.self_collide}
        meshes = {name for name, link in links.items() if _has_mesh(link)}
        return [
            (one, other)
            for one, other in (itertools.combinations(links, 2) if wanted else ())
            if (one in wanted) + (other in wanted) > (one in meshes or other in meshes)
            and frozenset((one, other)) not in neighbors
        ]

    def _separate_hulls(self, pairs: list[tuple[str, str]]) -> list[tuple[str, str]]:
        """Switch off the collision of self-colliding links of which a mesh's convex hull overlaps
        the other where the model is loaded, as a body does the wheels in its arches.

        Returns:
            The other pairs.
        """
        index, links = self._links, self._lumped.links
        touching = []
        for one, other in pairs:
            pair = self.body, index[one], self.body, index[other]
            is_hull = _has_mesh(links[one]) or _has_mesh(links[other])
            depth = self.engine.pair_depth(*pair) if is_hull else 0.0
            if depth <= _HULL_OVERLAP:
                touching.append((one, other))
                continue
            self.engine.set_pair_collision(*pair, False)
            self.description.warn(
                f"links {one!r} and {other!r} do not collide with each other: where the model "
                f"is loaded they overlap by {depth:.3g} m (meshes collide as convex hulls)",
                "pairs of links do not collide with each other",
                f"{one}, {other}",
            )
        return touching

    def change(self, key: tuple[str, str], change: Callable[[], None]) -> None:
        """Apply a change to the body now and after every reload.

        Args:
            key: of the changed property; a later change of the same key replaces this one.
            change: function without arguments that calls the engine with self.body.
        """
        change()
        self._changes[key] = change

    def make_ghost(self) -> None:
        """Allow the model contacts only with what never moves; call it before the first step.

        Several robots can then train in one world, each as if it were alone.
        """
        for name in self._lumped.links:

            def set_ghost(name: str = name) -> None:
                self.engine.set_ghost(self.body, self._links[name])

            self.change(("ghost", name), set_ghost)

    def apply_wrench(self, index: int, force: Vector, torque: Vector) -> None:
        """Apply a force and a torque (world axes) to a link of the body for one step."""
        self.engine.apply_wrench(self.body, index, force, torque)

    def reload(self) -> None:
        """Reload into a cleared engine, at the initial pose; controllers restart."""
        self._load()
        self.joints.rebind(self.body)
        self.mimics.restart()
        if self.manager is not None:
            self.manager.restart()

    def put_back(self, time: float, with_joints: bool = False) -> None:
        """Put it to its initial pose, at rest.

        Args:
            with_joints: its joints and loose links, too, are put to where they were when it was
                loaded.
            time: now [s], for its controllers: see Manager.forget_updates.
        """
        if with_joints and self._lumped.loose:
            self.engine.gather(self.body)
        self.set_state(self.initial_pose)
        if not self.is_static:
            now = self.engine.joint_positions(self.body)
            self.engine.set_joint_positions(self.body, self._start if with_joints else now)
        if self.manager is not None:
            self.manager.forget_updates(time)

    def save_state(self) -> tuple[Placed | None, tuple[float, ...], dict[int, Motion]]:
        """The pose and velocity set by set_state since it was loaded (or None), the joints, and
        motions of links that were placed by themselves."""
        links = {index: self._center_motion(index) for index in sorted(self._moved)}
        return self.placed, self.engine.joint_positions(self.body), links

    def _center_motion(self, index: int) -> Motion:
        """Pose of a link's frame and the velocity of its center of mass."""
        position, orientation, linear, angular = self.engine.link_motion(self.body, index)
        center = self.engine.link_center(self.body, index)
        return position, orientation, velocity_at(center, position, linear, angular), angular

    def restore_state(
        self, state: tuple[Placed | None, tuple[float, ...], dict[int, Motion]]
    ) -> None:
        """Restore the result of save_state() after a reload; controllers restart."""
        placed, joints, links = state
        if placed is not None:
            self.set_state(*placed)
        if joints != self.engine.joint_positions(self.body):
            self.engine.set_joint_positions(self.body, joints)
            if self.manager is not None:
                self.manager.restart()
        for index, motion in links.items():
            self.engine.place_link(self.body, index, *motion)
            self._moved.add(index)

    @property
    def is_static(self) -> bool:
        """Whether it never moves."""
        return self.description.static

    def _bodies(self) -> tuple[str, ...]:
        described, joints = self.description, self.description.joints.values()
        if not described.is_urdf:
            return tuple(described.links)
        held = {"world"} if described.fixed_base else set()
        merged = {
            joint.child
            for joint in joints
            if joint.kind == "fixed" and joint.parent not in held and joint.child not in self._links
        }
        parts = [*self._links, *described.links] if self.is_static else [*self._lumped.links]
        names: list[str] = []
        for part in parts:
            if part in held:
                names += [j.child for j in described.joints_of(part) if j.kind == "fixed"]
            elif part not in merged:
                names.append(part)
        return tuple(dict.fromkeys(names))

    def stays(self, joint: str) -> bool:
        """Whether a joint is one in Gazebo: sdformat merges the links of a URDF's fixed ones, and
        none holds a link of an SDF that has no joint."""
        child = self.description.joints[joint].child
        return child in self.bodies and joint != f"{child}__fixed"

    @property
    def rigid_parts(self) -> dict[str, Link]:
        """Links that remain when fixed joints are merged: Link by name."""
        return self._lumped.links

    @property
    def parts_joints(self) -> tuple[Joint, ...]:
        """Joints that remain when fixed joints are merged."""
        return self._lumped.joints

    def collisions(self) -> Iterator[Shape]:
        """The collisions of all rigid_parts."""
        return (shape for link in self._lumped.links.values() for shape in link.collisions)

    def index(self, part: str) -> int:
        """Index in the engine of one of the rigid_parts."""
        return self._links[part]

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of all links of the original description."""
        return tuple(self.description.links)

    def link_in_body(self, link: str) -> tuple[int, Pose]:
        """The link of the body that a link is merged into: (its index in the engine, Pose in it).

        Raises:
            ModelError: no such link.
        """
        if link not in self._lumped.frames:
            raise ModelError(
                f"model '{self.name}' has no link '{link}'; links are {', '.join(self.link_names)}"
            )
        name, pose = self._lumped.frames[link]
        return self._links[name], pose

    def is_merged(self, link: str) -> bool:
        """Whether a link of the description is a part of another one in the body."""
        return self._lumped.frames[link][0] != link

    def frame_at(self, index: int) -> tuple[Vec3, Quat]:
        """World pose of a link's frame (index in the engine): position and quaternion, tuples."""
        return self.engine.link_motion(self.body, index)[:2]

    @cached_property
    def collision_names(self) -> dict[tuple[str, int], str]:
        """See description.collisions."""
        return collision_names(self.description)

    def collisions_at(self, index: int) -> tuple[str, list[Shape]]:
        """Collision Shapes of a link of the body (index in the engine), in its frame.

        Returns:
            Name of the link, Shapes with the links and names that they had in the file.
        """
        name = next(name for name, other in self._links.items() if other == index)
        return name, self._lumped.links[name].collisions

    def link_state(self, link: str) -> tuple[Pose, Array, Array]:
        """Pose of a link's frame and its origin's velocity in the world.

        Returns:
            Pose, linear (3,) [m/s], angular (3,) [rad/s]; velocities along world axes.
        """
        index, offset = self.link_in_body(link)
        position, orientation, linear, angular = self.engine.link_motion(self.body, index)
        frame = Pose(position, orientation)
        if offset == _SAME:  # not merged into another link
            return frame, np.array(linear), np.array(angular)
        arm = frame.matrix @ np.asarray(offset.position)
        return frame * offset, linear + cross(angular, arm), np.array(angular)

    def link_motion(self, link: str) -> tuple[Vec3, Quat, Vec3, Vec3]:
        """As link_state, in four tuples: position, quaternion, linear and angular velocity."""
        index, offset = self.link_in_body(link)
        if offset == _SAME:
            return self.engine.link_motion(self.body, index)
        return self.engine.link_motion(self.body, index, (offset.position, offset.orientation))

    def body_motions(self) -> list[Motion]:
        """As link_motion, of each of the bodies; those of a static model do not move."""
        if self.is_static:
            return [(*self.link_motion(body)[:2], _REST, _REST) for body in self.bodies]
        if self._at_parts:
            return self.engine.link_motions(self.body, [self._links[body] for body in self.bodies])
        return [self.link_motion(body) for body in self.bodies]

    @property
    def pose(self) -> Pose:
        """World pose of the root link's frame."""
        position, orientation = self.engine.base_pose(self.body)
        return Pose(position, orientation)

    def motion(self) -> Motion:
        """Pose of the model's frame, and the velocity of its root link's origin, as in Gazebo."""
        _, _, linear, angular = self.link_motion(self.description.root)
        return (*self.engine.base_pose(self.body), linear, angular)

    def set_state(
        self, pose: Pose, linear: Vector = (0, 0, 0), angular: Vector = (0, 0, 0)
    ) -> None:
        """Put the root link's frame at a world pose with a velocity (world axes).

        Raises:
            ModelError: a number is NaN, infinite or out of bounds.
        """
        if not pose.is_placeable():
            raise ModelError(
                f"pose for model '{self.name}' is {pose.position}, {pose.orientation}; {PLACEABLE}"
            )
        self._check_velocity(linear, angular)
        pose = pose.normalized()
        self.engine.set_base_pose(self.body, pose.position, pose.orientation)
        if not self.is_static:
            self.engine.set_velocity(self.body, linear, angular)
        self.placed = (pose, linear, angular)

    def set_link_state(self, link: str, pose: Pose, linear: Vector, angular: Vector) -> None:
        """Put one link to a world pose with a velocity of its center of mass (world axes), as
        Gazebo's Link::SetWorldPose: what joints connect with it stays where it is, and is pulled
        by them in the next steps. With Bullet a root link takes the model along.

        Raises:
            ModelError: no such link, a number is NaN, infinite or out of bounds, or with Bullet a
                link that is below a joint.
        """
        index, offset = self.link_in_body(link)
        if not pose.is_placeable():
            raise ModelError(
                f"pose for link '{link}' of '{self.name}' is {pose.position}, {pose.orientation}; "
                f"{PLACEABLE}"
            )
        self._check_velocity(linear, angular)
        frame = pose.normalized() * offset.inverse()
        place = frame.position, frame.orientation
        self.engine.place_link(self.body, index, *place, linear, angular)
        self._moved.add(index)

    def set_velocity(self, linear: Vector, angular: Vector = (0, 0, 0)) -> None:
        """Set the velocity for the next step [m/s, rad/s], world axes: see Engine.set_velocity.

        Raises:
            ModelError: a number is NaN, infinite or out of bounds.
        """
        self._check_velocity(linear, angular)
        if not self.is_static:
            self.engine.set_velocity(self.body, linear, angular)

    def _check_velocity(self, linear: Vector, angular: Vector) -> None:
        if not all(abs(value) <= MAX_VELOCITY for value in (*linear, *angular)):
            raise ModelError(
                f"velocity for model '{self.name}' is {tuple(linear)}, "
                f"{tuple(angular)}; must be finite and at most {MAX_VELOCITY:g} m/s "
                "or rad/s along each axis"
            )

    def state(self) -> BodyState:
        """BodyState for a snapshot."""
        engine = self.engine
        if not self.is_static:
            joints = engine.coordinates(self.body)
            return BodyState(self._key, *engine.base_pose(self.body), joints)
        if self._state is None or self._placements != engine.placements:
            self._placements = engine.placements
            self._state = BodyState(self._key, *engine.base_pose(self.body), ())
        return self._state

    def remove(self) -> None:
        """Remove it from the engine and delete its file."""
        self.engine.remove(self.body)
        if os.path.exists(self.source.path):
            os.remove(self.source.path)

"""A loaded model: its body in the engine, its links, whether its state is plausible."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any, Tuple

import numpy as np

from bullet_sim.controllers.limits import UNLIMITED_EFFORT, UNLIMITED_SPEED
from bullet_sim.controllers.manager import Manager
from bullet_sim.description.collisions import collision_names
from bullet_sim.description.lump import joint_inertias, lump
from bullet_sim.description.mirrors import mirrored_links, visual_links
from bullet_sim.description.model import WORLD_LINK, Link, ModelDescription
from bullet_sim.engine.api import Body, Engine
from bullet_sim.errors import ModelError
from bullet_sim.meshes.prepare import prepare_meshes
from bullet_sim.models.actor import ActorBody
from bullet_sim.models.joints import Joints, Mimics
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

FARTHEST = 2e3  # [m] from the origin
FASTEST = 200.0  # [m/s]
PERIOD = 0.25  # [s] of simulated time between two checks


def implausible_state(model: Model) -> str | None:
    """Describe what is implausible about a model's position and velocity, or None.

    Returns:
        A message that names the model.
    """
    position, _, linear, _ = model.body.link_motion(model.root)
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
Placed = Tuple[Pose, Vector, Vector]  # pose and velocities of set_state


class Model:
    """A loaded ModelDescription.

    Args:
        key: identifier in snapshots.
        pose: world Pose of the root link's frame.
        folder: where converted meshes are written.
        clock: function -> simulated time [s], for an actor.

    Attributes:
        body: in the engine.
        source: for mirrors of the world.
        root: name of its root link.
        measured: names of joints whose forces are measured.
        bodies: names of the links that Gazebo has: of a URDF those into which fixed joints merge
            others; in the place of `world` those that are fixed to it.

    Raises:
        ModelError: the engine refuses it.
    """

    def __init__(
        self,
        engine: Engine,
        key: int,
        description: ModelDescription,
        pose: Pose,
        folder: str,
        clock: Callable[[], float] = lambda: 0.0,
    ) -> None:
        self.name = description.name
        self.description = description
        self.initial_pose = pose
        self.engine = engine
        self._key = key
        self._state: BodyState | None = None  # of what is static ...
        self._placements = -1  # ... as of these of the engine
        self.times_moved = 0  # by set_state(), set_link_state() or a service's wrench
        self._changes: dict[tuple[str, str], Callable[[], None]] = {}
        # mass, center of mass and inertia of links as they were set last
        self.set_masses: dict[str, tuple[float, Array, Array]] = {}
        self._reported_frames: dict[str, Pose] = {}  # of parts, in their own frames
        motion = description.motion
        self._lumped = lumped = engine.lump(description) if motion is None else lump(description)
        self._actor = None if motion is None else ActorBody(lumped, motion, clock)
        self.root = lumped.root
        visuals = prepare_meshes(lumped, folder, description.warn)
        order = mirrored_links(lumped)
        self.source = BodySource(
            key,
            description.static or lumped.fixed_base,
            visual_links(lumped, order, visuals),
            tuple(tuple(lumped.links[n].visuals) if n in lumped.links else () for n in order),
        )
        self._load()
        self.bodies = self._bodies()
        self._carried = self._frame_on_link()
        self._at_parts = all(self.link_in_body(body)[1] == _SAME for body in self.bodies)
        self._at_root = self.link_in_body(description.root) == (self.root, _SAME)
        self.joints = Joints(self.body, lumped.joints)
        mimics = {joint.name: joint.mimic for joint in lumped.joints if joint.mimic}
        inertias = joint_inertias(lumped, description.fixed_base, mimics)
        self.mimics = Mimics(self.joints, mimics, inertias, self._fastest)
        self.manager = (
            None if description.control_namespace is None else Manager(self.joints, description)
        )
        if self.manager is not None:
            self.manager.hardware.restart()

    def _load(self) -> None:
        """Add it to the engine, where it starts."""
        self.placed: Placed | None = None  # what set_state has set since it was loaded
        self._moved: set[str] = set()  # links that set_link_state has placed since then
        lumped, description = self._lumped, self.description
        body: Body
        self.body = body = self._actor or self.engine.add(lumped, description, self.initial_pose)
        joints = (*lumped.joints, *lumped.welds)
        self.measured = {joint.name for joint in joints if joint.name in description.measured}
        for name in self.measured:
            body.motor(name).measure_load()
        for joint in lumped.welds:
            body.motor(joint.name).track_position(0.0, UNLIMITED_EFFORT, UNLIMITED_SPEED)
        for change in self._changes.values():
            change()
        self._start = body.joint_positions()

    def change(self, key: tuple[str, str], change: Callable[[], None]) -> None:
        """Apply a change to the body now and after every reload.

        Args:
            key: of the changed property; a later change of the same key replaces this one.
            change: function without arguments that changes self.body.
        """
        change()
        self._changes[key] = change

    def apply_wrench(self, part: str, force: Vector, torque: Vector) -> None:
        """Apply a force at the center of mass of one of the rigid_parts and a torque (world axes)
        for one step."""
        self.body.apply_force(part, force, self.body.link_center(part), torque)

    def reload(self) -> None:
        """Reload into a cleared engine, at the initial pose; controllers restart."""
        self._load()
        self.joints.rebind(self.body)
        self.mimics.restart()
        if self.manager is not None:
            self.manager.restart()

    def put_back(self, time: float, with_joints: bool = False, by: float = 0.0) -> None:
        """Put it to its initial pose, at rest.

        Args:
            by: how far simulated time went back [s], for the same.
            with_joints: its joints and loose links, too, are put to where they were when it was
                loaded.
            time: now [s], for its controllers: see Manager.forget_updates.
        """
        if with_joints and self._lumped.loose:
            self.body.gather()
        self.set_state(self.initial_pose)
        if not self.is_static:
            now = self.body.joint_positions()
            self.body.set_joint_positions(self._start if with_joints else now)
        if self.manager is not None:
            self.manager.forget_updates(time, by)

    def save_state(self) -> tuple[Placed | None, tuple[float, ...], dict[str, Motion]]:
        """The pose and velocity set by set_state since it was loaded (or None), the joints, and
        motions of links that were placed by themselves."""
        links = {part: self._center_motion(part) for part in sorted(self._moved)}
        return self.placed, self.body.joint_positions(), links

    def _center_motion(self, part: str) -> Motion:
        """Pose of a link's frame and the velocity of its center of mass."""
        position, orientation, linear, angular = self.body.link_motion(part)
        center = self.body.link_center(part)
        return position, orientation, velocity_at(center, position, linear, angular), angular

    def restore_state(
        self, state: tuple[Placed | None, tuple[float, ...], dict[str, Motion]]
    ) -> None:
        """Restore the result of save_state() after a reload; controllers restart."""
        placed, joints, links = state
        if placed is not None:
            self.set_state(*placed)
        if joints != self.body.joint_positions():
            self.body.set_joint_positions(joints)
            if self.manager is not None:
                self.manager.restart()
        for part, (position, orientation, linear, angular) in links.items():
            self.body.place_link(part, Pose(position, orientation), linear, angular)
            self._moved.add(part)

    @property
    def is_static(self) -> bool:
        """Whether it never moves."""
        return self.description.static

    def _bodies(self) -> tuple[str, ...]:
        described, joints = self.description, self.description.joints.values()
        if described.is_empty:
            return ()
        if not described.is_urdf:
            world = described.links.get(WORLD_LINK)  # of joints, where no link has that name
            is_none = world is not None and world.mass == 0.0
            return tuple(name for name in described.links if name != WORLD_LINK or not is_none)
        held: set[str] = {"world"} if described.fixed_base else set()
        remaining = self._lumped.links
        merged = {
            joint.child
            for joint in joints
            if joint.kind == "fixed" and joint.parent not in held and joint.child not in remaining
        }
        parts = [*remaining, *(described.links if self.is_static else ())]
        names: list[str] = []
        for part in parts:
            if part in held:
                names += [j.child for j in described.joints_of(part) if j.kind == "fixed"]
            elif part not in merged:
                names.append(part)
        return tuple(dict.fromkeys(names))

    def _fastest(self) -> float:
        """Speed up to which motors follow [rad/s, m/s]."""
        settings = self.engine.settings
        return math.inf if settings is None else settings.max_speed

    def _frame_on_link(self) -> tuple[str, Pose] | None:
        """Where joints move a model against the world: its first link, with which the model's frame
        goes as in Gazebo, and that frame in it; None: the frame goes with the root link."""
        if self.root != WORLD_LINK or self.is_static or self.engine.settings is None:
            return None
        link = next(iter(self.bodies), WORLD_LINK)
        return link, self.description.poses()[link].inverse()

    def stays(self, joint: str) -> bool:
        """Whether a joint is one in Gazebo: sdformat merges the links of a URDF's fixed ones."""
        return self.description.joints[joint].child in self.bodies

    def axes_of(self, joint: str) -> list[str]:
        """Names of the hinges that make up a joint of several axes; of others its own."""
        names = [joint]
        while f"{joint}__{len(names) + 1}" in self.joints.limits:
            name = f"{joint}__{len(names) + 1}"
            if self.joints.limits[name].parent != f"{joint}__link{len(names)}":
                break  # another joint of such a name
            names.append(name)
        return names

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints that Gazebo has, gearboxes last."""
        staying = list(filter(self.stays, self.description.joints))
        later = {name for joint in staying for name in self.axes_of(joint)[1:]}
        return [name for name in staying if name not in later] + list(self.description.gears)

    @property
    def rigid_parts(self) -> dict[str, Link]:
        """Links that remain when fixed joints are merged: Link by name."""
        return self._lumped.links

    def row(self, part: str) -> int:
        """Row of one of the rigid_parts in source.links."""
        return self.body.links.index(part)

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of all links of the original description."""
        return tuple(self.description.links)

    def link_in_body(self, link: str) -> tuple[str, Pose]:
        """The link of the body that a link is merged into: its name, Pose in it.

        Raises:
            ModelError: no such link.
        """
        if link not in self._lumped.frames:
            raise ModelError(
                f"model '{self.name}' has no link '{link}'; links are {', '.join(self.link_names)}"
            )
        return self._lumped.frames[link]

    def tell_center(self, link: str, center: Vector) -> None:
        """Have a link's frame be where another center of mass (3,) [m] puts it.

        As ODELink::MoveCallback of Gazebo 11, which takes Inertial::CoG() off the body's position:
        the body stays, and the link is reported, and placed, with another frame.
        """
        part, offset = self.link_in_body(link)
        if self.is_static or offset != _SAME:
            return
        x, y, z = (np.asarray(self.rigid_parts[part].center) - np.asarray(center)).tolist()
        self._reported_frames.pop(part, None)
        if (x, y, z) != _REST:
            self._reported_frames[part] = Pose((x, y, z))

    def _reported_in_body(self, link: str) -> tuple[str, Pose]:
        """As link_in_body(), of its frame as it is reported."""
        part, offset = self.link_in_body(link)
        return (
            (part, self._reported_frames[part] * offset)
            if part in self._reported_frames
            else (part, offset)
        )

    def _reported_from_frame(self) -> Pose:
        """Where the model's frame is reported to be, in its own."""
        reported = self._reported_frames.get(self.root)
        if reported is None:
            return _SAME
        position, orientation, _, _ = self.body.link_motion(self.root)
        root, frame = Pose(position, orientation), Pose(*self.body.pose())
        in_root = root.inverse() * frame
        return in_root.inverse() * reported * in_root

    @property
    def pose(self) -> Pose:
        """World pose of the model's frame, as it is reported."""
        if self._carried is not None:
            link, frame = self._carried
            return self.link_state(link)[0] * frame
        frame = Pose(*self.body.pose())
        return frame * self._reported_from_frame() if self._reported_frames else frame

    @cached_property
    def collision_names(self) -> dict[tuple[str, int], str]:
        """See description.collisions."""
        return collision_names(self.description)

    def link_state(self, link: str) -> tuple[Pose, Array, Array]:
        """Pose of a link's frame and its origin's velocity in the world.

        Returns:
            Pose, linear (3,) [m/s], angular (3,) [rad/s]; velocities along world axes.
        """
        part, offset = self._reported_in_body(link)
        position, orientation, linear, angular = self.body.link_motion(part)
        frame = Pose(position, orientation)
        if offset == _SAME:  # not merged into another link
            return frame, np.array(linear), np.array(angular)
        arm = frame.matrix @ np.asarray(offset.position)
        return frame * offset, linear + cross(angular, arm), np.array(angular)

    def link_motion(self, link: str) -> tuple[Vec3, Quat, Vec3, Vec3]:
        """As link_state, in four tuples: position, quaternion, linear and angular velocity."""
        part, offset = self._reported_in_body(link)
        place = None if offset == _SAME else (offset.position, offset.orientation)
        return self.body.link_motion(part, place)

    def recorded_motion(self, link: str) -> Any:
        """As link_motion() after each recorded step, see api.Body."""
        part, offset = self._reported_in_body(link)
        place = None if offset == _SAME else (offset.position, offset.orientation)
        return self.body.recorded_motion(part, place)

    def body_motions(self) -> list[Motion]:
        """As link_motion, of each of the bodies; those of a static model do not move."""
        if self.is_static:
            return [(*self.link_motion(body)[:2], _REST, _REST) for body in self.bodies]
        if self._at_parts and not self._reported_frames:
            return [self.body.link_motion(self._lumped.frames[body][0]) for body in self.bodies]
        return [self.link_motion(body) for body in self.bodies]

    def motion(self) -> Motion:
        """Pose of the model's frame, and the velocity of its root link's origin, as in Gazebo."""
        carrier = self.description.root if self._carried is None else self._carried[0]
        position, orientation, linear, angular = self.link_motion(carrier)
        if self.is_at_root:
            return position, orientation, linear, angular
        pose = self.pose
        return pose.position, pose.orientation, linear, angular

    @property
    def is_at_root(self) -> bool:
        """Whether motion() is that of the root link's frame in the engine."""
        return self._carried is None and not self._reported_frames and self._at_root

    def recorded_motions(self) -> list[Any] | None:
        """As motion() and body_motions(), after each recorded step; None: there are none."""
        links = [self.root, self.description.root, *self.bodies]
        found = (
            [] if self._reported_frames or self._carried else list(map(self.recorded_motion, links))
        )
        if not found or any(motion is None for motion in found):
            return None
        frame, root, *bodies = found
        if self.is_static:
            rest = np.zeros_like(frame[0])
            return [(*motion[:2], rest, rest) for motion in (frame, *bodies)]
        return [(*frame[:2], *root[2:]), *bodies]

    def set_state(
        self, pose: Pose, linear: Vector = (0, 0, 0), angular: Vector = (0, 0, 0)
    ) -> None:
        """Put the root link's frame at a world pose with a velocity (world axes).

        Joints that move the model against the world pull its links back, as in Gazebo.

        Raises:
            ModelError: a number is NaN, infinite or out of bounds.
        """
        if not pose.is_placeable():
            raise ModelError(
                f"pose for model '{self.name}' is {pose.position}, {pose.orientation}; {PLACEABLE}"
            )
        self._check_velocity(linear, angular)
        pose = pose.normalized()
        self.times_moved += 1
        if self._carried is not None:
            moved = pose * self.pose.inverse()
            parts = [part for part in self.rigid_parts if part != WORLD_LINK]
            for part, frame in [(part, Pose(*self.body.link_motion(part)[:2])) for part in parts]:
                self.body.place_link(part, moved * frame, linear, angular)
            self._moved.update(parts)
            return
        there = pose * self._reported_from_frame().inverse()
        self.body.set_pose(there.position, there.orientation)
        if not self.is_static:
            self.body.set_velocity(linear, angular)
        self.placed = (pose, linear, angular)

    def set_link_state(self, link: str, pose: Pose, linear: Vector, angular: Vector) -> None:
        """Put one link to a world pose with a velocity of its center of mass (world axes), as
        Gazebo's Link::SetWorldPose: what joints connect with it stays where it is, and is pulled
        by them in the next steps. With Bullet a root link takes the model along.

        Raises:
            ModelError: no such link, a number is NaN, infinite or out of bounds, or with Bullet a
                link that is below a joint.
        """
        part, offset = self._reported_in_body(link)
        if not pose.is_placeable():
            raise ModelError(
                f"pose for link '{link}' of '{self.name}' is {pose.position}, {pose.orientation}; "
                f"{PLACEABLE}"
            )
        self._check_velocity(linear, angular)
        self.body.place_link(part, pose.normalized() * offset.inverse(), linear, angular)
        self._moved.add(part)
        self.times_moved += 1

    def set_velocity(self, linear: Vector, angular: Vector = (0, 0, 0)) -> None:
        """Set the velocity for the next step [m/s, rad/s], world axes: see Body.set_velocity.

        Raises:
            ModelError: a number is NaN, infinite or out of bounds.
        """
        self._check_velocity(linear, angular)
        if not self.is_static:
            self.body.set_velocity(linear, angular)

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
            return BodyState(self._key, *self.body.pose(), self.body.coordinates())
        if self._state is None or self._placements != engine.placements:
            self._placements = engine.placements
            self._state = BodyState(self._key, *self.body.pose(), ())
        return self._state

    def remove(self) -> None:
        """Remove it from the engine."""
        if self._actor is None:
            self.engine.remove(self.body)

"""Actors: where they are at a time, and the bodies that they are."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from bullet_sim.description.actor import STANDING, ActorMotion, Trajectory
from bullet_sim.description.lump import LumpedModel
from bullet_sim.description.mirrors import mirrored_links
from bullet_sim.engine.api import Contact, ContactRows, Touch, contact_rows
from bullet_sim.pose import Array, Motion, Pose, Quat, Vec3, compose, multiply

FRAME = 0.05  # [s] between two updates, as in Gazebo
STRIDE = 1.4  # [m] of two steps
CYCLE = 1.1  # [s] of two steps where the distance does not count
_REST: Vec3 = (0.0, 0.0, 0.0)


class ActorPath:
    """Where an actor is and how its limbs are turned, at any time.

    Positions are on Gazebo's spline, whose tangents at waypoints are after Catmull and Rom;
    orientations are interpolated by squad, as there.
    """

    def __init__(self, motion: ActorMotion) -> None:
        self._motion = motion
        self._length = sum(each.duration for each in motion.trajectories)
        self._splines = [_Spline(each) if each.times else None for each in motion.trajectories]

    def at(self, time: float) -> tuple[Pose, dict[str, float]]:
        """Pose in the world, and angles of limbs [rad], at a time since it was loaded [s]."""
        motion = self._motion
        frame = FRAME * math.floor(time / FRAME + 1e-6)
        script = frame - motion.delay
        if script < 0.0 or not motion.starts or not motion.trajectories:
            return motion.pose, {}
        if script >= self._length:
            if motion.loop and self._length > 0.0:
                script %= self._length
            else:  # the last frame before
                script = max(0.0, FRAME * (math.ceil(self._length / FRAME - 1e-6) - 1))
        number = 0
        while number < len(self._splines) - 1 and script > motion.trajectories[number].duration:
            script -= motion.trajectories[number].duration
            number += 1
        trajectory, spline = motion.trajectories[number], self._splines[number]
        pose = motion.pose if spline is None else spline.pose(script)
        part = script / CYCLE
        if spline is not None and trajectory.animation in motion.by_distance:
            part = spline.way(script) / STRIDE
        return pose, limbs(trajectory.animation, 2.0 * math.pi * part)


def limbs(animation: str, phase: float) -> dict[str, float]:
    """Angles of the limbs [rad] of a person that walks; of one that stands they are 0."""
    if any(word in animation.lower() for word in STANDING):
        return {}
    wide = 1.6 if "run" in animation.lower() else 1.0
    angles = {}
    for side, shift in (("Left", 0.0), ("Right", math.pi)):
        swing = math.sin(phase + shift)
        angles[f"{side}UpLeg"] = -0.45 * wide * swing
        angles[f"{side}Leg"] = 0.5 * wide * max(0.0, math.cos(phase + shift)) + 0.05
        angles[f"{side}Arm"] = 0.35 * wide * swing
        angles[f"{side}ForeArm"] = -0.3 * wide
    return angles


class _Spline:
    """The waypoints of a Trajectory, joined."""

    def __init__(self, trajectory: Trajectory) -> None:
        self._times = trajectory.times
        self._points = np.array([pose.position for pose in trajectory.poses])
        self._turns = [pose.normalized().orientation for pose in trajectory.poses]
        self._tangents = _tangents(self._points) * (1.0 - trajectory.tension)
        self._inner = _inner(self._turns)
        count = int(math.ceil(trajectory.duration / FRAME)) + 1
        places = np.array([self._position(FRAME * k) for k in range(count)])
        steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
        self._way = np.concatenate([[0.0], np.cumsum(steps)])

    def _between(self, time: float) -> tuple[int, float]:
        """Number of the waypoint before a time, and the part of the way to the next."""
        times = self._times
        first = min(max(bisect_right(times, time) - 1, 0), len(times) - 1)
        if first == len(times) - 1:
            return first, 0.0
        return first, (time - times[first]) / (times[first + 1] - times[first])

    def _position(self, time: float) -> Array:
        first, t = self._between(time)
        if t <= 0.0:
            return self._points[first]
        one, two = self._points[first], self._points[first + 1]
        out, into = self._tangents[first], self._tangents[first + 1]
        t2, t3 = t * t, t * t * t
        found: Array = (
            (2 * t3 - 3 * t2 + 1) * one
            + (t3 - 2 * t2 + t) * out
            + (3 * t2 - 2 * t3) * two
            + (t3 - t2) * into
        )
        return found

    def pose(self, time: float) -> Pose:
        """Of a time since the first waypoint [s]."""
        first, t = self._between(time)
        x, y, z = self._position(time).tolist()
        if t <= 0.0:
            return Pose((x, y, z), self._turns[first])
        outer = slerp(self._turns[first], self._turns[first + 1], t, shortest=True)
        inner = slerp(self._inner[first], self._inner[first + 1], t)
        return Pose((x, y, z), slerp(outer, inner, 2.0 * t * (1.0 - t))).normalized()

    def way(self, time: float) -> float:
        """Distance since the first waypoint [m]."""
        return float(np.interp(time / FRAME, np.arange(len(self._way)), self._way))


def _tangents(points: Array) -> Array:
    """At points (n, 3): half of what is between both neighbors; a closed way has two of them at its
    end, too."""
    if len(points) < 2:
        return np.zeros_like(points)
    found = np.empty_like(points)
    found[1:-1] = 0.5 * (points[2:] - points[:-2])
    if np.array_equal(points[0], points[-1]):
        found[0] = found[-1] = 0.5 * (points[1] - points[-2])
    else:
        found[0], found[-1] = 0.5 * (points[1] - points[0]), 0.5 * (points[-1] - points[-2])
    return found


def _inner(turns: Sequence[Quat]) -> list[Quat]:
    """Quaternions between which squad turns to stay smooth at waypoints (Shoemake, 1987)."""
    found, last = [], len(turns) - 1
    is_closed = last > 0 and turns[0] == turns[-1]
    for i, turn in enumerate(turns):
        before = turns[last - 1 if is_closed else 0] if i == 0 else turns[i - 1]
        after = (
            turns[1 if is_closed else last] if i == last and last > 0 else turns[min(i + 1, last)]
        )
        inverse = (-turn[0], -turn[1], -turn[2], turn[3])
        parts = [_log(multiply(inverse, other)) for other in (after, before)]
        found.append(multiply(turn, _exp(-0.25 * (parts[0] + parts[1]))))
    return found


def _log(q: Quat) -> Array:
    """Half the rotation vector (3,) of a quaternion."""
    axis, w = np.array(q[:3]), max(-1.0, min(1.0, q[3]))
    sine = float(np.linalg.norm(axis))
    return axis * (math.atan2(sine, w) / sine) if sine > 1e-9 else axis


def _exp(half: Array) -> Quat:
    """Quaternion of half a rotation vector (3,)."""
    angle = float(np.linalg.norm(half))
    x, y, z = (half * (math.sin(angle) / angle if angle > 1e-9 else 1.0)).tolist()
    return x, y, z, math.cos(angle)


def slerp(one: Quat, two: Quat, part: float, shortest: bool = False) -> Quat:
    """Quaternion on the way from one to another, at constant speed."""
    a, b = np.array(one), np.array(two)
    cosine = float(a @ b)
    if shortest and cosine < 0.0:
        b, cosine = -b, -cosine
    if abs(cosine) > 1.0 - 1e-9:
        mixed = (1.0 - part) * a + part * b
    else:
        angle = math.acos(max(-1.0, min(1.0, cosine)))
        mixed = math.sin((1.0 - part) * angle) * a + math.sin(part * angle) * b
    x, y, z, w = (mixed / np.linalg.norm(mixed)).tolist()
    return x, y, z, w


class NoMotor:
    """Motor of an actor's joint: what it is told has no effect."""

    applied: float | None = None

    def _nothing(self, *_: Any) -> None:
        """Of what only joints have that something moves."""

    track_velocity = track_position = impose_velocity = impose_position = _nothing
    release = add_effort = set_position = set_limits = set_damping = measure_load = _nothing

    def set_parameter(self, name: str, value: float) -> bool:
        """See engine.api.Motor."""
        return False

    def load(self) -> tuple[Array, Array, float]:
        """See engine.api.Motor."""
        return np.zeros(3), np.zeros(3), 0.0


class ActorBody:
    """An actor as an engine.api.Body: nothing but time moves it, it touches nothing, and what it is
    told has no effect.

    Args:
        clock: function -> simulated time [s].
    """

    number, moves = -2, True

    def __init__(self, model: LumpedModel, motion: ActorMotion, clock: Callable[[], float]) -> None:
        self._path, self._clock = ActorPath(motion), clock
        self._since = clock()
        self._root, self.links = model.root, mirrored_links(model)
        self._joints = {joint.child: joint for joint in model.joints}
        self.joints = [joint.name for joint in model.joints]
        self._now = math.nan
        self._put: tuple[Pose, dict[str, float]] | None = None
        self._frames: dict[str, Pose] = {}
        self._angles: dict[str, float] = {}

    def walk_to(self, pose: Pose, way: float) -> None:
        """Have something else than its script move it.

        Args:
            pose: in the world.
            way: that its limbs have walked [m].
        """
        self._put = (pose, limbs("walking", 2.0 * math.pi * way / STRIDE))
        self._now = math.nan

    def _place(self) -> None:
        """Find all links' frames for the present time."""
        now = self._clock()
        if now == self._now:
            return
        self._now = now
        self._since = min(self._since, now)  # time was set back
        pose, self._angles = self._put or self._path.at(now - self._since)
        self._frames = {self._root: pose}
        for name in self.links[1:]:
            joint, angle = self._joints[name], self._angles.get(name, 0.0)
            turn = _exp(0.5 * angle * np.array(joint.axis))
            self._frames[name] = self._frames[joint.parent] * joint.origin * Pose(_REST, turn)

    # See engine.api.Body.
    def motor(self, joint: str) -> NoMotor:
        return NoMotor()

    def pose(self) -> tuple[Vec3, Quat]:
        return self.link_motion(self._root)[:2]

    def link_motion(self, link: str, offset: tuple[Vec3, Quat] | None = None) -> Motion:
        """Its velocity is 0, as Gazebo puts it from place to place."""
        self._place()
        pose = self._frames[link]
        position, orientation = pose.position, pose.orientation
        if offset is not None:
            position, orientation = compose(position, orientation, *offset)
        return position, orientation, _REST, _REST

    def recorded_motion(self, link: str, offset: tuple[Vec3, Quat] | None = None) -> None:
        """See api.Body: there is none."""

    def link_center(self, link: str) -> Vec3:
        return self.link_motion(link)[0]

    def joint_states(self) -> list[tuple[float, float, float]]:
        return [(angle, 0.0, 0.0) for angle in self.joint_positions()]

    def read_joints(self, states: Iterable[Any]) -> None:
        for state, angle in zip(states, self.joint_positions()):
            state.position, state.velocity = angle, 0.0

    def joint_positions(self) -> tuple[float, ...]:
        self._place()
        return tuple(self._angles.get(name, 0.0) for name in self._joints)

    def coordinates(self) -> tuple[float, ...]:
        self._place()
        return tuple(self._angles.get(name, 0.0) for name in self.links[1:])

    def contacts(self, link: str) -> list[Contact]:
        return []

    def records_contacts(self, link: str) -> bool:
        """See api.Body."""
        return False

    def contact_rows(self, link: str) -> ContactRows:
        return contact_rows([])

    def touching(self) -> list[Touch]:
        return []

    def _nothing(self, *_: Any) -> None:
        """Of what only bodies have that something moves."""

    is_held = False
    set_pose = set_velocity = hold_velocity = set_link_velocity = place_link = gather = (
        set_joint_positions
    ) = apply_force = _nothing
    set_mass = set_gravity = set_friction = set_slip = set_bitmask = _nothing

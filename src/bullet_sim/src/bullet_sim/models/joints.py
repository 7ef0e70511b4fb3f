"""A robot's movable joints: state as arrays, motors by joint name, mimic joints."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.component import Stateful
from bullet_sim.controllers import law
from bullet_sim.controllers.effort_row import EffortRow
from bullet_sim.controllers.handle import JointHandle
from bullet_sim.controllers.limits import JointLimits
from bullet_sim.controllers.pid import Pid, PidGains
from bullet_sim.description.model import Joint, Mimic
from bullet_sim.errors import ModelError
from bullet_sim.pose import Array

if TYPE_CHECKING:
    from bullet_sim.engine import Engine

MAX_POSITION = 1e9  # [rad, m] that set_positions takes


class Joints(Stateful):
    """Movable joints of one body: where commands are held within limits and given to the engine."""

    STATE = ("_applied",)
    CACHE = ("_body", "_handles", "_in_order")

    def __init__(self, engine: Engine, body: int, joints: Iterable[Joint]) -> None:
        self._engine, self._body = engine, body
        by_name = {joint.name: joint for joint in joints}
        self._engine_order = engine.joint_names(body)
        self._index = {name: i for i, name in enumerate(self._engine_order)}
        self.names = tuple(by_name)
        self.limits = by_name
        self._permutation = [self._index[name] for name in self.names]
        self._limits = {name: JointLimits(joint) for name, joint in by_name.items()}
        self._handles: Sequence[JointHandle] = ()  # of the last read()
        self._in_order: list[Any] = []  # the same, in the engine's order
        self._applied: dict[str, float] = {}

    def rebind(self, body: int) -> None:
        """Continue with a reloaded body."""
        self._body = body
        self._applied = {}

    def read(self, handles: Sequence[JointHandle]) -> None:
        """Read positions [rad, m] and velocities into handles, one a joint in names' order.

        The same sequence again is faster than an equal one.
        """
        if handles is not self._handles:
            self._handles = handles
            by_index: dict[int, Any] = dict(zip(self._permutation, handles))
            nobody = SimpleNamespace()  # for joints without a handle
            count = len(self._engine_order)
            self._in_order = [by_index.get(index, nobody) for index in range(count)]
        self._engine.read_joints(self._body, self._in_order)

    def arrays(self) -> tuple[Array, ...]:
        """Positions [rad, m], velocities, efforts [N m, N]: three (n,) arrays in names' order."""
        return tuple(map(np.array, self.columns(range(len(self.names)))))

    def columns(self, indices: Sequence[int]) -> tuple[list[float], list[float], list[float]]:
        """As arrays(), three lists of plain numbers, of some joints by their indices in names."""
        states = self._engine.joint_states(self._body)
        order = [self._permutation[index] for index in indices]
        efforts = [states[i][3] for i in order]
        for name, effort in self._applied.items():
            index = self.names.index(name)
            if index in indices:  # of the solver 'ode' as Joint::GetForce, without friction
                place = indices.index(index)
                motor = efforts[place] if self._engine.adds_motor_effort else 0.0
                efforts[place] = effort + motor
        return [states[i][0] for i in order], [states[i][1] for i in order], efforts

    def state(self) -> tuple[dict[str, float], dict[str, float]]:
        """Positions and velocities as two mappings from the joints' names."""
        states = self._engine.joint_states(self._body)
        positions, velocities = {}, {}
        for name, (position, velocity, _, _) in zip(self._engine_order, states):
            positions[name] = position
            velocities[name] = velocity
        return positions, velocities

    def positions_of(self, names: Iterable[str]) -> tuple[float, ...]:
        """Positions of some joints, as a tuple."""
        positions = self._engine.joint_positions(self._body)
        return tuple(positions[self._index[name]] for name in names)

    def velocities_of(self, names: Iterable[str]) -> tuple[float, ...]:
        """Velocities of some joints, as a tuple."""
        states = self._engine.joint_states(self._body)
        return tuple(states[self._index[name]][1] for name in names)

    def index(self, name: str) -> int:
        """Index of a joint in the engine.

        Raises:
            ModelError: no such movable joint.
        """
        if name not in self._index:
            raise ModelError(
                f"joint '{name}' does not exist or does not move; movable joints are "
                f"{', '.join(self.names) or '(none)'}"
            )
        return self._index[name]

    def set_positions(self, values: Mapping[str, float]) -> None:
        """Set joints to positions (mapping name -> [rad, m]), at rest; others are not changed.

        A position beyond a joint's limit is set to the limit.

        Raises:
            ModelError: no such movable joint, or a position that is NaN or out of bounds.
        """
        indices = {name: self.index(name) for name in values}
        for name, value in values.items():
            if not abs(value) <= MAX_POSITION:
                raise ModelError(
                    f"position of joint '{name}' is {value}, must be finite and at "
                    f"most {MAX_POSITION:g} rad or m"
                )
        for name, value in values.items():
            self._engine.put_joint(self._body, indices[name], self._limits[name].position(value))

    def clip_effort(self, name: str, effort: float) -> float:
        """The effort [N m, N], not above the joint's limit in the URDF.

        Raises:
            ModelError: no such movable joint.
        """
        self.index(name)
        return self._limits[name].effort(effort)

    def add_effort(self, name: str, effort: float) -> None:
        """Apply an effort [N m, N] for the next step, in addition to the joint's motor, as far as
        law.truncated() lets it."""
        index = self._index[name]
        rate = self._engine.joint_states(self._body)[index][1]
        effort = law.truncated(effort, rate, *self._limits[name].of_force())
        self._engine.drive_efforts(self._body, (index,), (effort,))

    def max_effort(self, name: str) -> float:
        """A joint's effort limit [N m, N], or UNLIMITED_EFFORT."""
        return self._limits[name].max_effort

    def drive_velocities(self, names: Iterable[str], values: Iterable[float]) -> None:
        """Track velocities, clipped to the URDF's velocity limits."""
        for name, value in zip(names, values):
            limits = self._limits[name]
            self._engine.drive_velocity(
                self._body, self._index[name], limits.velocity(value), limits.max_effort
            )

    def impose_velocities(self, names: Iterable[str], values: Iterable[float]) -> None:
        """Give velocities before each step, as Engine.impose_velocity; they are clipped, too."""
        for name, value in zip(names, values):
            limits = self._limits[name]
            self._engine.impose_velocity(
                self._body, self._index[name], limits.velocity(value), limits.max_effort
            )

    def impose_positions(self, names: Iterable[str], values: Iterable[float]) -> None:
        """Put joints to positions before each step, as Engine.impose_position; they are clipped."""
        for name, value in zip(names, values):
            limits = self._limits[name]
            value, effort, speed = limits.position(value), limits.max_effort, limits.max_speed
            self._engine.impose_position(self._body, self._index[name], value, effort, speed)

    def drive_positions(self, names: Iterable[str], values: Iterable[float]) -> None:
        """Track positions, clipped to the URDF's position limits."""
        for name, value in zip(names, values):
            limits = self._limits[name]
            value, effort, speed = limits.position(value), limits.max_effort, limits.max_speed
            self._engine.drive_position(self._body, self._index[name], value, effort, speed)

    def set_motor(self, name: str, velocity: float, effort: float) -> None:
        """Track a velocity [rad/s, m/s] with at most an effort [N m, N], whatever the joint's
        limits, as Gazebo's parameters vel and fmax of a joint."""
        self._applied.pop(name, None)
        self._engine.drive_velocity(self._body, self._index[name], velocity, effort)

    def apply_efforts(self, handles: Sequence[JointHandle]) -> None:
        """Apply the joints' efforts during the next step."""
        indices, efforts = [], []
        for handle in handles:
            name = handle.name
            self._applied[name], effort = handle.limited_effort()
            indices.append(self._index[name])
            efforts.append(effort)
        self._engine.drive_efforts(self._body, indices, efforts)

    def effort_rows(self, handles: Iterable[JointHandle]) -> list[EffortRow]:
        """What apply_efforts() would apply before each of several steps of a solver."""
        return [handle.effort_row(self._body, self._index[handle.name]) for handle in handles]

    def take_rows(self, handles: Iterable[JointHandle], rows: Iterable[EffortRow]) -> None:
        """A solver has made steps with effort_rows()."""
        for handle, row in zip(handles, rows):
            handle.take(row)
            self._applied[handle.name] = row.applied

    def release(self, names: Iterable[str]) -> None:
        """Release joints: they move freely, with their friction."""
        for name in names:
            self._applied.pop(name, None)
            self._engine.release(self._body, self._index[name])


_FRACTION = 0.5  # of the remaining error that one step takes away at most ...
_BRAKE = 0.5  # ... and of the effort that is counted on to brake in time


class Mimics(Stateful):
    """Drives the following joints of one model before each step.

    As the plugin, they follow and do not push back. Where the plugin puts the joint, here its motor
    moves it with at most its effort; where it has a PID, its effort does.

    Args:
        mimics: Mimics of the description by the name of the joint that follows.
        inertias: joint name -> inertia that its effort moves [kg m^2, kg].
    """

    STATE = ("_targets", "_pids")

    def __init__(
        self, joints: Joints, mimics: Mapping[str, Mimic], inertias: Mapping[str, float]
    ) -> None:
        self._joints = joints
        known = set(joints.names)
        self._targets: dict[str, float] = {}  # of the last step
        self._pids: dict[str, Pid] = {}  # of joints that have one
        self._following: list[tuple[str, Mimic, JointLimits, float, float]] = []
        for name, mimic in mimics.items():
            if name in known and mimic.joint in known:
                effort = joints.max_effort(name)
                effort = effort if mimic.max_effort is None else mimic.max_effort
                braking = _BRAKE * effort / inertias[name]
                limits = JointLimits(joints.limits[name])
                self._following.append((name, mimic, limits, effort, braking))

    def __bool__(self) -> bool:
        return bool(self._following)

    def restart(self) -> None:
        """Note that the model was loaded again."""
        self._targets = {}
        for pid in self._pids.values():
            pid.reset()

    def set_gains(self, name: str, gains: PidGains) -> None:
        """Have a joint follow by a PID from now on."""
        if name in self._pids:
            self._pids[name].gains = gains
        elif any(name == following for following, *_ in self._following):
            self._pids[name] = Pid(gains)
            self._joints.release((name,))

    def update(self, period: float) -> None:
        """Drive the joints for a step of this length [s]."""
        positions, _ = self._joints.state()
        for name, mimic, limits, effort, braking in self._following:
            if name in self._pids:
                error = positions[mimic.joint] * mimic.multiplier + mimic.offset - positions[name]
                if abs(error) >= mimic.sensitiveness:
                    pushed = self._pids[name].update(error, period)
                    self._joints.add_effort(name, max(-effort, min(effort, pushed)))
                continue
            target = limits.position(positions[mimic.joint] * mimic.multiplier + mimic.offset)
            # A joint that is put to its position moves without a velocity.
            followed = (target - self._targets.get(name, target)) / period
            self._targets[name] = target
            error, speed = target - positions[name], 0.0
            if abs(error) >= mimic.sensitiveness:
                close = min(_FRACTION * abs(error) / period, math.sqrt(2.0 * braking * abs(error)))
                speed = followed + math.copysign(close, error)
            self._joints.set_motor(name, limits.velocity(speed), effort)

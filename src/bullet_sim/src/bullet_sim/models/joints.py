"""A robot's movable joints: state as arrays, motors by joint name, mimic joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from bullet_sim.component import Stateful
from bullet_sim.controllers.handle import JointHandle
from bullet_sim.controllers.limits import JointLimits
from bullet_sim.controllers.pid import Pid, PidGains
from bullet_sim.description.model import Joint, Mimic
from bullet_sim.engine.api import Body, Motor
from bullet_sim.engine.efforts import EffortRow
from bullet_sim.engine.quickstep import law
from bullet_sim.errors import ModelError
from bullet_sim.pose import Array

MAX_POSITION = 1e9  # [rad, m] that set_positions takes


class Joints:
    """Movable joints of one body: where commands are held within limits and given to motors."""

    def __init__(self, body: Body, joints: Iterable[Joint]) -> None:
        self.limits = {joint.name: joint for joint in joints}
        self.names = tuple(self.limits)
        self._limits = {name: JointLimits(joint) for name, joint in self.limits.items()}
        self.rebind(body)

    def rebind(self, body: Body) -> None:
        """Continue with a reloaded body."""
        self._body = body
        self._motors = {name: body.motor(name) for name in self.names}

    def read(self, handles: Sequence[JointHandle]) -> None:
        """Read positions [rad, m] and velocities into handles, one a joint in names' order."""
        self._body.read_joints(handles)

    def arrays(self) -> tuple[Array, ...]:
        """Positions [rad, m], velocities, efforts [N m, N]: three (n,) arrays in names' order."""
        return tuple(map(np.array, self.columns(range(len(self.names)))))

    def columns(self, indices: Sequence[int]) -> tuple[list[float], list[float], list[float]]:
        """As arrays(), three lists of plain numbers, of some joints by their indices in names."""
        states = self._body.joint_states()
        chosen = [states[index] for index in indices]
        return tuple([state[column] for state in chosen] for column in range(3))  # type: ignore

    def state(self) -> tuple[dict[str, float], dict[str, float]]:
        """Positions and velocities as two mappings from the joints' names."""
        states = self._body.joint_states()
        positions = {name: state[0] for name, state in zip(self.names, states)}
        return positions, {name: state[1] for name, state in zip(self.names, states)}

    def positions_of(self, names: Iterable[str]) -> tuple[float, ...]:
        """Positions of some joints, as a tuple."""
        positions, _ = self.state()
        return tuple(positions[name] for name in names)

    def velocities_of(self, names: Iterable[str]) -> tuple[float, ...]:
        """Velocities of some joints, as a tuple."""
        _, velocities = self.state()
        return tuple(velocities[name] for name in names)

    def motor(self, name: str) -> Motor:
        """Motor of a joint.

        Raises:
            ModelError: no such movable joint.
        """
        if name not in self._motors:
            raise ModelError(
                f"joint '{name}' does not exist or does not move; movable joints are "
                f"{', '.join(self.names) or '(none)'}"
            )
        return self._motors[name]

    def set_positions(self, values: Mapping[str, float]) -> None:
        """Set joints to positions (mapping name -> [rad, m]), at rest; others are not changed.

        A position beyond a joint's limit is set to the limit.

        Raises:
            ModelError: no such movable joint, or a position that is NaN or out of bounds.
        """
        motors = {name: self.motor(name) for name in values}
        for name, value in values.items():
            if not abs(value) <= MAX_POSITION:
                raise ModelError(
                    f"position of joint '{name}' is {value}, must be finite and at "
                    f"most {MAX_POSITION:g} rad or m"
                )
        for name, motor in motors.items():
            motor.set_position(self._limits[name].position(values[name]))

    def add_effort(self, name: str, effort: float) -> None:
        """Apply an effort [N m, N] for the next step, in addition to the joint's motor, as far as
        law.truncated() lets it."""
        rate = self._body.joint_states()[self.names.index(name)][1]
        effort = law.truncated(effort, rate, *self._limits[name].of_force())
        self._motors[name].add_effort(effort)

    def max_effort(self, name: str) -> float:
        """A joint's effort limit [N m, N], or UNLIMITED_EFFORT."""
        return self._limits[name].max_effort

    def impose_velocities(self, names: Iterable[str], values: Iterable[float]) -> None:
        """Give velocities before each step, see Motor.impose_velocity; they are clipped, too."""
        for name, value in zip(names, values):
            limits = self._limits[name]
            self._motors[name].impose_velocity(limits.velocity(value), limits.max_effort)

    def impose_positions(self, names: Iterable[str], values: Iterable[float]) -> None:
        """Put joints to positions before each step, see Motor.impose_position; they are clipped."""
        for name, value in zip(names, values):
            self._motors[name].impose_position(*self._limits[name].position_command(value))

    def set_motor(self, name: str, velocity: float, effort: float) -> None:
        """Track a velocity [rad/s, m/s] with at most an effort [N m, N], whatever the joint's
        limits, as Gazebo's parameters vel and fmax of a joint."""
        self._motors[name].track_velocity(velocity, effort)

    def apply_efforts(
        self, handles: Sequence[JointHandle], computes: bool = False
    ) -> list[EffortRow]:
        """Rows of what acts on joints during the next steps.

        Args:
            computes: PIDs are computed anew before each step.
        """
        return [handle.effort_row(computes) for handle in handles]

    def release(self, names: Iterable[str]) -> None:
        """Release joints: they move freely, with their friction."""
        for name in names:
            self._motors[name].release()


_FRACTION = 0.5  # of the remaining error that one step takes away at most ...
_BRAKE = 0.5  # ... and of the effort that is counted on to brake in time


class Mimics(Stateful):
    """Drives the following joints of one model before each step.

    As the plugin, they follow and do not push back. Where the plugin puts the joint, here its motor
    moves it with at most its effort; where it has a PID, its effort does.

    Args:
        mimics: Mimics of the description by the name of the joint that follows.
        inertias: joint name -> inertia that its effort moves [kg m^2, kg].
        fastest: function -> speed up to which a motor follows [rad/s, m/s].
    """

    STATE = ("_targets", "_pids")
    CACHE = ("_fastest",)

    def __init__(
        self,
        joints: Joints,
        mimics: Mapping[str, Mimic],
        inertias: Mapping[str, float],
        fastest: Callable[[], float] = lambda: math.inf,
    ) -> None:
        self._joints, self._fastest = joints, fastest
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
        (positions, _), fastest = self._joints.state(), self._fastest()
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
            speed = min(max(limits.velocity(speed), -fastest), fastest)
            self._joints.set_motor(name, speed, effort)

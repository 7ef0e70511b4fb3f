"""Limits of a joint: the one place where what is commanded is held within them.

What controllers command is bounded by CommandLimits, as joint_limits_interface's (ros_control,
noetic); what plugins and services ask for by JointLimits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, isnan, nan
from typing import Any

from bullet_sim.component import Stateful
from bullet_sim.description.model import Joint, SoftLimits

UNLIMITED_EFFORT = 1e6  # [N m, N] where the URDF gives no limit
UNLIMITED_SPEED = 1e4  # [rad/s, m/s]


class JointLimits:
    """What the limits of a joint make of what plugins and services ask for.

    Args:
        joint: of the description; its limits may change.
    """

    def __init__(self, joint: Joint) -> None:
        self._joint = joint

    @property
    def max_effort(self) -> float:
        """[N m, N], or UNLIMITED_EFFORT."""
        return self._joint.effort or UNLIMITED_EFFORT

    @property
    def max_speed(self) -> float:
        """[rad/s, m/s], or UNLIMITED_SPEED."""
        return self._joint.velocity or UNLIMITED_SPEED

    def velocity(self, value: float) -> float:
        """A velocity [rad/s, m/s] within the limits."""
        limit = self._joint.velocity or UNLIMITED_SPEED
        return min(max(value, -limit), limit)

    def position(self, value: float) -> float:
        """A position [rad, m] within the limits."""
        lower, upper = self._joint.lower, self._joint.upper
        if lower is None or upper is None:
            return value
        return min(max(value, lower), upper)

    def position_command(self, value: float) -> tuple[float, float, float]:
        """A position [rad, m] within the limits, and the effort [N m, N] and speed to reach it."""
        return self.position(value), self.max_effort, self.max_speed

    def of_force(self) -> tuple[float, float]:
        """Speed and effort of law.truncated(); 0: none, as continuous joints have in Gazebo, since
        sdformat leaves their limits out when it converts a URDF."""
        joint = self._joint
        return (
            (0.0, 0.0)
            if joint.kind == "continuous"
            else (joint.velocity or 0.0, joint.effort or 0.0)
        )


def saturate(value: float, low: float, high: float) -> float:
    """A value within bounds; where they cross, the upper one."""
    return min(max(value, low), high)


@dataclass(frozen=True)
class CommandLimits:
    """What bounds the commands of a joint.

    Attributes:
        lower, upper: of its position [rad, m]; infinite: none.
        speed, acceleration, effort: [rad/s, m/s], [rad/s^2, m/s^2], [N m, N]; None: none.
        soft: soft limits of its position.
        is_given: a file or a parameter has limits; False: nothing bounds anything.
    """

    lower: float = -inf
    upper: float = inf
    speed: float | None = None
    acceleration: float | None = None
    effort: float | None = None
    soft: SoftLimits | None = None
    is_given: bool = False

    @property
    def max_effort(self) -> float:
        """[N m, N], or UNLIMITED_EFFORT."""
        return UNLIMITED_EFFORT if self.effort is None else min(self.effort, UNLIMITED_EFFORT)

    @property
    def max_speed(self) -> float:
        """[rad/s, m/s], or UNLIMITED_SPEED."""
        return UNLIMITED_SPEED if self.speed is None else min(self.speed, UNLIMITED_SPEED)

    def effort_bounds(self) -> tuple[float, ...]:
        """Arguments of law.effort_bounds() behind the joint's state, for a controller's effort."""
        soft = self.soft or SoftLimits(nan, nan, nan, nan)
        within = self.max_effort, self.lower, self.upper, self.max_speed
        return (*within, soft.lower, soft.upper, soft.k_position, soft.k_velocity)

    def refusal(self, joint: str, interface: str) -> str:
        """Why joint_limits_interface makes no handle of them, in its words, or "".

        Args:
            interface: that the joint has: velocity, position or effort.
        """
        if not self.is_given:
            return ""
        needs_speed = (self.soft is None) == (interface == "velocity") or interface == "effort"
        for kind, value, is_needed in (
            ("velocity", self.speed, needs_speed),
            ("efforts", self.effort, interface == "effort"),
        ):
            if is_needed and value is None:
                return (
                    f"Cannot enforce limits for joint '{joint}'. It has no {kind} limits "
                    "specification."
                )
        return ""


def command_limits(joint: Joint, parameters: Mapping[str, Any] | None = None) -> CommandLimits:
    """What bounds the commands of a joint.

    Args:
        parameters: that override its <limit>: has_position_limits with min_position and
            max_position, has_velocity_limits with max_velocity, and so of acceleration and effort,
            as joint_limits_rosparam.h takes them; None: there are none.
    """
    limits = _described(joint)
    if parameters is not None:
        changes: dict[str, Any] = {}
        for kind, names, fields in _PARAMETERS:
            has, values = parameters.get(f"has_{kind}_limits"), [parameters.get(n) for n in names]
            if has is False:
                changes.update((name, getattr(_NONE, name)) for name in fields)
            elif has is True and all(type(value) in (int, float) for value in values):
                changes.update(zip(fields, values))
        limits = replace(limits, is_given=True, **changes)
    return replace(limits, soft=joint.safety) if limits.is_given else limits


def _described(joint: Joint) -> CommandLimits:
    """Hard limits of a joint by its description."""
    limits = CommandLimits()
    if joint.limit is not None:
        limits = CommandLimits(effort=joint.limit[0], speed=joint.limit[1])
    elif joint.effort or joint.velocity or joint.lower is not None:
        limits = CommandLimits(effort=joint.effort or inf, speed=joint.velocity or inf)
    else:
        return limits
    if joint.kind != "continuous" and joint.lower is not None and joint.upper is not None:
        limits = replace(limits, lower=joint.lower, upper=joint.upper)
    return replace(limits, is_given=True)


_NONE = CommandLimits()
_PARAMETERS = (  # kind, parameters, fields of CommandLimits
    ("position", ("min_position", "max_position"), ("lower", "upper")),
    ("velocity", ("max_velocity",), ("speed",)),
    ("acceleration", ("max_acceleration",), ("acceleration",)),
    ("effort", ("max_effort",), ("effort",)),
)


class Limiter(Stateful):
    """Holds the velocities or positions that are commanded within limits, step by step.

    What it does is that of the handles of joint_limits_interface.h: Position- and
    VelocityJointSaturationHandle, and the same with soft limits.

    Attributes:
        gradual: (goal, whether a PID follows it and not the joint's motor, which keeps to the speed
            by itself) -> whether a command is held within the limits step by step, by step().
        bounds: goal -> (least, largest) of commands that are not gradual.
    """

    STATE = ("_last",)

    def __init__(self, limits: CommandLimits) -> None:
        self.limits, is_soft = limits, limits.soft is not None
        ramps = is_soft or limits.acceleration is not None
        self.gradual = {
            ("velocity", False): ramps,
            ("velocity", True): ramps,
            ("position", False): is_soft,
            ("position", True): is_soft or limits.speed is not None,
        }
        self.bounds = {
            "velocity": (-limits.max_speed, limits.max_speed),
            "position": (limits.lower, limits.upper),
        }
        self.reset()

    def reset(self) -> None:
        """Forget the last command."""
        self._last = nan  # within the limits

    def held(self, value: float) -> float:
        """What the last step has made of a command; the command before the first."""
        return value if isnan(self._last) else self._last

    def step(
        self, goal: str, value: float, position: float, velocity: float, period: float
    ) -> tuple[float, bool]:
        """A gradual command within the limits.

        Args:
            goal: "velocity" or "position".
            value: the command.
            position, velocity: of the joint [rad, m], [rad/s, m/s].
            period: a step [s].

        Returns:
            The command within the limits, whether it stays so in the next steps.
        """
        limits, last = self.limits, self._last
        if goal == "position":
            last = position if isnan(last) else last
            low, high = self._position_bounds(last, period)
        else:
            last = 0.0 if isnan(last) else last
            low, high = self._velocity_bounds(last, position, velocity, period)
        self._last = saturate(value, low, high)
        depends = goal == "velocity" and limits.soft is not None
        return self._last, self._last == last and not depends

    def _position_bounds(self, last: float, period: float) -> tuple[float, float]:
        limits, speed = self.limits, self.limits.max_speed
        slow, fast = self._soft_bounds(last)
        if limits.speed is None:
            return limits.lower, limits.upper
        slow, fast = saturate(slow, -speed, speed), saturate(fast, -speed, speed)
        return max(last + slow * period, limits.lower), min(last + fast * period, limits.upper)

    def _velocity_bounds(
        self, last: float, position: float, velocity: float, period: float
    ) -> tuple[float, float]:
        limits, speed = self.limits, self.limits.max_speed
        low, high = (saturate(v, -speed, speed) for v in self._soft_bounds(position))
        if limits.acceleration is not None:
            change = limits.acceleration * period
            start = last if limits.soft is None else velocity
            low, high = max(start - change, low), min(start + change, high)
        return low, high

    def _soft_bounds(self, position: float) -> tuple[float, float]:
        """Velocities [rad/s, m/s] that the soft limits let a joint have at a position."""
        limits, soft = self.limits, self.limits.soft
        if soft is None or limits.lower == -inf and limits.upper == inf:
            return -inf, inf
        return -soft.k_position * (position - soft.lower), -soft.k_position * (
            position - soft.upper
        )

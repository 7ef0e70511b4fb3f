"""Limits of a joint: the one place where what is commanded is held within them."""

from __future__ import annotations

from math import inf

from bullet_sim.description.model import Joint

UNLIMITED_EFFORT = 1e6  # [N m, N] where the URDF gives no limit
UNLIMITED_SPEED = 1e4  # [rad/s, m/s]


class JointLimits:
    """What the limits of a joint make of commands.

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

    def set_point(self, goal: str, value: float) -> float:
        """The set point of a PID; that of a position is limited by law.position_error().

        Args:
            goal: "velocity" or "position".
        """
        limit = self._joint.velocity
        return min(max(value, -limit), limit) if goal == "velocity" and limit else value

    def effort(self, value: float) -> float:
        """An effort [N m, N] that is not a controller's, at most the limit."""
        limit = self._joint.effort or UNLIMITED_EFFORT
        return min(max(value, -limit), limit)

    def effort_bounds(self, is_regulated: bool = False) -> tuple[float, float, float, float]:
        """Limit, lower, upper, speed of law.effort_bounds(), for a controller's effort.

        Args:
            is_regulated: the effort follows a velocity or a position by gains of
                gazebo_ros_control, which bounds it by the joint's effort alone.
        """
        joint = self._joint
        if is_regulated:
            return joint.effort or inf, -inf, inf, inf
        limit, speed = joint.effort or UNLIMITED_EFFORT, joint.velocity or UNLIMITED_SPEED
        if joint.lower is None or joint.upper is None:
            return limit, -inf, inf, speed
        return limit, joint.lower, joint.upper, speed

    def of_force(self) -> tuple[float, float]:
        """Speed and effort of law.truncated(); 0: none, as continuous joints have in Gazebo, since
        sdformat leaves their limits out when it converts a URDF."""
        joint = self._joint
        return (
            (0.0, 0.0)
            if joint.kind == "continuous"
            else (joint.velocity or 0.0, joint.effort or 0.0)
        )

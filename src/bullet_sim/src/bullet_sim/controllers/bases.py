"""Arithmetic of bases' plugins: ways on arcs, a tricycle's motors, odometry by two encoders."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bullet_sim.component import Stateful

if TYPE_CHECKING:
    from bullet_sim.plugins.bases import TricycleSpec

STRAIGHT = 1e-4  # [rad/s] yaw rate, and [m] way, below which there is none
RIGHT_ANGLE = math.pi / 2.0
Pose2d = tuple  # x, y [m], yaw [rad]


def after_arc(pose: Pose2d, x: float, y: float, yaw_rate: float, seconds: float) -> Pose2d:
    """A pose (x, y [m], yaw [rad]) after some time with a velocity [m/s, rad/s] along its own axes.

    The base moves on a circle, as hector's force_based_move adds it up.
    """
    along, across, turned = x * seconds, y * seconds, 0.0
    if abs(yaw_rate) >= STRAIGHT:
        turned = yaw_rate * seconds
        if abs(along) < STRAIGHT and abs(across) < STRAIGHT:
            along = across = 0.0
        else:
            radius = math.hypot(along, across) / turned
            direction = math.atan2(across, along)
            ahead, aside = math.sin(turned) * radius, radius - math.cos(turned) * radius
            along = math.cos(direction) * ahead - math.sin(direction) * aside
            across = math.sin(direction) * ahead + math.cos(direction) * aside
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return pose[0] + c * along - s * across, pose[1] + s * along + c * across, pose[2] + turned


class TricycleMotion(Stateful):
    """Odometry of a tricycle by its encoders, and what its motors are told."""

    STATE = ("pose", "twist", "_before")

    def __init__(self, spec: TricycleSpec) -> None:
        self._spec = spec
        self.restart()

    def restart(self) -> None:
        """Odometry at zero."""
        self.pose: Pose2d = (0.0, 0.0, 0.0)
        self.twist = (0.0, 0.0, 0.0)  # x, y [m/s] along the odometry's axes, yaw rate [rad/s]
        self._before: float | None = None

    def measure(self, time: float, left: float, right: float) -> None:
        """Add the way since the last call, with the speeds [rad/s] of both wheels now.

        As upstream it turns to the left where the left wheel is faster.
        """
        before, self._before = self._before, time
        elapsed = time - (0.0 if before is None else before)
        if elapsed <= 0.0:
            return
        radius, base = self._spec.encoder_diameter / 2.0, self._spec.separation
        by_left, by_right = left * radius * elapsed, right * radius * elapsed
        turned, way = (by_left - by_right) / base, (by_left + by_right) / 2.0
        x, y, yaw = self.pose
        dx = way * math.cos(yaw + turned / 2.0)
        dy = way * math.sin(yaw + turned / 2.0)
        self.pose = (x + dx, y + dy, yaw + turned)
        self.twist = (dx / elapsed, dy / elapsed, turned / elapsed)

    def wheel_speed(self, target: float, speed: float, elapsed: float) -> float:
        """Speed [rad/s] for the motor of the driven wheel.

        Args:
            target, speed: commanded and present [rad/s].
            elapsed: since the last call [s].
        """
        spec = self._spec
        if spec.acceleration <= 0.0:
            return target
        lead = speed - target
        if abs(lead) < spec.speed_tolerance:
            return speed
        if abs(lead) > spec.acceleration * elapsed:
            if lead > 0.0:
                return speed - spec.acceleration * elapsed
            return speed + spec.deceleration * elapsed
        return target

    def steering_speed(self, target: float, angle: float, speed: float) -> float:
        """Speed [rad/s] for the motor of the steering.

        As upstream the direction comes of a comparison with the wheel's speed, not with zero.

        Args:
            target, angle: commanded and present [rad].
            speed: commanded of the driven wheel [rad/s].
        """
        lead = angle - min(max(target, -RIGHT_ANGLE), RIGHT_ANGLE)
        if abs(lead) < self._spec.angle_tolerance:
            return 0.0
        return self._spec.steering_speed if lead < speed else -self._spec.steering_speed

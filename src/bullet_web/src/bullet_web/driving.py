"""Who drives, and what a page's command is on a topic. No ROS.

A page's command is (speed, steering), both -1 to 1; steering to the right is positive.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

TIMEOUT = 0.5  # [s] wall time without a command after which the driver's hands count as gone


@dataclass(frozen=True)
class Drive:
    """How a topic of type geometry_msgs/Twist is commanded.

    Attributes:
        topic: its name.
        speed: linear.x at a speed of 1.
        unit: of the speed, for people.
        steering: at a steering of 1: angular.z; with `curvature` the curvature [1/m].
        sign: 1: positive angular.z turns right (the original's control), -1: left (REP-103).
        curvature: angular.z is speed times curvature, so that a car steers in reverse as it does
            forwards, and stands with straight wheels.
    """

    topic: str
    speed: float = 1.0
    unit: str = "m/s"
    steering: float = 1.5
    sign: int = -1
    curvature: bool = False

    def twist(self, speed: float, steering: float) -> tuple[float, float]:
        """linear.x and angular.z of a page's command."""
        linear = self.speed * speed
        angular = self.sign * self.steering * steering * (linear if self.curvature else 1.0)
        return linear, angular + 0.0  # no -0.0

    def described(self) -> dict[str, Any]:
        """For the page."""
        return {"topic": self.topic, "speed": self.speed, "unit": self.unit}


CAR_SPEED = 1.5  # [m/s] of a car that tells no limit
WHEEL_SPEED = 50.0  # [rad/s] 1.5 m/s on wheels of 30 mm
ORIGINAL_STEERING = 4.0  # units of 15 degrees: 60 degrees, control's limit
SAFE_CURVATURE = 1.0  # [1/m] that a trailer follows


def drive_of(topic: str, parameters: Mapping[str, Any]) -> Drive:
    """The Drive of a topic.

    Args:
        parameters: private parameters of the node that subscribes to it. Control of the car and
            drive node of the truck tell their geometry there; any other is a base that takes m/s
            and rad/s.
    """
    if parameters.get("mode") == "original":
        return Drive(topic, WHEEL_SPEED, "rad/s", ORIGINAL_STEERING, 1)
    names = ("wheelbase", "max_steering", "max_speed")
    values = [parameters.get(name, CAR_SPEED if name == "max_speed" else None) for name in names]
    if not all(isinstance(value, (int, float)) and 0 < value < math.inf for value in values):
        return Drive(topic)
    wheelbase, largest, speed = map(float, values)  # type: ignore[arg-type]
    curvature = math.tan(min(largest, 1.2)) / wheelbase
    if "max_steering_rate" in parameters:  # the truck
        curvature = min(curvature, SAFE_CURVATURE)
    return Drive(topic, speed, "m/s", curvature, -1, curvature=True)


class Seat:
    """The driver's seat: one page at a time; what moves ends with one zero.

    Args:
        publish: called with (speed, steering) of a page's command.
        now: wall time [s].

    Attributes:
        driver: number of the page that drives, or None.
    """

    def __init__(
        self,
        publish: Callable[[float, float], object],
        now: Callable[[], float] = time.monotonic,
        timeout: float = TIMEOUT,
    ) -> None:
        self.driver: int | None = None
        self._publish, self._now, self._timeout = publish, now, timeout
        self._moving = False  # the last command was not zero
        self._last = 0.0

    def take(self, page: int) -> None:
        """A page takes the seat; what another one has commanded ends."""
        if page != self.driver:
            self.stop()
            self.driver = page

    def release(self, page: int) -> None:
        """A page leaves the seat, or has gone."""
        if page == self.driver:
            self.stop()
            self.driver = None

    def command(self, page: int, speed: float, steering: float) -> bool:
        """Drive; a page takes an empty seat by that.

        Returns:
            Whether the command counts: the page has the seat.
        """
        if self.driver is None and (speed or steering):
            self.driver = page
        if page != self.driver:
            return False
        self._last = self._now()
        if speed or steering:
            self._moving = True
            self._publish(speed, steering)
        else:
            self.stop()
        return True

    def stop(self) -> None:
        """Publish one zero, if the last command was none."""
        if self._moving:
            self._moving = False
            self._publish(0.0, 0.0)

    def check(self) -> bool:
        """Stop when the driver's commands have ceased.

        Returns:
            Whether that was so.
        """
        late = self._moving and self._now() - self._last > self._timeout
        if late:
            self.stop()
        return late

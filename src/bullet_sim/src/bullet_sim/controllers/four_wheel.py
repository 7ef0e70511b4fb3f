"""four_wheel_steering_controller: settings, geometry, commands and odometry.

Geometry of a base whose four wheels are all driven and steered. The wheels stand at the corners of
a rectangle, each `offset` outside its steering axis. All turn about one center, so an axle's
virtual middle wheel at the angle d with the speed v along it moves as the body does: turn rate w =
v cos(d) (tan(front) - tan(rear)) / wheel_base.
"""

from __future__ import annotations

import collections
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Tuple

from bullet_sim.component import Stateful
from bullet_sim.controllers.base import CONTROLLERS
from bullet_sim.controllers.drive import MAX_ARC, MIN_PERIOD, Drive
from bullet_sim.controllers.drive_settings import (
    BaseConfig,
    common,
    joint_position,
    size,
    wheel_names,
    wheel_radius,
)
from bullet_sim.controllers.hardware import Hardware
from bullet_sim.controllers.settings import REQUIRED, Settings
from bullet_sim.description.model import ModelDescription
from bullet_sim.errors import ControllerError
from bullet_sim.pose import Vec3

Outputs = Tuple[Tuple[float, ...], Tuple[float, ...]]  # speeds [rad/s], steering angles [rad]

_KEYS = ("front_wheel", "rear_wheel", "front_steering", "rear_steering")


@dataclass(frozen=True)
class FourWheelConfig(BaseConfig):
    """A base with four driven wheels, each on a steering joint of its own.

    Attributes:
        wheels, steers: joints: front left, front right, rear left, rear right.
        track: between the steering axes of an axle [m].
        offset: from a steering axis out to its wheel [m].
        radius: of the wheels [m].
        wheel_base: between the axles [m].
    """

    wheels: tuple[str, ...] = REQUIRED
    steers: tuple[str, ...] = REQUIRED
    track: float = REQUIRED
    offset: float = REQUIRED
    radius: float = REQUIRED
    wheel_base: float = REQUIRED


def _apart(description: ModelDescription | None, first: str, second: str) -> float:
    """Distance of two joints seen from above [m]."""
    a, b = joint_position(description, first), joint_position(description, second)
    return math.hypot(a[0] - b[0], a[1] - b[1])


STOPPED = 1e-3  # [m/s] commands of less stand still
PARALLEL = 1e-2  # difference of the tangents of an axle's wheels below which they are parallel


def for_twist(config: FourWheelConfig, forward: float, turn: float) -> Outputs:
    """Wheels for a velocity of the body, both axles steering against each other.

    Args:
        forward: [m/s].
        turn: to the left [rad/s].

    Returns:
        Speeds [rad/s] and steering angles [rad] of the wheels, each front left, front right, rear
        left, rear right.
    """
    across = turn * config.track / 2.0
    speeds, angles = [0.0, 0.0], [0.0, 0.0]
    if abs(forward) > STOPPED:
        speeds = _rims(config, forward, turn, config.wheel_base * turn / 2.0)
        angles = [math.copysign(math.pi / 2.0, turn)] * 2
    if abs(forward) > abs(across):
        angles = [
            math.atan(turn * config.wheel_base / 2.0 / (forward + side * across))
            for side in (-1.0, 1.0)
        ]
    return (*speeds, *speeds), (*angles, *(-angle for angle in angles))


def for_angles(config: FourWheelConfig, speed: float, front: float, rear: float) -> Outputs:
    """Wheels for a speed [m/s] and the steering angles [rad] of both axles' virtual middle wheels.

    Returns:
        As for_twist.
    """
    base = config.wheel_base
    tangents = [math.tan(min(max(a, -math.pi / 2), math.pi / 2)) for a in (front, rear)]
    spread = config.track * (tangents[0] - tangents[1]) / 2.0
    turn = speed * (tangents[0] - tangents[1]) / base
    angles: list[float] = []
    speeds: list[float] = []
    for tangent in tangents:
        pair = [0.0, 0.0]
        if abs(base - abs(spread)) > STOPPED:
            pair = [math.atan(base * tangent / (base + side * spread)) for side in (-1.0, 1.0)]
        parallel = abs(math.tan(pair[0]) - math.tan(pair[1])) <= PARALLEL
        lateral = 0.0 if parallel else speed * tangent
        angles += pair
        speeds += _rims(config, speed, turn, lateral) if abs(speed) > STOPPED else (0.0, 0.0)
    return tuple(speeds), tuple(angles)


def _rims(config: FourWheelConfig, forward: float, turn: float, lateral: float) -> list[float]:
    """Speeds [rad/s] of the left and the right wheel of an axle that moves like this."""
    return [
        (
            math.copysign(math.hypot(forward + side * turn * config.track / 2.0, lateral), forward)
            + side * turn * config.offset
        )
        / config.radius
        for side in (-1.0, 1.0)
    ]


def middle_angle(left: float, right: float) -> float:
    """Angle [rad] of an axle's virtual middle wheel, from those of its two."""
    if abs(left) <= 1e-3 and abs(right) <= 1e-3:
        return 0.0
    total = math.tan(left) + math.tan(right)
    return math.atan(2.0 * math.tan(left) * math.tan(right) / total) if total else 0.0


def body_motion(
    config: FourWheelConfig, speeds: Sequence[float], front: float, rear: float
) -> Vec3:
    """Velocity of the body's middle from its wheels.

    Args:
        speeds: of the wheels [rad/s], order as for_twist.
        front, rear: middle_angle of both axles [rad].

    Returns:
        Forward [m/s], to the left [m/s], turn to the left [rad/s]: the mean of both axles.
    """
    slope = (math.tan(front) - math.tan(rear)) / config.wheel_base
    forward = lateral = turn = 0.0
    for angle, left, right in ((front, *speeds[:2]), (rear, *speeds[2:])):
        along = _axle_speed(config, left, right, slope * math.cos(angle), math.cos(angle))
        forward += along * math.cos(angle) / 2.0
        lateral += along * math.sin(angle) / 2.0
        turn += along * slope * math.cos(angle) / 2.0
    return forward, lateral, turn


def _axle_speed(
    config: FourWheelConfig, left: float, right: float, curvature: float, cosine: float
) -> float:
    """Speed [m/s] along an axle's middle wheel: its wheels' distances from the center are known."""
    half, squares, total = config.track * curvature / 2.0, 0.0, 0.0
    for side, rim in ((-1.0, left), (1.0, right)):
        distance = math.sqrt(max(1.0 + 2.0 * side * half * cosine + half**2, 1e-12))
        speed = rim * config.radius / (1.0 + side * config.offset * curvature / distance)
        squares += speed**2
        total += speed
    return math.copysign(math.sqrt(squares / (2.0 + 2.0 * half**2)), total)


class FourWheelOdometry(Stateful):
    """Pose in the plane, velocity, and what odom_steer reports.

    Args:
        window: number of periods over which the rates are averaged.

    Attributes:
        x, y [m], heading [rad]: as Odometry's.
        linear, lateral [m/s], angular [rad/s]: in the robot's frame, of the last period.
        speed: forward or backwards [m/s]; acceleration [m/s^2], jerk [m/s^3]: its means.
        angles: of the virtual front and rear wheel [rad]; rates: their means [rad/s].
    """

    STATE = (
        "x",
        "y",
        "heading",
        "linear",
        "lateral",
        "angular",
        "speed",
        "acceleration",
        "jerk",
        "angles",
        "rates",
        "_rates",
    )

    def __init__(self, window: int = 10) -> None:
        self._rates: list[collections.deque[float]] = [
            collections.deque(maxlen=max(1, window)) for _ in range(4)
        ]
        self.reset()

    def reset(self, _time: float = 0.0) -> None:
        """Back to the origin, at rest."""
        self.x = self.y = self.heading = 0.0
        self.start()

    def start(self, _time: float = 0.0) -> None:
        """Continue from the present pose, at rest."""
        self.linear = self.lateral = self.angular = self.speed = 0.0
        self.acceleration = self.jerk = 0.0
        self.angles, self.rates = (0.0, 0.0), (0.0, 0.0)
        for rates in self._rates:
            rates.clear()

    def go_back(self, by: float) -> None:
        """It has no time of its own."""

    def move(self, motion: Vec3, angles: tuple[float, float], period: float) -> None:
        """Add a period [s] with a motion (as body_motion gives it) and steering angles [rad].

        A motion that is NaN or further than any wheel can travel is ignored.
        """
        if not all(abs(value) * period <= MAX_ARC for value in motion):
            return
        self.linear, self.lateral, self.angular = motion
        heading = self.heading + self.angular * period / 2.0
        cos, sin = math.cos(heading), math.sin(heading)
        self.x += (self.linear * cos - self.lateral * sin) * period
        self.y += (self.linear * sin + self.lateral * cos) * period
        self.heading += self.angular * period
        speed = math.copysign(math.hypot(self.linear, self.lateral), self.linear)
        acceleration = self._mean(0, (speed - self.speed) / period)
        self.jerk = self._mean(1, (acceleration - self.acceleration) / period)
        self.rates = (
            self._mean(2, (angles[0] - self.angles[0]) / period),
            self._mean(3, (angles[1] - self.angles[1]) / period),
        )
        self.speed, self.acceleration, self.angles = speed, acceleration, angles

    def _mean(self, index: int, value: float) -> float:
        rates = self._rates[index]
        rates.append(value)
        return math.fsum(rates) / len(rates)


@CONTROLLERS.register("four_wheel_steering_controller/FourWheelSteeringController")
class FourWheel(Drive):
    """Commands are (forward [m/s], turn [rad/s]) or (speed [m/s], front, rear angle [rad])."""

    command_sizes = (2, 3)

    @classmethod
    def _configure(
        cls, settings: Settings, description: ModelDescription | None
    ) -> FourWheelConfig:
        pairs = {key: wheel_names(settings, key) for key in _KEYS}
        for key, names in pairs.items():
            if len(names) != 2:
                raise ControllerError(
                    f"{settings.label} has {len(names)} joints in {key}, must be two: left and "
                    "right"
                )
        wheels = pairs["front_wheel"] + pairs["rear_wheel"]
        steers = pairs["front_steering"] + pairs["rear_steering"]
        track = size(settings, "track", lambda: _apart(description, wheels[0], wheels[1]))
        base = size(settings, "wheel_base", lambda: _apart(description, wheels[0], wheels[2]))
        radius = size(settings, "wheel_radius", lambda: wheel_radius(description, wheels[0]))
        try:
            offset = _apart(description, steers[0], wheels[0])
        except ControllerError as error:
            raise ControllerError(f"{settings.label}: {error}") from None
        settings.ignore("wheel_steering_y_offset")  # upstream writes it there, from the URDF
        for name, value in (("wheel_base", base), ("wheel_radius", radius)):
            if not value > 0:
                raise ControllerError(f"{settings.label} has {name} {value}, must be above 0 [m]")
        values = common(settings, (("velocity", wheels), ("position", steers)))
        return FourWheelConfig(
            wheels=wheels,
            steers=steers,
            track=track - 2 * offset,
            offset=offset,
            radius=radius,
            wheel_base=base,
            **values,
        )

    def __init__(self, config: FourWheelConfig, hardware: Hardware) -> None:
        super().__init__(config, hardware)
        self.odometry = FourWheelOdometry(config.window)

    def update(self, time: float, period: float) -> None:
        """Odometry, then wheels and steering within the limits."""
        self.observe(time)
        config = self.config
        target = self._wanted()
        self._age += period
        forward = config.linear.limit(target[0], self.limited[0], self._before[0], period)
        turn = self.limited[1]
        if len(target) == 2:
            turn = config.angular.limit(target[1], turn, self._before[1], period)
            outputs = for_twist(config, forward, turn)
        else:
            outputs = for_angles(config, forward, *target[1:])
        self._before, self.limited = self.limited, (forward, turn)
        values = (*outputs[0], *outputs[1])
        if values != self._written:
            self._written = values
            self.write(values)

    def observe(self, time: float) -> None:
        """Update the odometry to the joints' state."""
        period = time - self._time
        if period < MIN_PERIOD:
            return
        positions = tuple(joint.position for joint in self.joints)
        speeds = [(now - before) / period for now, before in zip(positions[:4], self._positions)]
        front, rear = (middle_angle(*pair) for pair in (positions[4:6], positions[6:]))
        self._positions, self._time = positions, time
        motion = body_motion(self.config, speeds, front, rear)
        self.odometry.move(motion, (front, rear), period)

    def _outputs(self, forward: float, turn: float) -> tuple[float, ...]:
        speeds, angles = for_twist(self.config, forward, turn)
        return *speeds, *angles

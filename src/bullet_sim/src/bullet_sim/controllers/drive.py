"""diff_drive_controller, ackermann_steering_controller: odometry, commands."""

from __future__ import annotations

import collections
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from bullet_sim.component import Stateful
from bullet_sim.controllers.base import CONTROLLERS, MAX_STEPS, Controller, check_command
from bullet_sim.controllers.drive_settings import (
    ROUND,
    WITHOUT_EFFECT,
    BaseConfig,
    DriveConfig,
    common,
    distance_between,
    joint_origin,
    size,
    wheel_names,
    wheel_radius,
)
from bullet_sim.controllers.hardware import Hardware
from bullet_sim.controllers.settings import Settings, check_joints
from bullet_sim.description.model import ModelDescription
from bullet_sim.errors import ControllerError

MIN_PERIOD = 1e-4  # [s] shorter periods give no velocity
STRAIGHT = 1e-6  # [rad] an arc that rotates less counts as straight
MAX_ARC = 1e12  # [m, rad] longer arcs are ignored


class Odometry(Stateful):
    """Pose in the plane and velocity, from arcs.

    Args:
        window: number of periods over which the velocity is averaged.

    Attributes:
        x, y: [m] in the frame in which it started.
        heading: [rad], left positive, not wrapped.
        linear, angular: [m/s, rad/s] in the robot's frame.
        lateral: velocity to the left [m/s]: wheels do not slide.
    """

    STATE = ("x", "y", "heading", "linear", "angular", "_arcs", "_time")
    lateral = 0.0

    def __init__(self, window: int = 10) -> None:
        self._arcs: collections.deque[tuple[float, float]] = collections.deque(
            maxlen=max(1, window)
        )
        self.reset()

    def reset(self, time: float = 0.0) -> None:
        """Back to the origin, at rest."""
        self.x = self.y = self.heading = 0.0
        self.start(time)

    def start(self, time: float) -> None:
        """Continue from the present pose, at rest."""
        self.linear = self.angular = 0.0
        self._arcs.clear()
        self._time = time

    def go_back(self, by: float) -> None:
        """The time of add() went back by [s]: no velocity is computed until it has come again."""
        self._time += by

    def move(self, distance: float, turn: float, time: float) -> None:
        """Add an arc.

        Args:
            distance: travelled since the last call [m], backwards negative.
            turn: change of heading [rad].
            time: now [s].

        An arc that is NaN or longer than MAX_ARC, which no wheel can travel, is ignored.
        """
        self.add(distance, turn, time)
        self.average()

    def add(self, distance: float, turn: float, time: float) -> None:
        """As move(), but the velocities are left to a later average()."""
        if not (abs(distance) <= MAX_ARC and abs(turn) <= MAX_ARC):
            self._time = time
            return
        start = self.heading
        self.heading += turn
        if abs(turn) < STRAIGHT:
            self.x += distance * math.cos(start + turn / 2)
            self.y += distance * math.sin(start + turn / 2)
        else:
            radius = distance / turn
            self.x += radius * (math.sin(self.heading) - math.sin(start))
            self.y -= radius * (math.cos(self.heading) - math.cos(start))
        period = time - self._time
        if period < MIN_PERIOD:
            return
        self._time = time
        self._arcs.append((distance / period, turn / period))

    def average(self) -> None:
        """Compute the velocities."""
        if self._arcs:
            self.linear = math.fsum(arc[0] for arc in self._arcs) / len(self._arcs)
            self.angular = math.fsum(arc[1] for arc in self._arcs) / len(self._arcs)


class Drive(Controller):
    """Base class of bases' controllers: time-out, limits, odometry.

    Attributes:
        odometry: Odometry, or an object with its attributes.
        limited: (forward [m/s], yaw rate [rad/s] or steering angle [rad]) command after the limits.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        "odometry",
        "limited",
        "_before",
        "_target",
        "_age",
        "_written",
        "_positions",
        "_time",
    )
    periodic = True
    interface = "velocity"
    command_sizes: ClassVar[tuple[int, ...]] = (2,)

    @classmethod
    def configure(
        cls, settings: Settings, joints: tuple[str, ...], description: ModelDescription | None
    ) -> BaseConfig:
        config = cls._configure(settings, description)
        check_joints(config.joints, settings.label, joints)
        return config

    def __init__(self, config: Any, hardware: Hardware) -> None:
        super().__init__(config, hardware)
        # as upstream the velocity of open_loop is that of the last command
        self.odometry: Any = Odometry(1 if config.open_loop else config.window)
        self._positions: tuple[float, ...] = (0.0,) * len(self.joints)
        self._time = 0.0
        self._forget()

    def _forget(self) -> None:
        self.limited: tuple[float, ...] = (0.0, 0.0)
        self._before: tuple[float, ...] = (0.0, 0.0)
        self._target: tuple[float, ...] = (0.0, 0.0)
        self._age = math.inf
        self._written: tuple[float, ...] = ()

    def start(self, time: float) -> None:
        """Start at rest and continue the odometry."""
        self._forget()
        self._positions = tuple(joint.position for joint in self.joints)
        self._time = time
        self.odometry.start(time)
        self._written = self._outputs(0.0, 0.0)
        self.write(self._written)

    def stop(self) -> None:
        """As upstream's brake(): all that it commands is 0."""
        self.write((0.0,) * len(self.setters))
        super().stop()

    def reset(self, time: float) -> None:
        """Start at the origin."""
        self.odometry.reset(time)
        self.start(time)

    def go_back(self, by: float, since: float) -> None:
        """As Controller's: the last command is as much younger, and so are velocities."""
        self._age -= by + since
        self._time += since
        self.odometry.go_back(by + since)

    def check(self, values: Any) -> tuple[float, ...]:
        """Check a command of command_sizes numbers."""
        return check_command(self.config.name, values, self.command_sizes)

    def command(self, values: tuple[float, ...]) -> None:
        """Set (forward [m/s], turning); valid until the time-out."""
        self._target, self._age = values, 0.0

    def update(self, time: float, period: float) -> None:
        """Odometry, then wheel speeds within the limits."""
        self.observe(time)
        target = self._wanted()
        self._age += period
        now = self._limit(target, period)
        self._before, self.limited = self.limited, now
        outputs = self._outputs(*now)
        if outputs != self._written:
            self._written = outputs
            for set_command, value in zip(self.setters, outputs):
                set_command(value)
        self._note(period)

    def _note(self, period: float) -> None:
        """Note what is published besides, after an update [s] after the last one."""

    def _wanted(self) -> tuple[float, ...]:
        """The command, or zeros after its time-out."""
        is_new = self._age <= self.config.timeout
        return self._target if is_new else (0.0,) * len(self._target)

    def _limit(self, target: tuple[float, ...], period: float) -> tuple[float, ...]:
        """A command within the limits."""
        return tuple(
            limiter.limit(value, last, before, period)
            for limiter, value, last, before in zip(
                (self.config.linear, self.config.angular), target, self.limited, self._before
            )
        )

    def steps_until_update(self, period: float) -> int:
        """As Controller's: where the limits have let the whole command through, and what was
        commanded last is what they let through."""
        if type(self).update is not Drive.update:
            return 0
        if type(self).observe is not Drive.observe or getattr(self.config, "publish_wheels", False):
            return 0
        target = self._wanted()
        now = self._limit(target, period)
        if not now == self.limited == self._before or self._outputs(*now) != self._written:
            return 0
        if not any(target):  # so it is after the time-out, too
            return MAX_STEPS
        left = self.config.timeout - self._age
        return int(left / period) - 1  # one less than until the time-out, for rounding

    def steps_made(
        self, times: Sequence[float], period: float, positions: Sequence[Sequence[float]]
    ) -> None:
        """As Controller's: odometry, and the age of the command."""
        for time, row in zip(times, positions):
            self._add_motion(time, tuple(row))
            self._age += period
        self.odometry.average()

    def observe(self, time: float) -> None:
        """Update the odometry to the joints' state."""
        self._add_motion(time, tuple(joint.position for joint in self.joints))
        self.odometry.average()

    def _add_motion(self, time: float, positions: tuple[float, ...]) -> None:
        if self.config.open_loop:
            period = time - self._time
            distance, turn = (v * period for v in self.limited)
        else:
            turned = [now - before for now, before in zip(positions, self._positions)]
            distance, turn = self._travelled(turned, positions)
            self._positions = positions
        self._time = time
        self.odometry.add(distance, turn, time)

    @classmethod
    def _configure(cls, settings: Settings, description: ModelDescription | None) -> BaseConfig:
        """The configuration; its joints are still to be checked."""
        raise NotImplementedError

    def _outputs(self, linear: float, angular: float) -> tuple[float, ...]:
        """What a command within the limits makes of the joints' commands."""
        raise NotImplementedError

    def _travelled(
        self, turned: Sequence[float], positions: Sequence[float]
    ) -> tuple[float, float]:
        """Distance [m] and change of heading [rad].

        Args:
            turned: changes of the joints' positions [rad].
            positions: of the joints [rad].
        """
        raise NotImplementedError


@dataclass(frozen=True)
class WheelMotion:
    """What the wheels do and what was commanded, of the last update.

    Attributes:
        positions, velocities, accelerations: commanded, of the left and of the right wheels: the
            sum of the velocities over the time [rad], [rad/s], and as upstream the change of
            velocity times the period.
        measured_velocities, measured_accelerations: of all wheels, left ones first.
    """

    positions: tuple[float, float] = (0.0, 0.0)
    velocities: tuple[float, float] = (0.0, 0.0)
    accelerations: tuple[float, float] = (0.0, 0.0)
    measured_velocities: tuple[float, ...] = ()
    measured_accelerations: tuple[float, ...] = ()


@CONTROLLERS.register("diff_drive_controller/DiffDriveController")
class DiffDrive(Drive):
    """Left and right wheels; commands are m/s forward and rad/s to the left.

    Attributes:
        wheels: WheelMotion, where its topic is configured.
    """

    STATE = ("config", "wheels")

    def __init__(self, config: Any, hardware: Hardware) -> None:
        super().__init__(config, hardware)
        self.wheels = WheelMotion()

    def start(self, time: float) -> None:
        """As a Drive; the commanded positions of the wheels continue."""
        super().start(time)
        velocities = tuple(joint.velocity for joint in self.joints)
        self.wheels = WheelMotion(
            self.wheels.positions, (0.0, 0.0), (0.0, 0.0), velocities, (0.0,) * len(velocities)
        )

    def reset(self, time: float) -> None:
        """As a Drive; the commanded positions of the wheels are 0."""
        self.wheels = WheelMotion()
        super().reset(time)

    def _note(self, period: float) -> None:
        """What the wheels do."""
        if not self.config.publish_wheels:
            return
        before, (left, *_, right) = self.wheels, self._outputs(*self.limited)
        measured = tuple(joint.velocity for joint in self.joints)
        self.wheels = WheelMotion(
            (before.positions[0] + left * period, before.positions[1] + right * period),
            (left, right),
            ((left - before.velocities[0]) * period, (right - before.velocities[1]) * period),
            measured,
            tuple((now - old) / period for now, old in zip(measured, before.measured_velocities)),
        )

    def tune(
        self, multipliers: tuple[float, float, float], publish_rate: float, publish_tf: bool
    ) -> None:
        """Change the configuration while it runs.

        Args:
            multipliers: of the separation and of the left and the right radius.
            publish_rate: of the odometry [Hz].
        """
        (separation, radius), (of_separation, left, right) = self.config.sizes, multipliers
        self.config = replace(
            self.config,
            separation=separation * of_separation,
            radii=(radius * left, radius * right),
            multipliers=multipliers,
            publish_rate=publish_rate,
            publish_tf=publish_tf,
        )

    @classmethod
    def _configure(cls, settings: Settings, description: ModelDescription | None) -> DriveConfig:
        left, right = wheel_names(settings, "left_wheel"), wheel_names(settings, "right_wheel")
        if len(left) != len(right):
            raise ControllerError(
                f"{settings.label} has {len(left)} left and {len(right)} right wheels, must be as "
                "many"
            )
        of_sides = [
            settings.number(f"{side}_wheel_radius_multiplier", 1.0, above=0.0)
            for side in ("left", "right")
        ]
        if "wheel_radius_multiplier" in settings:  # then upstream reads no others
            of_sides = [settings.number("wheel_radius_multiplier", 1.0, above=0.0)] * 2
        multipliers = (
            settings.number("wheel_separation_multiplier", 1.0, above=0.0),
            of_sides[0],
            of_sides[1],
        )
        wheel_states = WITHOUT_EFFECT[0]
        publish_wheels = settings.flag(wheel_states, False)
        radius = size(settings, "wheel_radius", lambda: wheel_radius(description, left[0], ROUND))
        separation = size(
            settings, "wheel_separation", lambda: distance_between(description, left[0], right[0])
        )
        return DriveConfig(
            left=left,
            right=right,
            separation=separation * multipliers[0],
            radii=(radius * multipliers[1], radius * multipliers[2]),
            sizes=(separation, radius),
            multipliers=multipliers,
            publish_wheels=publish_wheels,
            **common(settings, (("velocity", left + right),), WITHOUT_EFFECT[1:]),
        )

    def _outputs(self, linear: float, angular: float) -> tuple[float, ...]:
        config = self.config
        across = angular * config.separation / 2
        left, right = (linear - across) / config.radii[0], (linear + across) / config.radii[1]
        return (left,) * len(config.left) + (right,) * len(config.right)

    def _travelled(self, turned: Sequence[float], _: Sequence[float]) -> tuple[float, float]:
        config, count = self.config, len(self.config.left)
        left, right = (
            radius * math.fsum(angles) / count
            for radius, angles in zip(config.radii, (turned[:count], turned[count:]))
        )
        return (left + right) / 2, (right - left) / config.separation


@CONTROLLERS.register(
    "ackermann_steering_controller/AckermannSteeringController",
    "steer_drive_controller/SteerDriveController",
)
class Ackermann(Drive):
    """One rear wheel and one steering joint; commands are m/s forward and the steering angle.

    As upstream, the second number of the command is an angle [rad] and no rate, and the odometry of
    open_loop takes it for a rate.
    """

    @classmethod
    def _configure(cls, settings: Settings, description: ModelDescription | None) -> DriveConfig:
        rear = settings.text("rear_wheel", "rear_wheel_joint")
        front = settings.text("front_steer", "front_steer_joint")
        radius = size(settings, "wheel_radius", lambda: wheel_radius(description, rear))
        separation = size(
            settings,
            "wheel_separation_h",
            lambda: abs(joint_origin(description, front)[0] - joint_origin(description, rear)[0]),
        )
        multiplier = settings.number("wheel_separation_h_multiplier", 1.0, above=0.0)
        config = DriveConfig(
            left=(rear,),
            right=(front,),
            separation=separation * multiplier,
            radii=(radius * settings.number("wheel_radius_multiplier", 1.0, above=0.0), radius),
            steer_multiplier=settings.number("steer_pos_multiplier", 1.0),
            **{
                **common(settings, (("position", (front,)), ("velocity", (rear,)))),
                "joints": (rear, front),
            },
        )
        if not config.separation > 0:
            raise ControllerError(
                f"{settings.label} has wheel_separation_h {separation}, must be above 0 [m]"
            )
        return config

    def _outputs(self, linear: float, angle: float) -> tuple[float, float]:
        return angle, linear / self.config.radii[1]

    def _travelled(
        self, turned: Sequence[float], positions: Sequence[float]
    ) -> tuple[float, float]:
        config = self.config
        distance = turned[0] * config.radii[0]
        angle = positions[1] * config.steer_multiplier
        return distance, distance * math.tan(angle) / config.separation

"""The joints of steer_bot_hardware_gazebo: a car with one wheel and one steering joint to command.

Its controllers see a rear wheel and a front steering joint that need not exist; commands to them
drive the four wheels and the two front hinges of the car.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, cast

from bullet_sim.controllers.drive_settings import joint_position
from bullet_sim.controllers.handle import JointHandle
from bullet_sim.controllers.hardware import RobotJoints
from bullet_sim.controllers.settings import Settings
from bullet_sim.description.model import Joint, ModelDescription
from bullet_sim.engine.api import Motor
from bullet_sim.errors import ControllerError

NAMESPACE = "steer_bot_hardware_gazebo"


@dataclass(frozen=True)
class SteerBotConfig:
    """Parameters below steer_bot_hardware_gazebo.

    Attributes:
        rear_wheel, front_steer: names of the joints that controllers command.
        rear_wheels, front_wheels, front_steers: the car's joints, each right, left.
        ackermann: the hinges follow Ackermann's geometry; else both have the commanded angle.
        track, wheel_base: wheel_separation_w and wheel_separation_h [m].
    """

    rear_wheel: str
    front_steer: str
    rear_wheels: tuple[str, str]
    front_wheels: tuple[str, str]
    front_steers: tuple[str, str]
    ackermann: bool
    track: float
    wheel_base: float

    def interfaces(self) -> dict[str, tuple[str, ...]]:
        """Joint name -> offered interfaces."""
        velocity = (self.rear_wheel, *self.rear_wheels)
        position = (self.front_steer, *self.front_steers)
        return {
            **dict.fromkeys(velocity, ("velocity",)),
            **dict.fromkeys(position, ("position",)),
            **dict.fromkeys(self.front_wheels, ("state",)),
        }


def parse_steer_bot(
    values: Any, label: str, joints: Sequence[str], description: ModelDescription | None = None
) -> SteerBotConfig:
    """Check the parameters.

    Args:
        values: mapping from the parameter server.
        joints: names of the robot's movable joints.
        description: for sizes that are not given.

    Raises:
        ControllerError: names the parameter, its value and what is valid.
    """
    settings = Settings(values or {}, label)
    rear_wheels, front_wheels, front_steers = (
        _pair(settings, f"virtual_{key}", joints)
        for key in ("rear_wheels", "front_wheels", "front_steers")
    )
    return SteerBotConfig(
        settings.text("rear_wheel", None),
        settings.text("front_steer", None),
        rear_wheels,
        front_wheels,
        front_steers,
        ackermann=settings.flag("enable_ackermann_link", True),
        track=_size(settings, "wheel_separation_w", description, front_steers, 1),
        wheel_base=_size(
            settings, "wheel_separation_h", description, (front_steers[0], rear_wheels[0]), 0
        ),
    )


def _pair(settings: Settings, key: str, joints: Sequence[str]) -> tuple[str, str]:
    names = settings.get(key)
    if not isinstance(names, list) or len(names) != 2 or not set(names) <= set(joints):
        raise ControllerError(
            f"{settings.label} has {key} {names!r}, must be two joints, right and left; joints are "
            f"{', '.join(joints) or '(none)'}"
        )
    right, left = names
    return right, left


def _size(
    settings: Settings,
    key: str,
    description: ModelDescription | None,
    joints: Iterable[str],
    axis: int,
) -> float:
    value = settings.number(key, None, above=0.0)
    if value is None:
        first, second = (joint_position(description, name)[axis] for name in joints)
        value = abs(first - second)
        if not value > 0:
            raise ControllerError(f"{settings.label} has no {key}, and the URDF does not give it")
    return value


class CarJoints(RobotJoints, Protocol):
    """Joints with their state by name."""

    def state(self) -> tuple[dict[str, float], dict[str, float]]: ...
    def impose_velocities(self, names: Iterable[str], values: Iterable[float]) -> None: ...
    def impose_positions(self, names: Iterable[str], values: Iterable[float]) -> None: ...


class SteerBotJoints:
    """In place of a car's Joints: the same methods, with the two commanded joints."""

    def __init__(self, joints: CarJoints, config: SteerBotConfig) -> None:
        self._joints, self._config = joints, config
        real = (*config.rear_wheels, *config.front_wheels, *config.front_steers)
        both = (config.rear_wheel, config.front_steer)
        self.names = tuple(sorted({*real, *both}))
        self.limits = {
            **{name: joints.limits[name] for name in real},
            **{name: joints.limits.get(name) or Joint(name, "revolute", "", "") for name in both},
        }
        self._means = {
            config.rear_wheel: config.rear_wheels,
            config.front_steer: config.front_steers,
        }
        indices = {name: index for index, name in enumerate(joints.names)}
        self._sources = [
            [indices[source] for source in self._means.get(name, (name,))] for name in self.names
        ]

    def read(self, handles: Sequence[JointHandle]) -> None:
        """As Joints.read; the commanded joints have their pair's mean."""
        positions, velocities = self._joints.state()
        for name, handle in zip(self.names, handles):
            sources = self._means.get(name, (name,))
            handle.position, handle.velocity = (
                math.fsum(values[source] for source in sources) / len(sources)
                for values in (positions, velocities)
            )

    def columns(self, indices: Iterable[int]) -> list[list[float]]:
        """As Joints.columns."""
        of_car = self._joints.columns(range(len(self._joints.names)))
        return [
            [
                math.fsum(column[source] for source in self._sources[index])
                / len(self._sources[index])
                for index in indices
            ]
            for column in of_car
        ]

    def motor(self, name: str) -> Motor:
        """The rear wheel's drives all four wheels, the front steering joint's rotates both hinges;
        those of other joints have no effect."""
        config = self._config
        wheels = (*config.rear_wheels, *config.front_wheels) if name == config.rear_wheel else ()
        hinges = config.front_steers if name == config.front_steer else ()
        return cast("Motor", _SharedMotor(self, self._joints, wheels, hinges))

    def hinge_angles(self, angle: float) -> tuple[float, float]:
        """Angles [rad] of the right and the left hinge for one of the virtual middle wheel.

        As upstream, which counts half the track only.
        """
        config = self._config
        if not config.ackermann:
            return angle, angle
        ahead, across = 2.0 * config.wheel_base, config.track / 2.0 * math.tan(angle)
        along = ahead * math.tan(angle)
        return math.atan2(along, ahead + across), math.atan2(along, ahead - across)

    def apply_efforts(self, handles: Sequence[JointHandle], computes: bool = False) -> None:
        """No joint takes efforts."""


class _SharedMotor:
    """Motor of a joint whose commands move others."""

    def __init__(
        self,
        joints: SteerBotJoints,
        car: CarJoints,
        wheels: Sequence[str],
        hinges: Sequence[str],
    ) -> None:
        self._joints, self._car, self._wheels, self._hinges = joints, car, wheels, hinges

    def track_velocity(self, velocity: float, effort: float) -> None:
        self._car.impose_velocities(self._wheels, [velocity] * len(self._wheels))

    def track_position(self, position: float, effort: float, speed: float) -> None:
        self._car.impose_positions(self._hinges, self._joints.hinge_angles(position))

    def release(self) -> None:
        for name in (*self._wheels, *self._hinges):
            self._car.motor(name).release()

"""Configuration of four_wheel_steering_controller."""

import math
from dataclasses import dataclass

from bullet_sim.controllers.drive.config import BaseConfig, common, size, wheel_names
from bullet_sim.controllers.drive.geometry import joint_position, wheel_radius
from bullet_sim.errors import ControllerError

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

    wheels: tuple[str, str, str, str]
    steers: tuple[str, str, str, str]
    track: float
    offset: float
    radius: float
    wheel_base: float


def parse_four_wheel(settings, description):
    """Configuration of a four_wheel_steering_controller.

    Args:
        settings: Settings of the entry.
        description: ModelDescription or None.

    Returns:
        FourWheelConfig, claims as (interface, joint names) pairs, notes.

    Raises:
        ControllerError: names the key, the value and what is valid.
    """
    pairs = {key: wheel_names(settings, key) for key in _KEYS}
    for key, names in pairs.items():
        if len(names) != 2:
            raise ControllerError(
                f"{settings.what} has {len(names)} joints in {key}, must be two: left and right"
            )
    wheels = pairs["front_wheel"] + pairs["rear_wheel"]
    steers = pairs["front_steering"] + pairs["rear_steering"]
    track = size(settings, "track", lambda: _apart(description, wheels[0], wheels[1]))
    base = size(settings, "wheel_base", lambda: _apart(description, wheels[0], wheels[2]))
    radius = size(settings, "wheel_radius", lambda: wheel_radius(description, wheels[0]))
    try:
        offset = _apart(description, steers[0], wheels[0])
    except ControllerError as error:
        raise ControllerError(f"{settings.what}: {error}") from None
    settings.ignore("wheel_steering_y_offset")  # upstream writes it there, from the URDF
    for name, value in (("wheel_base", base), ("wheel_radius", radius)):
        if not value > 0:
            raise ControllerError(f"{settings.what} has {name} {value}, must be above 0 [m]")
    values, notes = common(settings)
    config = FourWheelConfig(wheels, steers, track - 2 * offset, offset, radius, base, **values)
    return config, (("velocity", wheels), ("position", steers)), notes


def _apart(description, first, second):
    """Distance of two joints seen from above [m]."""
    a, b = joint_position(description, first), joint_position(description, second)
    return math.hypot(a[0] - b[0], a[1] - b[1])

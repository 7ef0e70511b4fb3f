"""How far the marker was dragged, as a velocity."""

import math
from dataclasses import dataclass

AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Scale:
    """One direction.

    Attributes:
        factor: Speed for each metre or radian that the marker was dragged [1/s].
        lowest: Smallest speed, below 0 [m/s or rad/s].
        highest: Largest speed [m/s or rad/s].
    """

    factor: float
    lowest: float
    highest: float

    def speed(self, way):
        """Speed of a way [m or rad]."""
        return max(min(self.factor * way, self.highest), self.lowest)


@dataclass(frozen=True)
class Drag:
    """Scales of all directions.

    Attributes:
        linear: Dict of x, y, z -> Scale; the marker has no arrows for what is missing.
        angular: Scale of the turn.
    """

    linear: dict
    angular: Scale

    def velocity(self, position, orientation):
        """Velocity of a dragged marker.

        Args:
            position: (x, y, z) in the robot's frame [m].
            orientation: Quaternion (x, y, z, w).

        Returns:
            ((x, y, z) [m/s], turn rate [rad/s]).
        """
        speeds = tuple(
            self.linear[name].speed(way) if name in self.linear else 0.0
            for name, way in zip(AXES, position)
        )
        return speeds, self.angular.speed(yaw_of(*orientation))


def yaw_of(x, y, z, w):
    """Heading of a quaternion [rad]."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def read(parameters):
    """Reads the parameters.

    Args:
        parameters: Dict of linear_scale, max_positive_linear_velocity,
            max_negative_linear_velocity (numbers for x alone, or maps of x, y, z), angular_scale,
            max_angular_velocity.

    Raises:
        ValueError: Names the parameter, its value and what is valid.
    """
    keys = ("linear_scale", "max_negative_linear_velocity", "max_positive_linear_velocity")
    given = [parameters.get(key, default) for key, default in zip(keys, (1.0, -1.0, 1.0))]
    if not isinstance(given[0], dict):
        given = [{"x": value} for value in given]
    unknown = sorted(set(map(str, given[0])) - set(AXES))
    if unknown:
        raise ValueError(f"linear_scale names {', '.join(unknown)}, must be of {', '.join(AXES)}")
    for key, value in zip(keys, given):
        if not isinstance(value, dict):
            raise ValueError(f"{key} is {value!r}, must be a map of x, y, z as linear_scale is")
    linear = {
        name: Scale(*(_number(key, value.get(name, 0.0)) for key, value in zip(keys, given)))
        for name in given[0]
    }
    fastest = _number("max_angular_velocity", parameters.get("max_angular_velocity", 2.2))
    factor = _number("angular_scale", parameters.get("angular_scale", 2.2))
    return Drag(linear, Scale(factor, -fastest, fastest))


def _number(name, value):
    if isinstance(value, bool) or not isinstance(value, (int, float)) or value - value != 0.0:
        raise ValueError(f"{name} is {value!r}, must be a number")
    return float(value)

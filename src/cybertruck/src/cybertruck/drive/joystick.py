"""Two axes of a pad as a drive command, for driving without a teleop node. No ROS."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class JoyDrive:
    """Axes and scales of the drive command.

    Attributes:
        speed_axis, steering_axis: indices into sensor_msgs/Joy.axes.
        speed: [m/s] at axis value +1; negative turns the axis round.
        steering: [rad] at axis value +1; negative turns the axis round.
    """

    speed_axis: int = 1
    steering_axis: int = 0
    speed: float = 1.0
    steering: float = 0.7854

    def __post_init__(self):
        for name in ("speed_axis", "steering_axis"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < 0:
                raise ValueError(f"joy_{name} is {value!r}, must be a whole number, 0 or more")
        for name in ("speed", "steering"):
            value = getattr(self, name)
            if (
                isinstance(value, bool)
                or not isinstance(value, (int, float))
                or not math.isfinite(value)
            ):
                raise ValueError(f"joy_{name} is {value!r}, must be a finite number")

    @classmethod
    def from_parameters(cls, get):
        """From a function get(name, default)."""
        return cls(**{name: get("joy_" + name, default) for name, default in vars(cls()).items()})

    def command(self, axes):
        """Steering [rad] and speed [m/s] for a sequence of axis values in -1..1.

        Raises:
            ValueError: too few axes, or a value that is not finite.
        """
        for axis in (self.speed_axis, self.steering_axis):
            if axis >= len(axes):
                raise ValueError(f"axis {axis} is asked for, the pad has {len(axes)} axes")
            if not math.isfinite(axes[axis]):
                raise ValueError(f"axis {axis} is {axes[axis]}, must be a finite number")
        return self.steering * axes[self.steering_axis], self.speed * axes[self.speed_axis]

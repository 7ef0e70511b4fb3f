"""Two axes of a pad as a drive command, for driving without a teleop node. No ROS."""

import math
from dataclasses import dataclass

from paddock_common.settings import check, number


@dataclass(frozen=True)
class JoyDrive:
    """Axes and scales of the drive command.

    Attributes:
        speed_axis, steering_axis: indices into sensor_msgs/Joy.axes.
        speed: [m/s] at axis value +1; negative turns the axis round.
        steering: [rad] at axis value +1; negative turns the axis round.
    """

    speed_axis: int = number(1, least=0, whole=True)
    steering_axis: int = number(0, least=0, whole=True)
    speed: float = number(1.0, unit="m/s")
    steering: float = number(0.7854, unit="rad")

    def __post_init__(self):
        check(self, prefix="joy_")

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

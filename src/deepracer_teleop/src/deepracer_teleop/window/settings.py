"""Settings of the window: speeds, times, limits. The defaults are the original's values."""

import math
from dataclasses import dataclass, fields

DEFAULT_SPEED = 10.0
DEFAULT_ANGULAR_SPEED = 5.0
LINEAR_WAIT = 1.0
RECT_ANGLE_TURN_WAIT = 0.8


@dataclass(frozen=True)
class Settings:
    """Values of one window.

    Attributes:
        default_speed: linear.x of Forward and of cruise, in the driver's unit (wheel rad/s in the
            original mode, m/s in ackermann mode).
        default_angular_speed: Size of angular.z of Left and Right, in the driver's unit.
        linear_wait: ROS time that Forward and Backwards last [s].
        turn_wait: ROS time that Left and Right last [s].
        slider_limit: The slider goes from minus this to this; a whole number.
        slider_scale: angular.z is the slider's value divided by this.
        angular_sign: 1: positive angular.z steers right (the original). -1: left (REP-103).
        repeat_rate: How often a moving car's command is repeated, in ROS time [Hz].
        camera_timeout: Wall time without a picture after which the camera counts as stopped [s].
        master_timeout: Wall time without a response after which the master counts as lost [s].
    """

    default_speed: float = DEFAULT_SPEED
    default_angular_speed: float = DEFAULT_ANGULAR_SPEED
    linear_wait: float = LINEAR_WAIT
    turn_wait: float = RECT_ANGLE_TURN_WAIT
    slider_limit: float = 50
    slider_scale: float = 10.0
    angular_sign: float = 1
    repeat_rate: float = 10.0
    camera_timeout: float = 2.0
    master_timeout: float = 3.0

    def __post_init__(self):
        for item in fields(self):
            value = getattr(self, item.name)
            if (
                isinstance(value, bool)
                or not isinstance(value, (int, float))
                or not math.isfinite(value)
            ):
                raise ValueError(f"{item.name} is {value!r}; it must be a number")
            if item.name == "angular_sign":
                if value not in (1, -1):
                    raise ValueError(
                        f"angular_sign is {value!r}; it must be 1 (positive is right) "
                        "or -1 (positive is left)"
                    )
            elif value <= 0:
                raise ValueError(f"{item.name} is {value!r}; it must be above 0")
        if self.slider_limit != int(self.slider_limit):
            raise ValueError(f"slider_limit is {self.slider_limit!r}; it must be a whole number")

    def slider_to_angular(self, value):
        """Returns angular.z for a slider value (positive is right in the window)."""
        return self.angular_sign * value / self.slider_scale


def settings_from_parameters(get_param):
    """Reads the private parameters of a node.

    Args:
        get_param: rospy.get_param or a function like it: (name, default) -> value.

    Returns:
        Settings.

    Raises:
        ValueError: A value is no number or out of range; the message names it.
    """
    return Settings(
        **{item.name: get_param("~" + item.name, item.default) for item in fields(Settings)}
    )

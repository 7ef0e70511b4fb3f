"""The node teleop_twist_joy: axes to twists while the deadman button is held."""

from dataclasses import dataclass

import rospy
from geometry_msgs.msg import Twist, Vector3
from paddock_common.settings import Number
from sensor_msgs.msg import Joy

from paddock_common import nodes

STILL = (0.0,) * 6
NUMBER = Number()


class Deadman:
    """Converts a pad's messages to commands."""

    def __init__(self, mapping):
        self._mapping = mapping
        self._stopped = False

    def command(self, axes, buttons):
        """Processes one message of the pad.

        Args:
            axes: Joy.axes.
            buttons: Joy.buttons.

        Returns:
            (x, y, z [m/s], roll, pitch, yaw [rad/s]), or None when there is nothing to send.
        """
        turbo = self._held(self._mapping.turbo_button, buttons)
        if turbo or self._held(self._mapping.enable_button, buttons):
            self._stopped = False
            return self._mapping.velocity(axes, turbo)
        if self._stopped:
            return None
        self._stopped = True
        return STILL

    @staticmethod
    def _held(index, buttons):
        return 0 <= index < len(buttons) and bool(buttons[index])


LINEAR = ("x", "y", "z")
ANGULAR = ("roll", "pitch", "yaw")


@dataclass(frozen=True)
class Axis:
    """One axis of the pad.

    Attributes:
        index: In Joy.axes.
        scale: Speed at 1 [m/s or rad/s].
        turbo: The same with the turbo button.
    """

    index: int
    scale: float
    turbo: float


@dataclass(frozen=True)
class Mapping:
    """Functions of axes and buttons.

    Attributes:
        axes: Dict of x, y, z, roll, pitch, yaw -> Axis; missing ones stay 0.
        enable_button: Drives only while it is held.
        turbo_button: Drives fast while it is held; below 0: none.
    """

    axes: dict
    enable_button: int = 0
    turbo_button: int = -1

    def velocity(self, axes, turbo):
        """Speeds of a pad's axes.

        Returns:
            (x, y, z [m/s], roll, pitch, yaw [rad/s]).
        """
        return tuple(self._value(axes, name, turbo) for name in LINEAR + ANGULAR)

    def _value(self, axes, name, turbo):
        axis = self.axes.get(name)
        if axis is None or not 0 <= axis.index < len(axes):
            return 0.0
        return axes[axis.index] * (axis.turbo if turbo else axis.scale)


def read(parameters):
    """Reads the parameters.

    Args:
        parameters: Dict of enable_button, enable_turbo_button, axis_linear, scale_linear,
            scale_linear_turbo, axis_angular, scale_angular, scale_angular_turbo. An axis is a
            number (x, or yaw) or a dict of names to numbers, and so are its scales then.

    Raises:
        ValueError: Names the parameter, its value and what is valid.
    """
    axes = _axes(parameters, "linear", LINEAR, "x", 1, 0.5, 1.0)
    axes.update(_axes(parameters, "angular", ANGULAR, "yaw", 0, 0.5, None))
    return Mapping(
        axes,
        _integer("enable_button", parameters.get("enable_button", 0)),
        _integer("enable_turbo_button", parameters.get("enable_turbo_button", -1)),
    )


def _axes(parameters, group, names, alone, index, scale, turbo):
    setting = parameters.get("axis_" + group, index)
    if not isinstance(setting, dict):
        normal = NUMBER.check("scale_" + group, parameters.get("scale_" + group, scale))
        turbo_scale = parameters.get(f"scale_{group}_turbo", normal if turbo is None else turbo)
        return {
            alone: Axis(
                _integer("axis_" + group, setting),
                normal,
                NUMBER.check(f"scale_{group}_turbo", turbo_scale),
            )
        }
    unknown = sorted(set(map(str, setting)) - set(names))
    if unknown:
        raise ValueError(f"axis_{group} names {', '.join(unknown)}, must be of {', '.join(names)}")
    scales = []
    for key in ("scale_" + group, f"scale_{group}_turbo"):
        value = parameters.get(key, {})
        if not isinstance(value, dict):
            raise ValueError(f"{key} is {value!r}, must be a map of names as axis_{group} is")
        scales.append({name: NUMBER.check(f"{key}/{name}", value.get(name, 0.0)) for name in names})
    return {
        name: Axis(_integer(f"axis_{group}/{name}", axis), scales[0][name], scales[1][name])
        for name, axis in setting.items()
    }


def _integer(name, value):
    if NUMBER.check(name, value) != int(value):
        raise ValueError(f"{name} is {value!r}, must be a whole number")
    return int(value)


def connect():
    """Connects the node.

    Raises:
        ValueError: A parameter is wrong.
    """
    mapping = read(rospy.get_param("~", {}))
    rospy.loginfo("teleop_twist_joy: enable button %d", mapping.enable_button)
    if mapping.turbo_button >= 0:
        rospy.loginfo("teleop_twist_joy: turbo button %d", mapping.turbo_button)
    for name, axis in mapping.axes.items():
        rospy.loginfo(
            "teleop_twist_joy: %s is axis %d times %g, with turbo %g",
            name,
            axis.index,
            axis.scale,
            axis.turbo,
        )
    deadman = Deadman(mapping)
    publisher = rospy.Publisher("cmd_vel", Twist, queue_size=1, latch=True)

    def publish_command(joy):
        command = deadman.command(joy.axes, joy.buttons)
        if command is not None:
            publisher.publish(Twist(Vector3(*command[:3]), Vector3(*command[3:])))

    rospy.Subscriber("joy", Joy, publish_command, queue_size=1)


def main():
    nodes.run("teleop_twist_joy_node", connect)

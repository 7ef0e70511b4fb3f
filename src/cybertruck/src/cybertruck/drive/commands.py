"""Commands to the drive: from Twist and joystick, to wheels and hinges."""

import math
import threading
from dataclasses import dataclass

from nav_msgs.msg import Odometry
from paddock_common.geometry import quaternion_of
from paddock_common.settings import Checked, Number, number

from cybertruck.drive.odometry import Measured

WHEELS = ("rear_left_wheel_joint", "rear_right_wheel_joint")
HINGES = ("front_left_steer_joint", "front_right_steer_joint")
ENCODERS = ("front_left_wheel_joint", "front_right_wheel_joint")
PLANAR_VARIANCE = 1e-6  # variance of height, roll and pitch, which are 0 on flat ground


def measured(message):
    """Odometry's input from a sensor_msgs/JointState.

    Returns:
        (Measured, dict of front wheel joint -> angle [rad]).

    Raises:
        ValueError: a joint is missing or a number is not finite.
    """
    index = {name: i for i, name in enumerate(message.name)}
    missing = [name for name in WHEELS + HINGES + ENCODERS if name not in index]
    if missing:
        raise ValueError(
            f"joint '{missing[0]}' is missing; there are {', '.join(message.name) or '(none)'}"
        )
    count = len(message.name)
    if len(message.position) != count or len(message.velocity) != count:
        raise ValueError(
            f"{len(message.position)} positions and {len(message.velocity)} "
            f"velocities for {count} joints; the numbers must be equal"
        )
    values = [message.position[index[name]] for name in WHEELS + HINGES]
    values += [message.velocity[index[name]] for name in WHEELS]
    encoders = {name: message.position[index[name]] for name in ENCODERS}
    for value in values + list(encoders.values()):
        if not math.isfinite(value):
            raise ValueError(f"a position or velocity is {value}, must be finite")
    return Measured(*values), encoders


def odometry(stamp, frames, state):
    """nav_msgs/Odometry of a WheelOdometry; the twist is in the child frame (REP-105).

    Args:
        frames: (odometry frame, base frame).
    """
    message = Odometry()
    message.header.stamp = stamp
    message.header.frame_id, message.child_frame_id = frames
    message.pose.pose.position.x, message.pose.pose.position.y = state.x, state.y
    message.pose.pose.orientation = quaternion_of(state.yaw)
    pose, twist = [0.0] * 36, [0.0] * 36
    rows = (0, 1, 5)  # x, y, yaw of the 6 by 6 matrix
    for i, row in enumerate(rows):
        for j, column in enumerate(rows):
            pose[6 * row + column] = float(state.covariance[i, j])
    twist[0], twist[35] = state.twist_variances()
    for axis in (2, 3, 4):
        pose[7 * axis] = PLANAR_VARIANCE
    for axis in (1, 2, 3, 4):
        twist[7 * axis] = PLANAR_VARIANCE
    message.pose.covariance, message.twist.covariance = pose, twist
    message.twist.twist.linear.x = state.speed
    message.twist.twist.angular.z = state.yaw_rate
    return message


@dataclass(frozen=True)
class JoyDrive(Checked, prefix="joy_"):
    """Axes and scales of the drive command.

    Attributes:
        speed_axis, steering_axis: indices into sensor_msgs/Joy.axes.
        speed: [m/s] at axis value +1; negative inverts the axis.
        steering: [rad] at axis value +1; negative inverts the axis.
    """

    speed_axis: int = number(1, min=0, integer=True)
    steering_axis: int = number(0, min=0, integer=True)
    speed: float = number(1.0, unit="m/s")
    steering: float = number(0.7854, unit="rad")

    def command(self, axes):
        """Steering [rad] and speed [m/s] for a sequence of axis values in -1..1.

        Raises:
            ValueError: too few axes, or a value that is not finite.
        """
        for axis in (self.speed_axis, self.steering_axis):
            if axis >= len(axes):
                raise ValueError(f"axis {axis} is requested, the pad has {len(axes)} axes")
            if not math.isfinite(axes[axis]):
                raise ValueError(f"axis {axis} is {axes[axis]}, must be a finite number")
        return self.steering * axes[self.steering_axis], self.speed * axes[self.speed_axis]


def refusal(**values):
    """Reason to refuse a command, or '' when all its numbers are finite."""
    for name, value in values.items():
        if not math.isfinite(value):
            return f"{name} is {value}, must be a finite number"
    return ""


class Command:
    """The last commanded steering and speed; callbacks write, the drive loop reads.

    Args:
        timeout: age [s] above which the truck stops.

    Attributes:
        timeout: the same.
    """

    def __init__(self, timeout):
        self.timeout = float(Number(above=0.0, unit="s").check("command_timeout", timeout))
        self._lock = threading.Lock()
        self._steering = self._speed = 0.0
        self._time = None

    def set(self, steering, speed, time):
        """Set a checked command with its stamp [s]."""
        with self._lock:
            self._steering, self._speed, self._time = steering, speed, time

    def stop(self):
        """Set speed 0 until the next command; the steering angle stays."""
        with self._lock:
            self._speed, self._time = 0.0, None

    def target(self, now):
        """Target at a time [s].

        Returns:
            (steering [rad], speed [m/s], expired): expired is True once, when the command has
            just become too old.
        """
        with self._lock:
            if self._time is None:
                return self._steering, 0.0, False
            # joint states lag a little behind the clock; a larger difference: the clock went back
            if -self.timeout <= now - self._time <= self.timeout:
                return self._steering, self._speed, False
            self._speed, self._time = 0.0, None
            return self._steering, 0.0, True

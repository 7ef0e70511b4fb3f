"""The node `control`: subscribes to /cmd_vel, commands four wheels and two steering hinges.

The camelCase names are public interface (imported by other nodes).
"""

import math
import threading
from dataclasses import dataclass

import rospy
from geometry_msgs.msg import Twist
from paddock_common.ackermann import Wheels
from paddock_common.nodes import start
from paddock_common.passed_time import PassedTime
from paddock_common.settings import Checked, choice, number, read
from paddock_common.waiting import flush
from std_msgs.msg import Float64

from deepracer_control import topics
from deepracer_control.ackermann import Geometry, wheel_commands

MODES = ("original", "ackermann")
DEGREES_PER_UNIT = 15.0  # steering of one unit of angular.z in original mode [deg]
MAX_STEERING_DEGREES = 60.0  # limit in original mode [deg]

controlEngines = None


@dataclass(frozen=True)
class Settings(Checked):
    """Settings of the node.

    Attributes:
        mode: "original" (wheel rad/s and steps of 15 degrees, positive to the right) or
            "ackermann" (m/s and rad/s, positive to the left).
        command_timeout: ROS time without a command after which a moving car is stopped [s]; 0: off.
        geometry: Wheel positions; ackermann mode only.
    """

    mode: str = choice("original", MODES)
    command_timeout: float = number(0.0, min=0.0, unit="s")
    geometry: Geometry = Geometry()


def settings_from_parameters() -> Settings:
    """Reads this node's private parameters.

    Raises:
        ValueError: A parameter is not a number or out of range; the message has its name.
    """
    return Settings(
        mode=rospy.get_param("~mode", Settings.mode),
        command_timeout=rospy.get_param("~command_timeout", Settings.command_timeout),
        geometry=read(Geometry, rospy.get_param),
    )


def original_steering(w):
    """Returns the hinge angle [rad, left positive] of the original's steering command.

    Args:
        w: Steering in units of 15 degrees, positive to the right; capped at 60 degrees.
    """
    degrees = max(-MAX_STEERING_DEGREES, min(MAX_STEERING_DEGREES, w * DEGREES_PER_UNIT))
    return 0.0 - math.radians(degrees)


class CarControl:
    """Converts commands to the six joint commands of the car.

    Args:
        settings: Settings; by default read from the node's private parameters.
    """

    def __init__(self, settings=None):
        self.settings = settings_from_parameters() if settings is None else settings
        self.rightRearPub = rospy.Publisher(topics.RIGHT_REAR_TOPIC, Float64, queue_size=10)
        self.leftRearPub = rospy.Publisher(topics.LEFT_REAR_TOPIC, Float64, queue_size=10)
        self.rightFrontPub = rospy.Publisher(topics.RIGHT_FRONT_TOPIC, Float64, queue_size=10)
        self.leftFrontPub = rospy.Publisher(topics.LEFT_FRONT_TOPIC, Float64, queue_size=10)
        self.leftSteeringPub = rospy.Publisher(topics.LEFT_DIRECTION_TOPIC, Float64, queue_size=10)
        self.rightSteeringPub = rospy.Publisher(
            topics.RIGHT_DIRECTION_TOPIC, Float64, queue_size=10
        )
        self.rate = rospy.Rate(10)
        self._lock = threading.RLock()
        self._speed = 0.0
        self._steering = 0.0
        self._last_command = None  # time passed [s] at the newest command, None: watchdog off
        self._closed = False  # at shutdown: zero was sent, and no command may follow
        if self.settings.command_timeout > 0.0:
            self._passed = PassedTime(self.settings.command_timeout / 4.0, self._check_timeout)
        self.sub = rospy.Subscriber(topics.COMMANDED_DATA_TOPIC, Twist, self.subscriberCb)
        rospy.on_shutdown(self._close)

    def linearDrive(self, v):
        """Sets the speed; the steering is unchanged.

        Args:
            v: Wheel speed [rad/s], the same for all four wheels; in ackermann mode the car's
                speed [m/s].
        """
        if not self._accepts(v, 0.0):
            return
        with self._lock:
            self._speed = v
            if self.settings.mode == "ackermann":
                self._publish(wheel_commands(v, self._steering, self.settings.geometry))
            else:
                self._publish_wheels(v, v, v, v)

    def angularDrive(self, w):
        """Sets the steering; the speed is unchanged.

        Args:
            w: Steering in units of 15 degrees, positive to the right, the same on both hinges; in
                ackermann mode the yaw rate [rad/s], positive to the left.
        """
        if not self._accepts(0.0, w):
            return
        with self._lock:
            self._steering = w
            if self.settings.mode == "ackermann":
                self._publish(wheel_commands(self._speed, w, self.settings.geometry))
            else:
                angle = original_steering(w)
                self._publish_steering(angle, angle)

    def drive(self, v, w):
        """Sets speed and steering, in the units of linearDrive and angularDrive."""
        if not self._accepts(v, w):
            return
        with self._lock:
            if self.settings.mode == "ackermann":
                self._speed, self._steering = v, w
                self._publish(wheel_commands(v, w, self.settings.geometry))
            else:
                self.linearDrive(v)
                self.angularDrive(w)

    def subscriberCb(self, msg):
        """Executes a geometry_msgs/Twist: linear.x and angular.z."""
        with self._lock:
            monitored = self.settings.command_timeout and msg.linear.x != 0.0
            self._last_command = self._passed() if monitored else None  # else nothing to stop
            self.drive(msg.linear.x, msg.angular.z)

    def _accepts(self, v, w):
        """Returns whether both values are finite; if not, logs it and stops the car."""
        if math.isfinite(v) and math.isfinite(w):
            return True
        name, value = ("linear.x", v) if not math.isfinite(v) else ("angular.z", w)
        rospy.logerr_throttle(
            1.0,
            f"command refused: {name} is {value}; it must be a finite "
            "number. The car is stopped until the next valid command.",
        )
        self._stop()
        return False

    def _stop(self):
        """Commands zero speed and straight wheels."""
        with self._lock:
            self._speed = self._steering = 0.0
            self._publish(Wheels())

    def _close(self):
        """Stops the car for the last time: a command that is being processed must not follow."""
        with self._lock:
            self._stop()
            self._closed = True
        flush(
            self.rightRearPub,
            self.leftRearPub,
            self.rightFrontPub,
            self.leftFrontPub,
            self.leftSteeringPub,
            self.rightSteeringPub,
        )

    def _check_timeout(self):
        """Stops a moving car once when no command was received for command_timeout of ROS time."""
        if self._last_command is None:  # at each message on /clock: most often
            return
        with self._lock:
            last = self._last_command
            if last is not None and self._passed() - last >= self.settings.command_timeout:
                self._last_command = None
                rospy.logwarn(f"no command for {self.settings.command_timeout:g} s: car stopped")
                self._stop()

    def _publish(self, commands):
        self._publish_wheels(
            commands.right_rear, commands.left_rear, commands.right_front, commands.left_front
        )
        self._publish_steering(commands.left_steering, commands.right_steering)

    def _publish_wheels(self, right_rear, left_rear, right_front, left_front):
        self._send(
            (self.rightRearPub, right_rear),
            (self.leftRearPub, left_rear),
            (self.rightFrontPub, right_front),
            (self.leftFrontPub, left_front),
        )

    def _publish_steering(self, left, right):
        self._send((self.leftSteeringPub, left), (self.rightSteeringPub, right))

    def _send(self, *commands):
        """Publishes (publisher, value); rospy closes the topics after the shutdown."""
        if not self._closed:
            for publisher, value in commands:
                publisher.publish(Float64(value))


def main():
    """Runs the node `control` until ROS shuts down."""
    global controlEngines
    controlEngines = start("control", CarControl)
    rospy.spin()


if __name__ == "__main__":
    main()

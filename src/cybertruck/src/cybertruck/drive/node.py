"""The drive node: settings, commands in, joints, odometry and TF out.

The node `drive`: commands in, wheels out; joint states in, odometry and TF out. Everything happens
once per message of the bridge's joint states (every 8 ms of simulated time); if they stop, a timer
stops the wheels.
"""

import threading
from dataclasses import dataclass

import rospy
import tf2_ros
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from paddock_common.geometry import transform_of
from paddock_common.nodes import run
from paddock_common.settings import Checked, choice, flag, number, read, text
from paddock_common.waiting import flush
from sensor_msgs.msg import JointState, Joy
from std_msgs.msg import Float64MultiArray, Int32

from cybertruck.drive import commands
from cybertruck.drive.commands import Command, JoyDrive, refusal
from cybertruck.drive.model import CyberModel, RateLimiter, TruckGeometry
from cybertruck.drive.odometry import Errors, WheelOdometry, ticks
from cybertruck.msg import CyberDriveStamped

ODOM_SOURCES = ("wheels", "ground_truth")


@dataclass(frozen=True)
class Settings(Checked):
    """Parameters of the node.

    Attributes:
        command_timeout: Age of a command above which the truck stops [s].
        start_x, start_y, start_yaw: Pose that wheel odometry starts from [m], [rad].
        odom_source: "wheels" or "ground_truth".
        odom_frame, base_frame: Frames of /odom and TF.
        joy: Whether /joy drives.
    """

    command_timeout: float = number(0.5, above=0.0, unit="s")
    start_x: float = number(0.0, unit="m")
    start_y: float = number(0.0, unit="m")
    start_yaw: float = number(0.0, unit="rad")
    odom_source: str = choice("wheels", ODOM_SOURCES)
    odom_frame: str = text("odom")
    base_frame: str = text("base_footprint")
    joy: bool = flag(False)


ROBOT = "/cybertruck"
LONGEST_STEP = 0.1  # [s] for the rate limits, also after a longer gap between joint states
CHECK_PERIOD = 0.1  # maximum time between checks of the joint states' age [s]


class Drive:
    """The drive node.

    Raises:
        ValueError: a parameter is wrong; names it, its value and what is valid.
    """

    def __init__(self):
        settings = read(Settings, rospy.get_param)
        self._model = CyberModel(read(TruckGeometry, rospy.get_param))
        self._limiter = RateLimiter(self._model.geometry)
        self._command = Command(settings.command_timeout)
        start = settings.start_x, settings.start_y, settings.start_yaw
        self._odometry = WheelOdometry(self._model, start, read(Errors, rospy.get_param))
        self._source = settings.odom_source
        self._frames = settings.odom_frame, settings.base_frame
        self._time = self._measured = None  # stamps of the last and the last valid joint states [s]
        self._received, self._timed_out = None, False  # ROS time of their arrival [s]
        self._lock = threading.Lock()  # joint states and timer have different threads
        self._is_shut_down = False  # zero was sent, and nothing may follow it
        self._publish_to()
        self._subscribe(read(JoyDrive, rospy.get_param, "~joy_") if settings.joy else None)
        rospy.on_shutdown(self._shut_down)
        rospy.Timer(
            rospy.Duration(min(CHECK_PERIOD, self._command.timeout)),
            self._check_joint_states,
            reset=True,
        )

    def _publish_to(self):
        def publisher(topic, message_type):
            return rospy.Publisher(topic, message_type, queue_size=10, tcp_nodelay=True)

        self._steering_out = publisher(f"{ROBOT}/steering_controller/command", Float64MultiArray)
        self._axle_out = publisher(f"{ROBOT}/axle_controller/command", Float64MultiArray)
        self._joints_out = publisher("/joint_states", JointState)
        self._odom_out = publisher("/odom", Odometry)
        self._pose_out = publisher("/pose", PoseStamped)
        self._encoders_out = {
            "front_left_wheel_joint": publisher("/odo_fl", Int32),
            "front_right_wheel_joint": publisher("/odo_fr", Int32),
        }
        self._broadcaster = tf2_ros.TransformBroadcaster()

    def _subscribe(self, joy):
        # Commands: only the newest is used. Measurements: a short queue, so that none is dropped.
        for topic, message_type, callback, queue_size in (
            ("/cmd_vel", Twist, self._twist, 1),
            ("/cmd_cyberdrive", CyberDriveStamped, self._cyberdrive, 1),
            ("/joy", Joy, lambda message: self._joy(joy, message), joy is not None and 1),
            (f"{ROBOT}/joint_states", JointState, self._joints, 5),
            (
                "/ground_truth/odom",
                Odometry,
                self._publish_odometry,
                self._source == "ground_truth" and 5,
            ),
        ):
            if queue_size:
                rospy.Subscriber(
                    topic, message_type, callback, queue_size=queue_size, tcp_nodelay=True
                )

    def _now(self):
        """ROS time, or that of the last joint states if it is later: /clock comes by another
        connection, behind them on a busy machine."""
        return max(rospy.get_time(), self._time or 0.0)

    # commands ---------------------------------------------------------------------------------
    def _twist(self, message):
        linear, angular = message.linear.x, message.angular.z
        if not self._refused("/cmd_vel", refusal(**{"linear.x": linear, "angular.z": angular})):
            self._command.set(*self._model.from_twist(linear, angular), self._now())

    def _cyberdrive(self, message):
        drive = message.drive
        if self._refused(
            "/cmd_cyberdrive", refusal(steering_angle=drive.steering_angle, speed=drive.speed)
        ):
            return
        now = self._now()
        stamp = min(message.header.stamp.to_sec() or now, now)
        self._command.set(*self._model.limit(drive.steering_angle, drive.speed), stamp)

    def _joy(self, joy, message):
        try:
            steering, speed = joy.command(message.axes)
        except ValueError as error:
            self._refused("/joy", str(error))
        else:
            self._command.set(*self._model.limit(steering, speed), self._now())

    def _refused(self, topic, reason):
        if reason:
            self._command.stop()
            rospy.logerr_throttle(
                1.0, f"{topic} refused: {reason}. The truck stops until the next valid command."
            )
        return bool(reason)

    # joint states -----------------------------------------------------------------------------
    def _joints(self, message):
        with self._lock:
            if not self._is_shut_down:
                self._follow(message)

    def _follow(self, message):
        """Update commands and odometry by a message of joint states; the caller holds the lock."""
        measured = wheels = None
        try:
            measured, wheels = commands.measured(message)
        except ValueError as error:
            rospy.logerr_throttle(
                1.0, f"{ROBOT}/joint_states cannot be used: {error}. The truck brakes."
            )
        now = message.header.stamp.to_sec()
        self._received, self._timed_out = max(rospy.get_time(), now), False
        reset = self._reset_reason(now, measured)
        if reset:
            rospy.loginfo(f"{reset}: odometry restarts")
            self._odometry.reset()
            self._limiter.reset()
            self._time = None
        if reset or measured is None:
            self._command.stop()
        period = 0.0 if self._time is None else min(now - self._time, LONGEST_STEP)
        self._time = now
        self._drive(now, period)
        if measured is None:
            return
        self._measured = now
        self._odometry.update(measured)
        self._joints_out.publish(message)
        for name, publisher in self._encoders_out.items():
            publisher.publish(ticks(wheels[name]))
        if self._source == "wheels":
            self._publish_odometry(
                commands.odometry(message.header.stamp, self._frames, self._odometry)
            )

    def _reset_reason(self, now, measured):
        """Reason why joint states stamped `now` [s] indicate a reset of the simulation, or ''."""
        if self._time is not None and now < self._time:
            return f"time went back from {self._time:g} s to {now:g} s"
        if (
            measured is not None
            and self._measured is not None
            and self._odometry.jumped(measured, now - self._measured)
        ):
            return "the rear wheels jumped, the truck was reset"
        return ""

    def _check_joint_states(self, _event):
        """Stop the wheels when there were no joint states for command_timeout."""
        with self._lock:
            now = rospy.get_time()
            if self._received is None or self._is_shut_down:  # no command was published yet
                return
            self._received = min(self._received, now)  # time may have gone back
            if now - self._received <= self._command.timeout:
                return
            if not self._timed_out:
                rospy.logerr(
                    f"{ROBOT}/joint_states: no message for "
                    f"{self._command.timeout:g} s: the truck stops"
                )
            self._timed_out = True
            self._limiter.speed = 0.0  # with new joint states it starts from standstill
            self._axle_out.publish(Float64MultiArray(data=(0.0, 0.0)))

    def _shut_down(self):
        """Stop the wheels at shutdown; nothing follows, rospy closes the topics next."""
        with self._lock:
            self._is_shut_down = True
            if self._time is not None:
                self._axle_out.publish(Float64MultiArray(data=(0.0, 0.0)))
        flush(self._axle_out)

    def _drive(self, now, period):
        """Publish hinge and wheel commands within the limits after a period [s]."""
        steering, speed, expired = self._command.target(now)
        if expired:
            rospy.logwarn("the last command is older than command_timeout: the truck stops")
        targets = self._model.wheels(*self._limiter.advance(steering, speed, period))
        self._steering_out.publish(
            Float64MultiArray(data=(targets.left_steering, targets.right_steering))
        )
        self._axle_out.publish(Float64MultiArray(data=(targets.left_rear, targets.right_rear)))

    def _publish_odometry(self, message):
        """Publish one odometry message as /odom, /pose and TF."""
        message.header.frame_id, message.child_frame_id = self._frames
        self._odom_out.publish(message)
        self._pose_out.publish(PoseStamped(header=message.header, pose=message.pose.pose))
        self._broadcaster.sendTransform(transform_of(message))


def main():
    """Run the node until ROS shuts down; exit with 1 and the reason if it cannot start."""
    run("drive", Drive)

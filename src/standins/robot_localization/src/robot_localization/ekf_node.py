"""The nodes ekf_localization_node and ukf_localization_node: messages, diagnostics, transforms."""

import math
import threading
import time

import numpy as np
import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import Updater
from geometry_msgs.msg import (
    AccelWithCovarianceStamped,
    PoseWithCovarianceStamped,
    TwistWithCovarianceStamped,
    Vector3,
)
from nav_msgs.msg import Odometry
from std_srvs.srv import Empty, EmptyResponse

from paddock_common import nodes
from robot_localization import options, sensors, srv
from robot_localization.ekf import (
    ACCELERATION,
    ANGLES,
    NAMES,
    POSE,
    POSITION,
    RATES,
    SIZE,
    TWIST,
    Ekf,
    Fusion,
)
from robot_localization.frames import (
    Frames,
    Transform,
    matrix,
    quaternion_from_angles,
    to_quaternion,
)
from robot_localization.messages import ImuReading, OdometryBytes, TransformBytes
from robot_localization.sensors import Reader, configuration_warnings
from robot_localization.ukf import Ukf

PERIOD = 1.0  # wall time between two messages [s]
LARGE = 1e3  # a variance from which on a value is not known


class Diagnostics:
    """Warnings about the sensors, rate of the estimates, outliers."""

    def __init__(self, options, sensors):
        self._warnings = configuration_warnings(sensors, options.two_d_mode)
        self._frequency = options.frequency
        self._count = self._outliers = 0
        self._since = self._due = time.monotonic()
        self._rate = 0.0
        self._unknown = []
        self._ignored = {}  # key -> text about messages since the last publication
        self._updater = Updater()
        self._updater.setHardwareID("none")
        self._updater.add("Filter diagnostic updater", self._state)
        self._updater.add("odometry/filtered topic status", self._topic)

    def ignored(self, names, text):
        """Reports that a message was ignored because of its stamp.

        Args:
            names: of the sensor, or of each part of its messages.
        """
        for name in names:
            self._ignored[f"{name}_timestamp"] = text

    def update(self, ekf, outliers):
        """Counts an estimate, and publishes when it is time."""
        self._count += ekf.initialized
        self._outliers += outliers
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + PERIOD
        self._rate = self._count / max(now - self._since, 1e-9)
        self._unknown = [NAMES[i] for i in range(SIZE) if not ekf.covariance[i, i] < LARGE]
        self._count, self._since = 0, now
        self._updater.force_update()
        self._outliers = 0
        self._ignored = {}

    def _state(self, status):
        level = DiagnosticStatus.OK
        for error, name, text in self._warnings:
            level = max(level, DiagnosticStatus.ERROR if error else DiagnosticStatus.WARN)
            status.add(f"{name}_configuration", text)
        for key, text in self._ignored.items():
            level = max(level, DiagnosticStatus.WARN)
            status.add(key, text)
        if self._outliers:
            level = max(level, DiagnosticStatus.WARN)
            status.add("outliers", f"{self._outliers} measurements were skipped as outliers")
        if self._unknown:
            level = max(level, DiagnosticStatus.WARN)
            status.add("covariance", f"hardly known: {', '.join(self._unknown)}")
        status.summary(level, "ok" if level == DiagnosticStatus.OK else "see the values")
        return status

    def _topic(self, status):
        status.summary(DiagnosticStatus.OK, f"{self._rate:.1f} per second of wall time")
        status.add("wanted", f"{self._frequency:g} Hz of ROS time")
        status.add("ROS time", f"{rospy.get_time():.3f}")
        return status


STEEP = 0.5 * math.pi - 1e-3  # pitch from which on angles are not those of their rotation [rad]


def orientation_of(ekf):
    """Quaternion (x, y, z, w) of the robot in the world."""
    angles = ekf.state[ANGLES].tolist()
    if abs(angles[1]) < STEEP:
        return quaternion_from_angles(*angles)
    return to_quaternion(matrix(*angles))


def acceleration(ekf, robot, stamp, rates_change, step):
    """geometry_msgs/AccelWithCovarianceStamped of an Ekf.

    Args:
        robot: Name of its frame.
        rates_change: (3,) change of the angular rates [rad/s^2].
        step: Time between the two rates that it is made of [s].
    """
    message = AccelWithCovarianceStamped()
    message.header.frame_id, message.header.stamp = robot, stamp
    message.accel.accel.linear = Vector3(*ekf.state[ACCELERATION].tolist())
    message.accel.accel.angular = Vector3(*rates_change.tolist())
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = ekf.covariance[ACCELERATION, ACCELERATION]
    covariance[3:, 3:] = 2.0 * ekf.covariance[RATES, RATES] / step**2
    message.accel.covariance = covariance.ravel().tolist()
    return message


TYPES = {
    "odom": Odometry,
    "pose": PoseWithCovarianceStamped,
    "twist": TwistWithCovarianceStamped,
    "imu": ImuReading,
}
WARN_PERIOD = 5.0  # between two equal warnings [s]


class EkfNode:
    """Subscribes to the sensors, publishes the estimate.

    Args:
        name: Of the node, for its messages.

    Raises:
        ValueError: A required parameter is wrong.
    """

    def __init__(self, name):
        parameters = rospy.get_param("~", {})
        prefix_at = rospy.search_param("tf_prefix")
        self._options, notes = options.read(
            parameters, str(rospy.get_param(prefix_at)) if prefix_at else ""
        )
        arrays, more = options.read_arrays(parameters)
        if name.startswith("ukf"):
            unscented, wrong = options.read_unscented(parameters)
            arrays.update(unscented)
            more += wrong
        inputs, notes_of_sensors = sensors.read(parameters)
        for note in notes + more + notes_of_sensors:
            rospy.logwarn("%s: %s", name, note)
        if not inputs:
            rospy.logwarn("%s: no sensor is configured; nothing will be published", name)
        option, self._name = self._options, name
        self._lock = threading.RLock()
        arrays["scaled_noise"] = option.dynamic_process_noise_covariance
        self._ekf = Ukf(**arrays) if name.startswith("ukf") else Ekf(**arrays)
        self._ekf.time = rospy.get_time()
        self._fusion = Fusion(
            self._ekf,
            option.sensor_timeout,
            option.predict_to_current_time,
            option.history_length if option.smooth_lagged_data else None,
        )
        self._frames = Frames(option.transform_timeout)
        self._reader = Reader(option, self._frames, self._ekf, self._fusion.add)
        self._enabled, self._on = not option.disabled_at_startup, True
        self._published = rospy.Time()
        self._last_stamp, self._ignore_until = {}, 0  # [ns]
        self._last_rates, self._last_update = np.zeros(3), None
        self._diagnostics = Diagnostics(option, inputs) if option.print_diagnostics else None

        self._odometry = rospy.Publisher("odometry/filtered", Odometry, queue_size=20)
        self._acceleration = (
            rospy.Publisher("accel/filtered", AccelWithCovarianceStamped, queue_size=20)
            if option.publish_acceleration
            else None
        )
        self._broadcaster = tf2_ros.TransformBroadcaster()
        world, robot = option.world_frame, option.base_link_frame_output
        self._estimate = OdometryBytes(world, robot)
        if option.invert_tf:
            self._frame = TransformBytes(robot, world)
        else:
            child = robot if world == option.odom_frame else option.odom_frame
            self._frame = TransformBytes(world, child)
        self._interfaces = [
            rospy.Subscriber("set_pose", PoseWithCovarianceStamped, self._set_pose, queue_size=1),
            rospy.Service("set_pose", srv.SetPose, self._set_pose_service),
            rospy.Service("~enable", Empty, self._enable),
            rospy.Service("~toggle", srv.ToggleFilterProcessing, self._toggle),
        ] + [
            rospy.Subscriber(
                sensor.topic,
                TYPES[sensor.input_type],
                self._process,
                sensor,
                queue_size=sensor.queue_size,
                tcp_nodelay=sensor.nodelay,
            )
            for sensor in inputs
        ]
        # reset: a clock that is set back must not stop the timer.
        self._timer = rospy.Timer(
            rospy.Duration(1.0 / option.frequency), lambda _: self.update(), reset=True
        )

    def _process(self, message, sensor):
        stamp = message.header.stamp.to_nsec()
        with self._lock:
            if stamp <= self._ignore_until:
                self._report_ignored(
                    [sensor.name],
                    f"a message stamped {1e-9 * stamp:.3f} s is not later than the last reset of "
                    "the filter and is ignored; is its stamp empty?",
                )
                return
            last = self._last_stamp.get(sensor.name)
            if last is not None and stamp < last:
                if not self._options.reset_on_time_jump:
                    rospy.logwarn_throttle(
                        WARN_PERIOD,
                        f"{self._name}: a message of {sensor.name} is older than the one before "
                        "and is ignored; was the clock set back? reset_on_time_jump restarts "
                        "the filter",
                    )
                    self._report_ignored(
                        sensor.parts(),
                        f"a message stamped {1e-9 * stamp:.3f} s is older than the one before "
                        "and is ignored",
                    )
                    return
                self._reset()
            self._last_stamp[sensor.name] = stamp
            self._reader.process(sensor, message)

    def _report_ignored(self, names, text):
        if self._diagnostics:
            self._diagnostics.ignored(names, text)

    def _reset(self):
        self._fusion.clear()
        self._ekf.reset()
        self._reader.clear()
        self._frames.clear()
        self._last_stamp.clear()
        self._ignore_until, self._published = 0, rospy.Time()
        self._last_update = None
        rospy.logwarn("%s: the clock was set back; the filter restarts", self._name)

    def _set_pose(self, message):
        with self._lock:
            self._fusion.clear()
            self._reader.clear()
            self._ignore_until = message.header.stamp.to_nsec()
            measured = self._reader.pose_in_world(message)
            if measured is None:
                rospy.logerr("%s: set_pose: its frame is not known; nothing is set", self._name)
                return
            self._ekf.state = measured.value.copy()
            self._ekf.covariance = 1e-6 * np.eye(len(measured.value))
            self._ekf.covariance[:6, :6] = measured.covariance[:6, :6]
            self._ekf.time = rospy.get_time()
        rospy.loginfo("%s: set to the pose (%.3f, %.3f)", self._name, *measured.value[:2])

    def _set_pose_service(self, request):
        self._set_pose(request.pose)
        return srv.SetPoseResponse()

    def _enable(self, _):
        self._enabled = True
        return EmptyResponse()

    def _toggle(self, request):
        changed, self._on = request.on != self._on, request.on
        return srv.ToggleFilterProcessingResponse(status=changed)

    def update(self):
        """Processes the received messages and publishes the estimate."""
        if not self._enabled:
            rospy.loginfo_once(f"{self._name}: waits for its service enable")
            return
        now = rospy.get_time()
        with self._lock:
            if self._on:
                self._fusion.advance(now)
                self._differentiate(now)
            else:
                self._fusion.clear()
                if self._ekf.initialized:
                    self._ekf.time = now
            if self._ekf.initialized:
                self._publish()
            if self._diagnostics:
                self._diagnostics.update(self._ekf, self._fusion.outliers())

    def _differentiate(self, now):
        if not self._ekf.initialized:
            return
        rates = self._ekf.state[9:12].copy()
        if self._last_update is not None and now > self._last_update:
            self._reader.rates_step = now - self._last_update
            self._reader.rates_change = (rates - self._last_rates) / self._reader.rates_step
        if self._last_update is None or now != self._last_update:
            self._last_rates, self._last_update = rates, now

    def _publish(self):
        option, ekf = self._options, self._ekf
        stamp = rospy.Time.from_sec(ekf.time)
        if not np.isfinite(ekf.state).all():
            rospy.logerr_throttle(
                WARN_PERIOD, f"{self._name}: the estimate is not finite; look at the covariances"
            )
        if stamp <= self._published and not option.permit_corrected_publication:
            return
        self._published = stamp
        position, orientation = ekf.state[POSITION].tolist(), orientation_of(ekf)
        if self._odometry.get_num_connections():
            covariances = ekf.covariance[POSE, POSE], ekf.covariance[TWIST, TWIST]
            twist = ekf.state[TWIST].tolist()
            self._odometry.publish(
                self._estimate.fill(stamp, position, orientation, twist, covariances)
            )
        if self._acceleration:
            robot, change = option.base_link_frame_output, self._reader.rates_change
            self._acceleration.publish(
                acceleration(ekf, robot, stamp, change, self._reader.rates_step)
            )
        if option.publish_tf:
            self._publish_frame(stamp, position, orientation)

    def _publish_frame(self, stamp, position, orientation):
        option = self._options
        in_map = option.world_frame != option.odom_frame
        if option.invert_tf or in_map:
            pose = Transform(matrix(*self._ekf.state[ANGLES]), self._ekf.state[POSITION])
            if option.invert_tf:
                pose = pose.inverse()
            else:
                odom = self._frames.find(option.base_link_frame, option.odom_frame, stamp)
                if odom is None:
                    return
                pose = pose.of(odom)
            position, orientation = pose.translation.tolist(), to_quaternion(pose.rotation)
        later = stamp + rospy.Duration(option.transform_time_offset)
        self._broadcaster.pub_tf.publish(self._frame.fill(later, position, orientation))


def main(name="ekf_localization_node"):
    nodes.run(name, lambda: EkfNode(name))

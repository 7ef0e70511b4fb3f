"""Messages of the sensors as measurements."""

import numpy as np

from robot_localization.estimate.state import ACCELERATION, ANGLES, POSE, RATES, TWIST, Measurement
from robot_localization.frames import to_transform
from robot_localization.inputs.prepare import PoseInput, acceleration, gravity_of, twist
from robot_localization.rotation import IDENTITY, from_quaternion, matrix


class Reader:
    """Turns messages into the filter's frames and hands them on.

    Args:
        options: Options.
        frames: Frames.
        ekf: Ekf, for turn rates and attitude.
        add: Function that takes a Measurement.

    Attributes:
        rates_change: (3,) change of the turn rates [rad/s^2].
        rates_step: Time that it is of [s].
    """

    def __init__(self, options, frames, ekf, add):
        self._options, self._frames, self._ekf, self._add = options, frames, ekf, add
        self._poses = {}
        self.rates_change, self.rates_step = np.zeros(3), 1.0
        self._takers = {
            "odom": self._odometry,
            "pose": self._pose,
            "twist": self._twist,
            "imu": self._imu,
        }

    def clear(self):
        """Forgets first and last poses."""
        self._poses.clear()

    def take(self, sensor, message):
        """Takes a message of a Sensor."""
        self._takers[sensor.kind](sensor, message)

    def pose_in_world(self, message):
        """Numbers of a geometry_msgs/PoseWithCovarianceStamped, or None without its frame."""
        frame = self._frames.find(
            self._options.world_frame, message.header.frame_id, message.header.stamp
        )
        if frame is None:
            return None
        pose = to_transform(message.pose.pose.position, message.pose.pose.orientation)
        covariance = _square(message.pose.covariance, 6)
        numbers = PoseInput([True] * 6).take(0.0, pose, covariance, frame)
        return numbers.flatten() if self._options.two_d_mode else numbers

    def _memory(self, sensor):
        if sensor.name not in self._poses:
            self._poses[sensor.name] = PoseInput(
                sensor.used[POSE], sensor.differential, sensor.relative
            )
        return self._poses[sensor.name]

    def _send(self, sensor, part, stamp, numbers):
        if numbers is None:
            return
        if self._options.two_d_mode:
            numbers.flatten()
        threshold = sensor.thresholds[(POSE, TWIST, ACCELERATION).index(part)]
        self._add(Measurement(sensor.name, stamp.to_sec(), *numbers.pick(), threshold))

    def _odometry(self, sensor, message):
        if sensor.uses(POSE):
            child = message.child_frame_id if sensor.child_frame else None
            self._take_pose(sensor, message.header, message.pose, child)
        if sensor.uses(TWIST):
            self._take_twist(sensor, message.header.stamp, message.child_frame_id, message.twist)

    def _pose(self, sensor, message):
        self._take_pose(sensor, message.header, message.pose, None)

    def _twist(self, sensor, message):
        self._take_twist(sensor, message.header.stamp, message.header.frame_id, message.twist)

    def _take_pose(self, sensor, header, value, child):
        option, find, stamp = self._options, self._frames.find, header.stamp
        memory = self._memory(sensor)
        frame = IDENTITY
        if not sensor.differential:
            frame = find(option.world_frame, header.frame_id, stamp)
        base = find(child, option.base_link_frame, stamp) if child else IDENTITY
        if frame is None or base is None:
            return
        pose = to_transform(value.pose.position, value.pose.orientation)
        numbers = memory.take(stamp.to_sec(), pose, _square(value.covariance, 6), frame, base)
        self._send(sensor, POSE, stamp, numbers)

    def _take_twist(self, sensor, stamp, frame, value):
        mount = self._frames.find(self._options.base_link_frame, frame, stamp)
        if mount is None:
            return
        numbers = twist(
            _vector(value.twist.linear),
            _vector(value.twist.angular),
            _square(value.covariance, 6),
            sensor.used[TWIST],
            mount,
            self._ekf.state[RATES],
        )
        self._send(sensor, TWIST, stamp, numbers)

    def _imu(self, sensor, message):
        stamp = message.header.stamp
        mount = self._frames.find(self._options.base_link_frame, message.header.frame_id, stamp)
        if mount is None:
            return
        turned = message.orientation
        attitude = from_quaternion(turned.x, turned.y, turned.z, turned.w)
        if sensor.uses(POSE) and not _absent(message.orientation_covariance):
            covariance = _square(message.orientation_covariance, 3)
            numbers = self._memory(sensor).take_attitude(
                stamp.to_sec(), attitude, covariance, mount
            )
            self._send(sensor, POSE, stamp, numbers)
        if sensor.uses(TWIST) and not _absent(message.angular_velocity_covariance):
            covariance = np.zeros((6, 6))
            covariance[3:, 3:] = _square(message.angular_velocity_covariance, 3)
            rates = _vector(message.angular_velocity)
            numbers = twist(np.zeros(3), rates, covariance, sensor.used[TWIST], mount)
            self._send(sensor, TWIST, stamp, numbers)
        if sensor.uses(ACCELERATION) and not _absent(message.linear_acceleration_covariance):
            self._take_acceleration(sensor, message, attitude, mount)

    def _take_acceleration(self, sensor, message, attitude, mount):
        measured = _vector(message.linear_acceleration)
        if sensor.remove_gravity:
            if _absent(message.orientation_covariance):
                attitude = matrix(*self._ekf.state[ANGLES]) @ mount.rotation
            elif sensor.relative:
                attitude = attitude @ mount.rotation
            measured = measured - gravity_of(attitude, self._options.gravitational_acceleration)
        numbers = acceleration(
            measured,
            _square(message.linear_acceleration_covariance, 3),
            sensor.used[ACCELERATION],
            mount,
            self._ekf.state[RATES],
            self.rates_change,
        )
        self._send(sensor, ACCELERATION, message.header.stamp, numbers)


def _vector(value):
    return np.array((value.x, value.y, value.z))


def _square(values, size):
    return np.array(values, float).reshape(size, size)


def _absent(covariance):
    """Whether an IMU says that it does not measure something: -1 as the first variance."""
    return abs(covariance[0] + 1.0) < 1e-9

"""Messages to measurements: one correction for a message is the same as one for each of its parts.

The reference is the filter by its formulas alone, with matrices, one part after the other.
"""

import io
import math
from types import SimpleNamespace

import numpy as np
import pytest
import rospy
from nav_msgs.msg import Odometry
from robot_localization import frames, options, prepare, sensors
from robot_localization.ekf import ACCELERATION, POSE, TWIST, Ekf, Fusion, advance
from robot_localization.frames import IDENTITY, Transform, matrix, quaternion_from_angles
from robot_localization.messages import ImuReading, covariance
from sensor_msgs.msg import Imu

PITCH, YAW, YAW_RATE = 4, 5, 11
TILTED = Transform(matrix(0.1, -0.2, 1.2), np.array((0.3, 0.1, 0.2)))
MOUNTS = {
    "base_link": IDENTITY,
    "tilted": TILTED,
    "turned": Transform(matrix(0, 0, 1.5), TILTED[1]),
}


class Reference:
    """Predict and correct as in the textbook, in Joseph's form, without any shortcut."""

    def __init__(self, noise):
        self.state, self.covariance, self.noise = np.zeros(15), 1e-9 * np.eye(15), noise
        self.time = None

    def process(self, time, index, value, noise, threshold=math.inf):
        """Processes a measurement; whether it was no outlier."""
        if self.time is None:
            self.state[index], self.covariance[np.ix_(index, index)] = value, noise
            self.time = time
            return True
        if time > self.time:
            state, jacobian = advance(self.state, time - self.time)
            self.covariance = jacobian @ self.covariance @ jacobian.T + self.noise * (
                time - self.time
            )
            self.state, self.time = state, time
        rows = np.eye(15)[index]
        innovation = value - rows @ self.state
        angle = np.isin(index, (3, 4, 5))
        innovation[angle] = np.remainder(innovation[angle] + math.pi, 2 * math.pi) - math.pi
        spread = rows @ self.covariance @ rows.T + noise
        if innovation @ np.linalg.solve(spread, innovation) >= threshold**2:
            return False
        gain = np.linalg.solve(spread, rows @ self.covariance).T
        rest = np.eye(15) - gain @ rows
        self.covariance = rest @ self.covariance @ rest.T + gain @ noise @ gain.T
        self.state = self.state + gain @ innovation
        self.state[3:6] = np.remainder(self.state[3:6] + math.pi, 2 * math.pi) - math.pi
        return True


def test_the_derivative_is_that_of_the_prediction():
    rng = np.random.default_rng(1)
    for _ in range(20):
        state, step, tiny = rng.normal(0.0, 0.5, 15), rng.uniform(0.001, 0.2), 1e-6
        _, jacobian = advance(state, step)
        for column in range(15):
            change = np.zeros(15)
            change[column] = tiny
            after, before = advance(state + change, step)[0], advance(state - change, step)[0]
            assert jacobian[:, column] == pytest.approx((after - before) / (2 * tiny), abs=1e-7)


def config(*places):
    return [place in places for place in range(15)]


FULL_IMU = {"imu0": "imu", "imu0_config": config(3, 4, 5, 9, 10, 11, 12, 13, 14)}
PLANE_IMU = {"imu0": "imu", "imu0_config": config(5, 11, 12), "two_d_mode": True}


def reading(time, rng, frame, scale):
    """Imu of a robot that turns, nods and accelerates, with noise."""
    message = Imu()
    message.header.stamp, message.header.frame_id = rospy.Time.from_sec(time), frame
    angles = 0.05 * math.sin(time), 0.08 * math.cos(2.0 * time), 0.9 * time + rng.normal(0.0, 0.01)
    q, w, a = message.orientation, message.angular_velocity, message.linear_acceleration
    q.x, q.y, q.z, q.w = quaternion_from_angles(*angles)
    w.x, w.y, w.z = rng.normal((0.0, 0.0, 0.9), 0.05).tolist()
    a.x, a.y, a.z = rng.normal((0.1, 0.2, 9.8), 0.3).tolist()
    message.orientation_covariance = (scale * np.diag((1.0, 2.0, 3.0))).ravel().tolist()
    message.angular_velocity_covariance = (scale * np.diag((2.0, 3.0, 1.0))).ravel().tolist()
    message.linear_acceleration_covariance = (scale * np.diag((9.0, 7.0, 8.0))).ravel().tolist()
    buffer = io.BytesIO()
    message.serialize(buffer)
    return ImuReading().deserialize(buffer.getvalue())


def reader_of(parameters):
    """(Reader, its Fusion, its first Sensor), with static frames."""
    option, _ = options.read(parameters)
    (sensor, *_), _ = sensors.read(parameters)
    fusion = Fusion(Ekf(), option.sensor_timeout)
    known = {**MOUNTS, "odom": IDENTITY}  # all in their target frames
    found = SimpleNamespace(find=lambda _target, source, _stamp: known.get(source))
    return sensors.Reader(option, found, fusion.ekf, fusion.add), fusion, sensor


def parts_of(message, sensor, planar, rates):
    """StateValues of attitude, rates and acceleration of a message."""
    mount = MOUNTS[message.header.frame_id]
    of_attitude, of_rates, of_force = (
        np.reshape(covariance(data), (3, 3)) for data in message.covariances
    )
    used, spread = sensor.used, np.zeros((6, 6))
    spread[3:, 3:] = of_rates
    memory = prepare.PoseInput(used[POSE])
    attitude = frames.from_quaternion(*message.attitude)
    yield memory.process_attitude(0.0, attitude, of_attitude, mount)
    yield prepare.twist(np.zeros(3), np.array(message.rates), spread, used[TWIST], mount)
    force = np.array(message.force)
    yield prepare.acceleration(force, of_force, used[ACCELERATION], mount, rates, np.zeros(3))


@pytest.mark.parametrize("frame", ["base_link", "turned", "tilted"])
@pytest.mark.parametrize("parameters", [FULL_IMU, PLANE_IMU])
@pytest.mark.parametrize("changing", [False, True])
def test_a_message_at_once_is_as_its_parts_one_by_one(parameters, frame, changing):
    rng, planar = np.random.default_rng(4), parameters.get("two_d_mode", False)
    reader, fusion, sensor = reader_of(parameters)
    reference = Reference(fusion.ekf._noise)
    for count in range(400):
        time = 1.0 + 0.005 * count
        message = reading(time, rng, frame, 1e-4 * (1.0 + 0.5 * changing * (count % 3)))
        rates = reference.state[9:12].copy()
        reader.process(sensor, message)
        fusion.advance(time)
        for values in parts_of(message, sensor, planar, rates):
            reference.process(
                message.header.stamp.to_sec(), *(values.flatten() if planar else values).select()
            )
        assert fusion.ekf.state == pytest.approx(reference.state, abs=1e-9)
    assert fusion.ekf.covariance == pytest.approx(reference.covariance, abs=1e-9)
    assert fusion.ekf.state[YAW_RATE] != 0.0
    assert (fusion.ekf.state[PITCH] == pytest.approx(0.0, abs=1e-9)) == planar


def measurements_of(parameters, message, initialized=True):
    """What a Reader passes on of a message."""
    reader, fusion, sensor = reader_of(parameters)
    fusion.ekf.initialized = initialized
    added = []
    reader._add = added.append
    reader.process(sensor, message)
    return added


def test_a_message_is_one_correction_unless_that_is_another():
    message = reading(1.0, np.random.default_rng(1), "base_link", 1e-4)
    assert len(measurements_of(PLANE_IMU, message)) == 1
    # The first measurement sets the state, the others of its message correct it.
    assert len(measurements_of(PLANE_IMU, message, initialized=False)) == 3
    threshold = {**PLANE_IMU, "imu0_twist_rejection_threshold": 2.0}
    assert len(measurements_of(threshold, message)) == 3
    message.force = (math.nan, 0.0, 9.8)
    assert len(measurements_of(PLANE_IMU, message)) == 3
    message.force = (1e200, 0.0, 9.8)
    assert len(measurements_of(PLANE_IMU, message)) == 3
    message.covariances = (b"\x00\x00\x00\x00\x00\x00\xf0\xbf" + bytes(64),) * 3  # -1: absent
    assert measurements_of(PLANE_IMU, message) == []


def test_another_covariance_is_used_from_its_message_on():
    reader, _, sensor = reader_of({**PLANE_IMU, "imu0_config": config(11), "two_d_mode": False})
    added, rng = [], np.random.default_rng(1)
    reader._add = added.append
    for scale in (1e-4, 1e-4, 4e-4):
        reader.process(sensor, reading(1.0, rng, "base_link", scale))
    first, second, third = added
    assert first.covariance is second.covariance
    assert (first.covariance[0, 0], third.covariance[0, 0]) == pytest.approx((1e-4, 4e-4))


def test_parts_that_measure_the_same_with_correlation_stay_apart():
    message = reading(1.0, np.random.default_rng(1), "base_link", 1e-4)
    full = np.full((3, 3), 1e-7) + 1e-4 * np.eye(3)
    message.covariances = (full.tobytes(),) * 3
    assert len(measurements_of(PLANE_IMU, message)) == 3
    assert len(measurements_of(FULL_IMU, message)) == 1


def test_an_odometry_of_a_known_frame():
    parameters = {"odom0": "odom", "odom0_config": config(0, 1, 5, 6, 11), "two_d_mode": True}
    message = Odometry(child_frame_id="base_link")
    message.header.stamp, message.header.frame_id = rospy.Time(1), "odom"
    message.pose.pose.position.x, message.pose.pose.orientation.w = 3.0, 1.0
    message.twist.twist.linear.x = 0.5
    for item in (message.pose, message.twist):
        item.covariance = (0.01 * np.eye(6)).ravel().tolist()
    (item,) = measurements_of(parameters, message)
    values = dict(zip(item.index.tolist(), item.value.tolist()))
    assert values == {**dict.fromkeys((1, 2, 3, 4, 5, 8, 9, 10, 11, 14), 0.0), 0: 3.0, 6: 0.5}
    message.child_frame_id = "nowhere"
    (item,) = measurements_of(parameters, message)
    assert 6 not in item.index

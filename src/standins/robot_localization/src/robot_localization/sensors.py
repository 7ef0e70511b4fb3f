"""Inputs of a filter: topics, what is used of each, messages in order of time."""

import operator
import struct
from dataclasses import dataclass

import numpy as np
from paddock_common.settings import converted

from robot_localization import messages
from robot_localization.ekf import (
    ACCELERATION,
    ANGLES,
    NAMES,
    OUT_OF_PLANE,
    POSE,
    RATES,
    SIZE,
    TWIST,
    Measurement,
)
from robot_localization.frames import IDENTITY, from_quaternion, matrix, to_transform, vector
from robot_localization.options import truth
from robot_localization.prepare import (
    Joint,
    PoseInput,
    Selection,
    acceleration,
    at_center,
    attitude_of,
    gravity_of,
    twist,
    velocities,
)

NEVER = float("inf")
PARTS = (POSE, TWIST, ACCELERATION)
FIRST = struct.Struct("<d")
INPUT_TYPES = ("odom", "pose", "twist", "imu")
# Values of the state in a message of each type.
PROVIDED = {
    "odom": tuple(range(0, 12)),
    "pose": tuple(range(0, 6)),
    "twist": tuple(range(6, 12)),
    "imu": (3, 4, 5, 9, 10, 11, 12, 13, 14),
}
# Names of the outlier thresholds of each type: for pose, twist, acceleration.
THRESHOLDS = {
    "odom": ("_pose_rejection_threshold", "_twist_rejection_threshold", None),
    "pose": ("_rejection_threshold", None, None),
    "twist": (None, "_rejection_threshold", None),
    "imu": (
        "_pose_rejection_threshold",
        "_twist_rejection_threshold",
        "_linear_acceleration_rejection_threshold",
    ),
}


@dataclass(frozen=True)
class Sensor:
    """One input.

    Attributes:
        name: Such as odom0.
        input_type: One of INPUT_TYPES.
        used: 15 truth values: which values of the state it measures.
        differential: Whether poses are used as velocities between two of them.
        relative: Whether poses are relative to the first one.
        thresholds: Mahalanobis distances of outliers for pose, twist, acceleration.
        queue_size: Messages that may wait.
        nodelay: Whether its connection sends small packets immediately.
        child_frame: Whether an odometry's pose is that of its child frame, not of the robot's.
        remove_gravity: Whether an accelerometer's reading includes gravity.
    """

    name: str
    input_type: str
    topic: str
    used: tuple
    differential: bool = False
    relative: bool = False
    thresholds: tuple = (NEVER, NEVER, NEVER)
    queue_size: int = 1
    nodelay: bool = False
    child_frame: bool = False
    remove_gravity: bool = False

    def uses(self, part):
        """Whether it measures something of POSE, TWIST or ACCELERATION."""
        return any(self.used[part])

    def parts(self):
        """Names of what is used of its messages, as in /diagnostics: odom0_pose, odom0_twist."""
        if self.input_type in ("pose", "twist"):
            return [self.name]
        names = ((POSE, "pose"), (TWIST, "twist"), (ACCELERATION, "acceleration"))
        return [f"{self.name}_{name}" for part, name in names if self.uses(part)]


def read(parameters):
    """Reads the sensors; an invalid one is skipped.

    Returns:
        (sensors, one message for each that is skipped or changed).
    """
    sensors, notes = [], []
    for input_type in INPUT_TYPES:
        count = 0
        while f"{input_type}{count}" in parameters:
            name = f"{input_type}{count}"
            try:
                sensor, more = _sensor(input_type, name, parameters)
                notes += more
                if any(sensor.used):
                    sensors.append(sensor)
                else:
                    notes.append(f"{name} is skipped: {name}_config uses nothing of its messages")
            except ValueError as error:
                notes.append(f"{name} is skipped: {error}")
            count += 1
        later = sorted(
            key
            for key in parameters
            if key.startswith(input_type)
            and key[len(input_type) :].isdigit()
            and int(key[len(input_type) :]) > count
        )
        if later:
            notes.append(f"{', '.join(later)}: not read, for there is no {input_type}{count}")
    return sensors, notes


def _sensor(input_type, name, parameters):
    def truth_of(suffix):
        return truth(name + suffix, parameters.get(name + suffix, False))

    topic, notes = parameters[name], []
    if not isinstance(topic, str) or not topic.strip():
        raise ValueError(f"{name} is {topic!r}, must be a topic")
    used = _used(input_type, name, parameters.get(f"{name}_config"), notes)
    differential, relative = truth_of("_differential"), truth_of("_relative")
    if differential and relative:
        notes.append(f"{name}_differential and {name}_relative are both true; the first is used")
        relative = False
    thresholds = tuple(
        converted(name + suffix, parameters[name + suffix])
        if suffix and name + suffix in parameters
        else NEVER
        for suffix in THRESHOLDS[input_type]
    )
    return (
        Sensor(
            name=name,
            input_type=input_type,
            topic=topic.strip(),
            used=used,
            differential=differential,
            relative=relative,
            thresholds=thresholds,
            queue_size=max(1, int(converted(name, parameters.get(f"{name}_queue_size", 1)))),
            nodelay=truth_of("_nodelay"),
            child_frame=truth_of("_pose_use_child_frame"),
            remove_gravity=truth_of("_remove_gravitational_acceleration"),
        ),
        notes,
    )


def _used(input_type, name, config, notes):
    if not isinstance(config, list):
        raise ValueError(f"{name}_config is {config!r}, must be a list of {SIZE} truth values")
    if len(config) != SIZE:
        notes.append(
            f"{name}_config has {len(config)} values, must have {SIZE}; "
            f"{'the rest counts as false' if len(config) < SIZE else 'the last ones are ignored'}"
        )
    values = [truth(f"{name}_config", value) for value in config[:SIZE]]
    values += [False] * (SIZE - len(values))
    missing = [NAMES[i] for i in range(SIZE) if values[i] and i not in PROVIDED[input_type]]
    # An odometry has no acceleration and a pose no twist: upstream drops those without a message.
    if missing and input_type == "imu":
        notes.append(f"{name}_config: an IMU does not measure {', '.join(missing)}")
    return tuple(value and index in PROVIDED[input_type] for index, value in enumerate(values))


def configuration_warnings(sensors, planar):
    """What in the sensors' choice leads to a poor estimate.

    Args:
        planar: Whether the filter is in the plane.

    Returns:
        List of (whether it is an error and not a warning, name of the value, message).
    """
    warnings = []
    for index in range(6):
        if planar and index in OUT_OF_PLANE:
            continue
        absolute = sum(sensor.used[index] and not sensor.differential for sensor in sensors)
        rates = sum(
            sensor.used[index + 6] or (sensor.used[index] and sensor.differential)
            for sensor in sensors
        )
        name = NAMES[index]
        if absolute > 1:
            warnings.append(
                (False, name, f"{absolute} sensors measure {name}; it may jump between them")
            )
        elif not absolute and not rates:
            warnings.append(
                (True, name, f"no sensor measures {name} or its rate; it will drift off")
            )
    return warnings


class Reader:
    """Transforms messages into the filter's frames and passes them on.

    Args:
        ekf: Ekf, for angular rates and attitude.
        add: Function of a Measurement.

    Attributes:
        rates_change: (3,) change of the angular rates [rad/s^2].
        rates_step: Time that it is of [s].
    """

    def __init__(self, options, frames, ekf, add):
        self._options, self._frames, self._ekf, self._add = options, frames, ekf, add
        self._poses, self._selections, self._joints = {}, {}, {}
        self.rates_change, self.rates_step = np.zeros(3), 1.0
        self._handlers = {
            "odom": self._odometry,
            "pose": self._pose,
            "twist": self._twist,
            "imu": self._imu,
        }

    def clear(self):
        self._poses.clear()

    def process(self, sensor, message):
        """Processes a message of a Sensor; those of an IMU are messages.ImuReading."""
        measurements = self._handlers[sensor.input_type](sensor, message)
        measurements = [item for item in measurements if item is not None]
        for item in self._joined(sensor, measurements):
            self._add(item)

    def _joined(self, sensor, measurements):
        """The measurements of a message, as one where that is the same."""
        # The first one of all sets the state: the others of its message correct it.
        if len(measurements) < 2 or not self._ekf.initialized:
            return measurements
        for item in measurements:
            if not item.checked or item.threshold != NEVER:
                return measurements
        joint = self._joints.get(sensor.name)
        if joint is None or not joint.fits(measurements):
            joint = self._joints[sensor.name] = Joint(measurements)
        return (joint.measurement(measurements),) if joint.possible else measurements

    def pose_in_world(self, message):
        """Numbers of a geometry_msgs/PoseWithCovarianceStamped, or None without its frame."""
        frame = self._frames.find(
            self._options.world_frame, message.header.frame_id, message.header.stamp
        )
        if frame is None:
            return None
        pose = to_transform(message.pose.pose.position, message.pose.pose.orientation)
        covariance = _square(message.pose.covariance, 6)
        values = PoseInput([True] * 6).process(0.0, pose, covariance, frame)
        return values.flatten() if self._options.two_d_mode else values

    def _memory(self, sensor):
        if sensor.name not in self._poses:
            self._poses[sensor.name] = PoseInput(
                sensor.used[POSE], sensor.differential, sensor.relative
            )
        return self._poses[sensor.name]

    def _measurement(self, sensor, part, stamp, numbers, depends, values):
        """A Measurement of a part of the state.

        Args:
            numbers: The values in the part's order.
            depends: What used axes and covariance depend on: Transforms, and numbers or bytes.
            values: Function without arguments that returns StateValues with these two; called when
                what they depend on is another than in the message before.
        """
        known = self._selections.get((sensor.name, part.start))
        if known is None or not _same(known[0], depends):
            made = values()
            planar = self._options.two_d_mode
            selection = Selection(part, made.flatten() if planar else made, planar)
            known = self._selections[sensor.name, part.start] = depends, selection
        return known[1].measurement(
            sensor.name, stamp.to_sec(), numbers, sensor.thresholds[PARTS.index(part)]
        )

    def _odometry(self, sensor, message):
        pose = velocity = None
        if sensor.uses(POSE):
            child = message.child_frame_id if sensor.child_frame else None
            pose = self._pose_measurement(sensor, message.header, message.pose, child)
        if sensor.uses(TWIST):
            velocity = self._twist_measurement(
                sensor, message.header.stamp, message.child_frame_id, message.twist
            )
        return pose, velocity

    def _pose(self, sensor, message):
        return (self._pose_measurement(sensor, message.header, message.pose, None),)

    def _twist(self, sensor, message):
        header = message.header
        return (self._twist_measurement(sensor, header.stamp, header.frame_id, message.twist),)

    def _pose_measurement(self, sensor, header, value, child):
        option, find, stamp = self._options, self._frames.find, header.stamp
        memory = self._memory(sensor)
        frame = IDENTITY
        if not sensor.differential:
            frame = find(option.world_frame, header.frame_id, stamp)
        base = find(child, option.base_link_frame, stamp) if child else IDENTITY
        if frame is None or base is None:
            return None
        pose = to_transform(value.pose.position, value.pose.orientation)

        def values():
            return memory.process(stamp.to_sec(), pose, _square(value.covariance, 6), frame, base)

        if sensor.differential:
            return self._velocity(sensor, stamp, values())
        numbers, depends = memory.place(pose, frame, base), (frame, base, value.covariance)
        return self._measurement(sensor, POSE, stamp, numbers, depends, values)

    def _velocity(self, sensor, stamp, values):
        """Measurement of the velocities of two poses, StateValues or None."""
        if values is None:
            return None
        if self._options.two_d_mode:
            values.flatten()
        return Measurement(sensor.name, stamp.to_sec(), *values.select(), sensor.thresholds[0])

    def _twist_measurement(self, sensor, stamp, frame, value):
        mount = self._frames.find(self._options.base_link_frame, frame, stamp)
        if mount is None:
            return None
        linear, angular = vector(value.twist.linear), vector(value.twist.angular)
        rates = self._ekf.state[RATES]
        return self._measurement(
            sensor,
            TWIST,
            stamp,
            velocities(linear, angular, mount, rates),
            (mount, value.covariance),
            lambda: twist(
                linear, angular, _square(value.covariance, 6), sensor.used[TWIST], mount, rates
            ),
        )

    def _imu(self, sensor, reading):
        stamp = reading.header.stamp
        mount = self._frames.find(self._options.base_link_frame, reading.header.frame_id, stamp)
        if mount is None:
            return ()
        attitude = None
        if sensor.uses(POSE) or sensor.remove_gravity:
            attitude = from_quaternion(*reading.attitude)
        known = [not _absent(data) for data in reading.covariances]
        return (
            self._attitude(sensor, reading, attitude, mount)
            if sensor.uses(POSE) and known[0]
            else None,
            self._rates(sensor, reading, mount) if sensor.uses(TWIST) and known[1] else None,
            self._acceleration(sensor, reading, attitude if known[0] else None, mount)
            if sensor.uses(ACCELERATION) and known[2]
            else None,
        )

    def _attitude(self, sensor, reading, attitude, mount):
        memory, stamp, data = self._memory(sensor), reading.header.stamp, reading.covariances[0]

        def values():
            covariance = _square(messages.covariance(data), 3)
            return memory.process_attitude(stamp.to_sec(), attitude, covariance, mount)

        if sensor.differential:
            return self._velocity(sensor, stamp, values())
        numbers = memory.place(attitude_of(attitude, mount))
        return self._measurement(sensor, POSE, stamp, numbers, (mount, data), values)

    def _rates(self, sensor, reading, mount):
        data = reading.covariances[1]

        def values():
            covariance = np.zeros((6, 6))
            covariance[3:, 3:] = _square(messages.covariance(data), 3)
            return twist(np.zeros(3), reading.rates, covariance, sensor.used[TWIST], mount)

        numbers = velocities((0.0, 0.0, 0.0), reading.rates, mount)
        stamp = reading.header.stamp
        return self._measurement(sensor, TWIST, stamp, numbers, (mount, data), values)

    def _acceleration(self, sensor, reading, attitude, mount):
        """As the others; attitude: (3, 3), None if the IMU does not measure it."""
        measured, data = reading.force, reading.covariances[2]
        rates, change, used = self._ekf.state[RATES], self.rates_change, sensor.used[ACCELERATION]
        if sensor.remove_gravity:
            if attitude is None:
                attitude = matrix(*self._ekf.state[ANGLES]) @ mount.rotation
            elif sensor.relative:
                attitude = attitude @ mount.rotation
            measured = measured - gravity_of(attitude, self._options.gravitational_acceleration)

        def values():
            covariance = _square(messages.covariance(data), 3)
            return acceleration(measured, covariance, used, mount, rates, change)

        numbers, stamp = at_center(measured, mount, rates, change), reading.header.stamp
        return self._measurement(sensor, ACCELERATION, stamp, numbers, (mount, data), values)


def _square(values, size):
    return np.array(values, float).reshape(size, size)


def _absent(data):
    """Whether an IMU does not measure a quantity: -1 as the first variance of its covariance."""
    return abs(FIRST.unpack_from(data)[0] + 1.0) < 1e-9


def _same(before, now):
    """Whether what a Selection depends on is the same: objects, and numbers or bytes at the end."""
    return all(map(operator.is_, before[:-1], now)) and before[-1] == now[-1]

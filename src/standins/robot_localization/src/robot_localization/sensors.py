"""Inputs of a filter: topics, what counts of each, messages in order of time."""

from dataclasses import dataclass

import numpy as np
from paddock_common.settings import converted

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
from robot_localization.frames import IDENTITY, from_quaternion, matrix, to_transform
from robot_localization.options import truth
from robot_localization.prepare import PoseInput, acceleration, gravity_of, twist

NEVER = float("inf")
KINDS = ("odom", "pose", "twist", "imu")
# Numbers of the state that a message of each kind holds.
HELD = {
    "odom": tuple(range(0, 12)),
    "pose": tuple(range(0, 6)),
    "twist": tuple(range(6, 12)),
    "imu": (3, 4, 5, 9, 10, 11, 12, 13, 14),
}
# Names of the outlier thresholds of each kind: for pose, twist, acceleration.
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
        kind: One of KINDS.
        topic: Its topic.
        used: 15 truth values: which numbers of the state it measures.
        differential: Whether poses are taken as velocities between two of them.
        relative: Whether poses are taken from the first one.
        thresholds: Mahalanobis distances of outliers for pose, twist, acceleration.
        queue_size: Messages that may wait.
        nodelay: Whether its connection sends small packets at once.
        child_frame: Whether an odometry's pose is that of its child frame, not of the robot's.
        remove_gravity: Whether an accelerometer's reading holds gravity.
    """

    name: str
    kind: str
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


def read(parameters):
    """Reads the sensors; a wrong one is left out.

    Args:
        parameters: Dict of the node's parameters.

    Returns:
        (sensors, one sentence for each that is left out or changed).
    """
    sensors, notes = [], []
    for kind in KINDS:
        count = 0
        while f"{kind}{count}" in parameters:
            name = f"{kind}{count}"
            try:
                sensor, more = _sensor(kind, name, parameters)
                notes += more
                if any(sensor.used):
                    sensors.append(sensor)
                else:
                    notes.append(f"{name} is left out: {name}_config uses nothing of its messages")
            except ValueError as error:
                notes.append(f"{name} is left out: {error}")
            count += 1
        later = sorted(
            key
            for key in parameters
            if key.startswith(kind) and key[len(kind) :].isdigit() and int(key[len(kind) :]) > count
        )
        if later:
            notes.append(f"{', '.join(later)}: not read, for there is no {kind}{count}")
    return sensors, notes


def _sensor(kind, name, parameters):
    def truth_of(suffix):
        return truth(name + suffix, parameters.get(name + suffix, False))

    topic, notes = parameters[name], []
    if not isinstance(topic, str) or not topic.strip():
        raise ValueError(f"{name} is {topic!r}, must be a topic")
    used = _used(kind, name, parameters.get(f"{name}_config"), notes)
    differential, relative = truth_of("_differential"), truth_of("_relative")
    if differential and relative:
        notes.append(f"{name}_differential and {name}_relative are both true; the first is used")
        relative = False
    thresholds = tuple(
        converted(name + suffix, parameters[name + suffix])
        if suffix and name + suffix in parameters
        else NEVER
        for suffix in THRESHOLDS[kind]
    )
    return (
        Sensor(
            name=name,
            kind=kind,
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


def _used(kind, name, config, notes):
    if not isinstance(config, list):
        raise ValueError(f"{name}_config is {config!r}, must be a list of {SIZE} truth values")
    if len(config) != SIZE:
        notes.append(
            f"{name}_config has {len(config)} values, must have {SIZE}; "
            f"{'the rest counts as false' if len(config) < SIZE else 'the last ones are ignored'}"
        )
    values = [truth(f"{name}_config", value) for value in config[:SIZE]]
    values += [False] * (SIZE - len(values))
    unheld = [NAMES[i] for i in range(SIZE) if values[i] and i not in HELD[kind]]
    # An odometry holds no acceleration and a pose no twist: upstream drops those without a word.
    if unheld and kind == "imu":
        notes.append(f"{name}_config: an IMU does not measure {', '.join(unheld)}")
    return tuple(value and place in HELD[kind] for place, value in enumerate(values))


def doubts(sensors, planar):
    """What in the sensors' choice leads to a poor estimate.

    Args:
        sensors: Of read.
        planar: Whether the filter is in the plane.

    Returns:
        List of (whether it is an error and not a warning, name of the number, sentence).
    """
    found = []
    for place in range(6):
        if planar and place in OUT_OF_PLANE:
            continue
        absolute = sum(sensor.used[place] and not sensor.differential for sensor in sensors)
        rates = sum(
            sensor.used[place + 6] or (sensor.used[place] and sensor.differential)
            for sensor in sensors
        )
        name = NAMES[place]
        if absolute > 1:
            found.append(
                (False, name, f"{absolute} sensors measure {name}; it may jump between them")
            )
        elif not absolute and not rates:
            found.append((True, name, f"no sensor measures {name} or its rate; it will drift off"))
    return found


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

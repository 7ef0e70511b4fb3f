"""Parameters of the sensors: odomN, poseN, twistN, imuN and what belongs to each."""

from dataclasses import dataclass

from robot_localization.estimate.state import (
    NAMES,
    OUT_OF_PLANE,
    SIZE,
)
from robot_localization.values import number, truth

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
        number(name + suffix, parameters[name + suffix])
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
            queue_size=max(1, int(number(name, parameters.get(f"{name}_queue_size", 1)))),
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

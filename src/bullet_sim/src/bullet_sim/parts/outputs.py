"""Topics of parts, as the core knows them: what is sent on each, without a middleware."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Dict, NamedTuple, Protocol

import numpy as np

from bullet_sim.pose import Array
from bullet_sim.sensors import camera

Fields = Dict[str, Array]


class Shape(NamedTuple):
    """Of one array of a message.

    Attributes:
        low, high: of each value.
    """

    shape: tuple[int, ...]
    low: float = -math.inf
    high: float = math.inf
    dtype: type = np.float64


class Sender(Protocol):
    """What sends on the topic of an Output."""

    def has_subscribers(self) -> bool:
        """Whether anybody gets what is sent."""

    def send(self, time: float, *values: Any, **options: Any) -> Any:
        """Send what the Output's fields() takes, for a simulated time [s]."""

    def send_all(self, times: Sequence[float], *values: Any) -> None:
        """As send() for each of k times; values: arrays (k,), or sequences of them."""


@dataclass(frozen=True)
class Output:
    """A topic.

    Attributes:
        MESSAGE: type of its messages in ROS.
        topic: resolved name.
    """

    MESSAGE: ClassVar[str]
    topic: str

    def shapes(self) -> dict[str, Shape]:
        """Of each array of a message; empty: it has no fixed size."""
        return {}

    def fields(self, *values: Any, **options: Any) -> Fields:
        """Arrays of a message as shapes() has them, by the message's names."""
        return dict(zip(self.shapes(), map(_row, values)))


def _row(values: Iterable[float]) -> Array:
    return np.array(tuple(values), np.float64)


@dataclass(frozen=True)
class JointStatesOutput(Output):
    """sensor_msgs/JointState: positions, velocities, efforts in the order of names."""

    MESSAGE = "sensor_msgs/JointState"
    names: tuple[str, ...]
    parts: tuple[str, ...] = ("position", "velocity", "effort")
    frame_id: str = ""

    def shapes(self) -> dict[str, Shape]:
        return {part: Shape((len(self.names),)) for part in self.parts}


POSE = {"position": Shape((3,)), "orientation": Shape((4,), -1.0, 1.0)}
TWIST = {"linear": Shape((3,)), "angular": Shape((3,))}


@dataclass(frozen=True)
class OdometryOutput(Output):
    """nav_msgs/Odometry: pose [m], (x, y, z, w), and twist in the child's frame [m/s], [rad/s].

    Attributes:
        pose_covariance, twist_covariance: diagonals of the covariances.
    """

    MESSAGE = "nav_msgs/Odometry"
    frame_id: str
    child_frame_id: str
    pose_covariance: Sequence[float]
    twist_covariance: Sequence[float]

    def shapes(self) -> dict[str, Shape]:
        return {**POSE, **TWIST}

    def fields(self, *values: Any, **options: Any) -> Fields:
        fields = super().fields(*values)
        if options.get("flat"):
            fields["position"][2] = 0.0
        return fields


@dataclass(frozen=True)
class BaseOutput(OdometryOutput):
    """Odometry of a base and its transform, which has the odometry's header.

    send() has the options flat (the odometry's height is 0, its transform's is not) and
    with_transform.

    Attributes:
        topic: empty: there is none.
        with_transform: its transform is sent.
        advertises: the topic /tf is there in any case.
        with_odometry: the odometry is sent.
    """

    with_transform: bool = True
    advertises: bool = True
    with_odometry: bool = True


@dataclass(frozen=True)
class TransformsOutput(Output):
    """tf2_msgs/TFMessage of (frame, child frame, Pose) tuples.

    Attributes:
        relayed: by the bridge's relay process.
    """

    MESSAGE = "tf2_msgs/TFMessage"
    topic: str = "/tf"
    relayed: bool = True


@dataclass(frozen=True)
class ScanOutput(Output):
    """sensor_msgs/LaserScan: ranges (n,) float32 [m], intensities (n,) or None: zeros.

    Attributes:
        spec: RaySpec.
        increment: between rays [rad].
        count: of rays.
    """

    MESSAGE = "sensor_msgs/LaserScan"
    spec: Any
    increment: float
    count: int

    def shapes(self) -> dict[str, Shape]:
        shape = Shape((self.count,), dtype=np.float32)
        return {"ranges": shape, "intensities": shape}

    def fields(self, *values: Any, **options: Any) -> Fields:
        ranges, intensities = (*values, None)[:2]
        if intensities is None:
            intensities = np.zeros(self.count, np.float32)
        return {
            "ranges": ranges.astype(np.float32),
            "intensities": intensities.astype(np.float32),
        }


@dataclass(frozen=True)
class ImuOutput(Output):
    """sensor_msgs/Imu: orientation (x, y, z, w), rate [rad/s], specific force [m/s^2].

    Attributes:
        variance: on the diagonals of the covariances.
    """

    MESSAGE = "sensor_msgs/Imu"
    frame_id: str
    variance: float = 0.0

    def shapes(self) -> dict[str, Shape]:
        return {
            "orientation": Shape((4,)),  # noise changes its length, too
            "angular_velocity": Shape((3,)),
            "linear_acceleration": Shape((3,)),
        }


@dataclass(frozen=True)
class NumbersOutput(Output):
    """A message of any type with a few numbers: the values of some of its fields, in their order.

    Attributes:
        message: its type.
        sizes: names of the fields, with dots -> how many numbers each has; 0: it has none.
        frame_id: of its header.
        constant: other fields -> values.
    """

    MESSAGE = ""
    message: str
    sizes: Mapping[str, int]
    frame_id: str = ""
    constant: Mapping[str, Any] = field(default_factory=dict)

    def shapes(self) -> dict[str, Shape]:
        return {name: Shape((size,)) for name, size in self.sizes.items() if size}

    def fields(self, *values: Any, **options: Any) -> Fields:
        of_fields = zip(self.sizes.items(), values)
        return {name: _row(value) for (name, size), value in of_fields if size}


@dataclass(frozen=True)
class PointsOutput(Output):
    """Points of a lidar, as sensor_msgs/PointCloud2 or another message.

    Its array has what was hit, in the order of the rays, and zeros behind.

    Attributes:
        spec: of the lidar.
        count: of the points of one message, those that hit nothing included.
        message: type of the message.
    """

    MESSAGE = "sensor_msgs/PointCloud2"
    spec: Any
    count: int
    message: str = "sensor_msgs/PointCloud2"

    def shapes(self) -> dict[str, Shape]:
        return {"points": Shape((self.count, 3), dtype=np.float32)}

    def fields(self, *values: Any, **options: Any) -> Fields:
        made = values[0][np.isfinite(values[0]).all(axis=1)]
        points = np.zeros((self.count, 3), np.float32)
        points[: len(made)] = made
        return {"points": points}


@dataclass(frozen=True)
class ContactsOutput(Output):
    """gazebo_msgs/ContactsState of ContactStates, oldest first.

    Its arrays are the number of states and the sum of their total wrenches.
    """

    MESSAGE = "gazebo_msgs/ContactsState"
    frame_id: str

    def shapes(self) -> dict[str, Shape]:
        return {"count": Shape((1,), 0.0), "wrench": Shape((6,))}

    def fields(self, *values: Any, **options: Any) -> Fields:
        states = values[0]
        total = sum((state.total for state in states), np.zeros(6))
        return {"count": np.array([float(len(states))]), "wrench": total}


@dataclass(frozen=True)
class ImageOutput(Output):
    """sensor_msgs/Image: pixels (H, W) or (H, W, 3) in an encoding of sensor_msgs."""

    MESSAGE = "sensor_msgs/Image"
    frame_id: str
    encoding: str
    height: int
    width: int

    def shapes(self) -> dict[str, Shape]:
        tail: tuple[int, ...] = (3,) if self.encoding in ("rgb8", "bgr8", "rgb16") else ()
        kind, high = _PIXELS.get(self.encoding, (np.uint8, 255.0))
        return {"data": Shape((self.height, self.width, *tail), 0.0, high, kind)}

    def fields(self, *values: Any, **options: Any) -> Fields:
        return {"data": np.ascontiguousarray(values[0])}


_PIXELS: dict[str, tuple[type, float]] = {
    "32FC1": (np.float32, math.inf),
    "16UC1": (np.uint16, 65535.0),
    "mono16": (np.uint16, 65535.0),
    "rgb16": (np.uint16, 65535.0),
}


@dataclass(frozen=True)
class DepthPointsOutput(Output):
    """sensor_msgs/PointCloud2 in the optical frame: depths (H, W) [m], NaN: unknown, and colors
    (H, W, 3) or (H, W).

    Attributes:
        spec: of the camera.
        k: (3, 3) [px].
    """

    MESSAGE = "sensor_msgs/PointCloud2"
    spec: Any
    k: Any

    def shapes(self) -> dict[str, Shape]:
        return {"points": Shape((self.spec.height * self.spec.width, 3), dtype=np.float32)}

    def fields(self, *values: Any, **options: Any) -> Fields:
        depth = values[0]
        points = np.empty((*depth.shape, 3), np.float32)
        camera.points(depth, self.k, points)
        return {"points": np.nan_to_num(points, copy=False, nan=0.0).reshape(-1, 3)}

"""Lidars, range sensors and point clouds."""

from __future__ import annotations

import io
import itertools
import math
import os
from typing import Any, ClassVar

import numpy as np
import rospkg
from bullet_sim.errors import ModelError, SimError
from bullet_sim.files import read_unpacked
from bullet_sim.plugins import lidars as specs
from bullet_sim.pose import Array, Pose
from bullet_sim.sensors.errors import SensorErrors
from bullet_sim.sensors.lidar import LayeredLidar, Lidar, PatternLidar
from geometry_msgs.msg import Point32
from sensor_msgs.msg import ChannelFloat32, LaserScan, PointCloud, PointCloud2, PointField, Range
from tf2_msgs.msg import TFMessage

from bullet_bridge.plugins.base import PluginContext, Sensor, ros_side
from bullet_bridge.plugins.errors import TunedSensor
from bullet_bridge.transport import conversions
from bullet_bridge.transport.packed import PackedScan


class RaysSensor(Sensor):
    """Casts the rays of a lidar, all of a scan at one time.

    Attributes:
        lidar: class of the core's lidar.
        too_near: what is nearer than the minimum range has the range -inf; False: rays begin there.
    """

    lidar: ClassVar[type[Lidar]] = Lidar
    too_near: ClassVar[bool] = True

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._lidar: Any = self._make_lidar()

    def _make_lidar(self) -> Any:
        return self.lidar(self.spec)

    def _scan(self) -> Array:
        position, orientation, _, _ = self.model.link_motion(self.spec.link)
        return self._lidar.scan(
            self.world.visible if self.spec.sees_visuals else self.world.engine,
            position,
            orientation,
            self.rng,
            self.model.body.number,
            self.too_near,
        )

    def _intensities(self) -> Array | None:
        """Of the last scan; None: all are 0."""
        intensities: Array | None = self._lidar.intensities(self.world.models.values())
        return intensities


@ros_side(specs.RaySpec)
class LidarSensor(RaysSensor):
    """sensor_msgs/LaserScan; of several layers all ranges, layer by layer, as upstream."""

    message = LaserScan

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._layers = self.spec.layers if isinstance(self.spec, specs.LayeredScanSpec) else 1
        count = len(self._lidar.angles) * self._layers
        self._sender = PackedScan(self.pub, self.spec, self._lidar.angle_increment, count)

    def _make_lidar(self) -> Any:
        layered = isinstance(self.spec, specs.LayeredScanSpec)
        return LayeredLidar(self.spec) if layered else super()._make_lidar()

    def update(self, time: float, period: float) -> None:
        ranges, intensities = self._scan(), self._intensities()
        if self._layers > 1:
            ranges = _by_layers(ranges, self._layers)
            if intensities is not None:
                intensities = _by_layers(intensities, self._layers)
        self._sender.send(time, ranges, intensities)


def _by_layers(values: Array, layers: int) -> Array:
    """Values (n,) of a LayeredLidar's rays, layer by layer instead of direction by direction."""
    return values.reshape(-1, layers).T.ravel()


def _with_next(values: Array, layers: int) -> Array:
    """Means (n,) of each value, the next one of its layer and both of the next layer."""
    rows = np.pad(values.reshape(layers, -1), ((0, 1), (0, 1)), mode="edge")
    means: Array = 0.25 * (rows[:-1, :-1] + rows[:-1, 1:] + rows[1:, :-1] + rows[1:, 1:])
    return means.ravel()


# velodyne_gazebo_plugins' layout of a point, 22 bytes.
_POINT = np.dtype(
    {
        "names": ["xyz", "intensity", "ring", "time"],
        "formats": ["(3,)<f4", "<f4", "<u2", "<f4"],
        "offsets": [0, 12, 16, 18],
        "itemsize": 22,
    }
)
_FIELDS = [
    PointField(name=name, offset=offset, datatype=datatype, count=1)
    for name, offset, datatype in (
        ("x", 0, PointField.FLOAT32),
        ("y", 4, PointField.FLOAT32),
        ("z", 8, PointField.FLOAT32),
        ("intensity", 12, PointField.FLOAT32),
        ("ring", 16, PointField.UINT16),
        ("time", 18, PointField.FLOAT32),
    )
]


def velodyne_cloud(
    time: float,
    spec: specs.CloudSpec,
    points: Array,
    rings: Array,
    intensities: Array | None = None,
) -> PointCloud2:
    """sensor_msgs/PointCloud2 of points (n, 3).

    Args:
        points: [m] in the sensor frame, the layers of one direction after each other; NaN: none.
        rings: (n,) layer of each point.
        intensities: (n,) of each; None: 0.
    """
    data = np.zeros(len(points), _POINT)
    data["xyz"], data["ring"] = points, rings
    if intensities is not None:
        data["intensity"] = intensities
    if spec.organized:  # rows are layers, highest first
        data = data.reshape(-1, spec.layers).T[::-1]
    else:
        data = data[np.isfinite(points).all(axis=1)][None, :]
    header = conversions.header(time, spec.frame_id)
    return conversions.cloud(header, data, _FIELDS, not spec.organized)


@ros_side(specs.CloudSpec)
class CloudSensor(RaysSensor):
    """sensor_msgs/PointCloud2 of a velodyne."""

    message, lidar = PointCloud2, LayeredLidar
    relayed = False

    def measure(self, time: float) -> PointCloud2:
        points, intensities = self._lidar.points(self._scan()), self._intensities()
        if self.spec.min_intensity > -math.inf:
            values = np.zeros(len(points)) if intensities is None else intensities
            points = np.where((values < self.spec.min_intensity)[:, None], math.nan, points)
        return velodyne_cloud(time, self.spec, points, self._lidar.rings, intensities)


@ros_side(specs.BlockCloudSpec)
class BlockLaserSensor(RaysSensor):
    """sensor_msgs/PointCloud of libgazebo_ros_block_laser: a point of each ray, layer by layer.

    As upstream's: where nothing was hit beyond the minimum range it is at the maximum range,
    without noise; each is half a ray's angle beyond its ray, but that of the last one; with a
    single ray or layer all are NaN.
    Its intensity is the mean of four rays': the next one's and the next layer's count as well.
    """

    message, lidar, too_near = PointCloud, LayeredLidar, False
    relayed = False
    CACHE = ("_aims",)

    def _make_lidar(self) -> Any:
        spec, made = self.spec, super()._make_lidar()
        yaw, pitch = (
            _half_a_ray_beyond(first, last, count)
            for first, last, count in (
                (spec.min_angle, spec.max_angle, spec.samples),
                (spec.min_elevation, spec.max_elevation, spec.layers),
            )
        )
        self._aims = np.stack(
            [
                np.outer(np.cos(pitch), np.cos(yaw)).ravel(),
                np.outer(np.cos(pitch), np.sin(yaw)).ravel(),
                np.outer(np.sin(pitch), np.ones(len(yaw))).ravel(),
            ],
            axis=1,
        )
        return made

    def measure(self, time: float) -> PointCloud:
        spec, ranges, values = self.spec, self._scan(), self._intensities()
        ranges = np.where(ranges == math.inf, spec.range_max, ranges)
        values = np.zeros(len(ranges)) if values is None else values
        ranges, values = (_by_layers(of_rays, spec.layers) for of_rays in (ranges, values))
        values = _with_next(values, spec.layers)
        points = self._aims * ranges[:, None]
        if spec.point_noise > 0.0:
            hit = np.abs(spec.range_max - ranges) > _FARTHEST
            noise = self.rng.normal(0.0, spec.point_noise, (len(ranges), 4))
            points = points + noise[:, :3] * hit[:, None]
            values = values + noise[:, 3]
        return PointCloud(
            header=conversions.header(time, spec.frame_id),
            points=[Point32(*point) for point in points.tolist()],
            channels=[ChannelFloat32(values=values.tolist())],
        )


_FARTHEST = 1e-6  # [m] a range that is closer to the maximum has no noise in block_laser


def _half_a_ray_beyond(first: float, last: float, count: int) -> Array:
    """Angles (count,) [rad] as block_laser has them; NaN for a single one."""
    if count == 1:
        return np.full(1, math.nan)
    rays = np.arange(count)
    return first + 0.5 * (rays + np.minimum(rays + 1, count - 1)) * (last - first) / (count - 1)


@ros_side(specs.RangeSpec)
class RangeSensor(RaysSensor, TunedSensor):
    """sensor_msgs/Range: the closest hit, max_range where there is none."""

    message, lidar = Range, LayeredLidar

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self.errors = (SensorErrors(self.spec.errors),)
        if self.spec.tunable:
            self.tune(self.spec.topic, *self.errors)

    def measure(self, time: float) -> Range:
        spec, ranges, elapsed = self.spec, self._scan(), self.elapsed(time)
        minimum = float(np.clip(ranges.min(), spec.range_min, spec.range_max))
        if minimum < spec.range_max:
            minimum = self.errors[0].measured((minimum,) * 3, elapsed, self.rng)[0]
            lowest = spec.range_min if spec.limited else -math.inf
            minimum = float(np.clip(minimum, lowest, spec.range_max))
        return Range(
            header=conversions.header(time, spec.frame_id),
            radiation_type=Range.INFRARED if spec.infrared else Range.ULTRASOUND,
            field_of_view=spec.field_of_view,
            min_range=spec.range_min,
            max_range=spec.range_max,
            range=minimum,
        )


# livox_laser_simulation's layouts of a point.
_XYZ = np.dtype({"names": ["xyz"], "formats": ["(3,)<f4"], "offsets": [0], "itemsize": 16})
_XYZRTL = np.dtype(
    {
        "names": ["xyz", "reflectivity", "tag", "line"],
        "formats": ["(3,)<f4", "<f4", "u1", "u1"],
        "offsets": [0, 16, 20, 21],
        "itemsize": 32,
    }
)
_XYZ_FIELDS = _FIELDS[:3]
_XYZRTL_FIELDS = _XYZ_FIELDS + [
    PointField(name=name, offset=offset, datatype=datatype, count=1)
    for name, offset, datatype in (
        ("reflectivity", 16, PointField.FLOAT32),
        ("tag", 20, PointField.UINT8),
        ("line", 21, PointField.UINT8),
    )
]
_MIN_XYZ = 0.1  # [m] of a point of the second kind of message


ROWS, LONGEST_ROW = 20_000, 1000  # rows that are read at once, characters of one


def _read_pattern(path: str) -> Array:
    """Rows (n, 3) of finite numbers of a CSV file with a header.

    Raises:
        SimError, ValueError: it cannot be read, or a row is none of three numbers.
    """
    lines = io.BytesIO(read_unpacked(path, "file", "pattern_bytes"))
    lines.readline()
    parts = [np.empty((0, 3))]
    while rows := list(itertools.islice(lines, ROWS)):
        if max(map(len, rows)) > LONGEST_ROW:
            raise ValueError(f"a row has more than {LONGEST_ROW} characters")
        if any(row.strip() for row in rows):
            part = np.genfromtxt(rows, delimiter=",", ndmin=2)
            if part.shape[1] != 3:
                raise ValueError(f"a row has {part.shape[1]} numbers, must have three")
            parts.append(part[np.isfinite(part).all(axis=1)])
    return np.concatenate(parts)


def _read_pattern_of(path: str) -> Array:
    """Rows (n, 3) of a livox's pattern, a path, file:// or package://.

    Raises:
        ModelError: it cannot be read, or has no such rows.
    """
    scheme, _, rest = path.partition("://")
    try:
        file = rest if scheme == "file" else path
        if scheme == "package":
            package, _, rest = rest.partition("/")
            file = os.path.join(rospkg.RosPack().get_path(package), rest)
        pattern = _read_pattern(file)
    except (SimError, ValueError, rospkg.ResourceNotFound) as error:
        raise ModelError(f"the pattern '{path}' of a livox cannot be read: {error}") from error
    if not len(pattern):
        raise ModelError(f"the pattern '{path}' of a livox has no rows of three numbers")
    return pattern


@ros_side(specs.PatternSpec)
class PatternSensor(RaysSensor):
    """The messages of livox_laser_simulation, and its transforms of the sensor and its link.

    Raises:
        ModelError: the pattern cannot be read, or the kind of message is unknown or not built.
    """

    STATE = ("_first",)
    relayed = False

    def __init__(self, context: PluginContext) -> None:
        self.message = self._message_of(context.spec.message)
        super().__init__(context)
        self._parent = f"{self.model.name}::{self.spec.link}"
        self._tf = self.publisher("/tf", TFMessage, relayed=False)

    @staticmethod
    def _message_of(number: int) -> Any:
        if number == 3:
            try:
                from livox_ros_driver.msg import CustomMsg
            except ImportError as error:
                raise ModelError(
                    f"publish_pointcloud_type 3 needs livox_ros_driver: {error}"
                ) from error
            return CustomMsg
        if number not in (0, 1, 2):
            raise ModelError(f"publish_pointcloud_type is {number}, must be 0, 1, 2 or 3")
        return PointCloud if number == 0 else PointCloud2

    def _make_lidar(self) -> PatternLidar:
        return PatternLidar(self.spec, _read_pattern_of(self.spec.pattern))

    def reset(self, time: float) -> None:
        """From the first ray of the pattern on."""
        self._first = 0
        super().reset(time)

    def measure(self, time: float) -> Any:
        self._first = self._lidar.next(self._first)
        points, rays = self._lidar.points(self._scan())
        intensities = self._intensities()
        values = np.zeros(len(rays), np.float32) if intensities is None else intensities[rays]
        lines, frame = self._lidar.lines[rays], self.spec.frame_id
        self._send_transforms(time)
        kind = self.spec.message
        if kind == 0:
            return PointCloud(
                header=conversions.header(time, frame),
                points=[Point32(*point) for point in points.tolist()],
            )
        if kind == 1:
            points = points[np.linalg.norm(points, axis=1) >= _MIN_XYZ]
            data = np.zeros((1, len(points)), _XYZ)
            data["xyz"][0] = points
            return conversions.cloud(conversions.header(time, "livox"), data, _XYZ_FIELDS, True)
        if kind == 2:
            data = np.zeros((1, len(points)), _XYZRTL)
            data["xyz"][0], data["reflectivity"][0], data["line"][0] = points, values, lines
            return conversions.cloud(conversions.header(time, frame), data, _XYZRTL_FIELDS, True)
        return self._custom(time, points, values, lines)

    def _custom(self, time: float, points: Array, values: Array, lines: Array) -> Any:
        from livox_ros_driver.msg import CustomPoint

        header = conversions.header(time, self.spec.frame_id)
        message = self.message(header=header, timebase=header.stamp.to_nsec())
        message.points = [
            CustomPoint(x=x, y=y, z=z, reflectivity=int(value), line=int(line))
            for (x, y, z), value, line in zip(points.tolist(), values.tolist(), lines.tolist())
        ]
        message.point_num = len(message.points)
        return message

    def _send_transforms(self, time: float) -> None:
        """Upstream names them with Gazebo's scoped names."""
        link = self.model.link_state(self.spec.link)[0]
        offset = Pose.from_xyz_rpy(*self.spec.pose)
        transforms = [
            conversions.transform_to_msg(time, self.world.name, self._parent, link),
            conversions.transform_to_msg(time, self._parent, self.spec.frame_id, offset),
        ]
        self._tf.publish(TFMessage(transforms))

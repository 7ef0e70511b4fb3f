"""Lidars, range sensors and point clouds."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np
from bullet_sim.plugins.lidars import BlockCloudSpec, CloudSpec, RangeSpec, RaySpec
from bullet_sim.pose import Array
from bullet_sim.sensors.errors import SensorErrors
from bullet_sim.sensors.lidar import LayeredLidar, Lidar
from geometry_msgs.msg import Point32
from sensor_msgs.msg import ChannelFloat32, LaserScan, PointCloud, PointCloud2, PointField, Range

from bullet_bridge.plugins.base import PluginContext, Sensor, ros_side
from bullet_bridge.transport import conversions
from bullet_bridge.transport.packed import PackedScan


class RaysSensor(Sensor):
    """Casts the rays of a lidar, all of a scan at one time.

    Attributes:
        lidar: class of the core's lidar.
    """

    lidar: ClassVar[type[Lidar]] = Lidar

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._lidar: Any = self.lidar(self.spec)

    def _scan(self) -> Array:
        position, orientation, _, _ = self.model.link_motion(self.spec.link)
        return self._lidar.scan(
            self.world.visible if self.spec.sees_visuals else self.world.engine,
            position,
            orientation,
            self.rng,
            self.model.body,
        )

    def _intensities(self) -> Array | None:
        """Of the last scan; None: all are 0."""
        found: Array | None = self._lidar.intensities(self.world.models.values())
        return found


@ros_side(RaySpec)
class LidarSensor(RaysSensor):
    """sensor_msgs/LaserScan."""

    message = LaserScan

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._sender = PackedScan(
            self.pub, self.spec, self._lidar.angle_increment, len(self._lidar.angles)
        )

    def update(self, time: float, period: float) -> None:
        self._sender.send(time, self._scan(), self._intensities())


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
    time: float, spec: CloudSpec, points: Array, rings: Array, intensities: Array | None = None
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


@ros_side(CloudSpec)
class CloudSensor(RaysSensor):
    """sensor_msgs/PointCloud2 of a velodyne."""

    message, lidar = PointCloud2, LayeredLidar
    relayed = False

    def measure(self, time: float) -> PointCloud2:
        points, found = self._lidar.points(self._scan()), self._intensities()
        if self.spec.min_intensity > -math.inf:
            values = np.zeros(len(points)) if found is None else found
            points = np.where((values < self.spec.min_intensity)[:, None], math.nan, points)
        return velodyne_cloud(time, self.spec, points, self._lidar.rings, found)


@ros_side(BlockCloudSpec)
class BlockLaserSensor(RaysSensor):
    """sensor_msgs/PointCloud of libgazebo_ros_block_laser: hits only."""

    message, lidar = PointCloud, LayeredLidar
    relayed = False

    def measure(self, time: float) -> PointCloud:
        points = self._lidar.points(self._scan())
        hit, found = np.isfinite(points).all(axis=1), self._intensities()
        values = np.zeros(len(points)) if found is None else found
        points, values = points[hit], values[hit].tolist()
        return PointCloud(
            header=conversions.header(time, self.spec.frame_id),
            points=[Point32(*point) for point in points.tolist()],
            channels=[ChannelFloat32(name="intensity", values=values)],
        )


@ros_side(RangeSpec)
class RangeSensor(RaysSensor):
    """sensor_msgs/Range: the closest hit, max_range where there is none."""

    STATE = ("_errors", "_measured")
    message, lidar = Range, LayeredLidar

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._errors = SensorErrors(self.spec.errors)

    def reset(self, time: float) -> None:
        """With random errors, as its drift gives them."""
        super().reset(time)
        self._measured = time
        self._errors.restart(self.rng)

    def measure(self, time: float) -> Range:
        spec, ranges = self.spec, self._scan()
        elapsed, self._measured = time - self._measured, time
        minimum = float(np.clip(ranges.min(), spec.range_min, spec.range_max))
        if minimum < spec.range_max:
            minimum = self._errors.measured((minimum,) * 3, elapsed, self.rng)[0]
            minimum = float(np.clip(minimum, spec.range_min, spec.range_max))
        return Range(
            header=conversions.header(time, spec.frame_id),
            radiation_type=Range.INFRARED if spec.infrared else Range.ULTRASOUND,
            field_of_view=spec.field_of_view,
            min_range=spec.range_min,
            max_range=spec.range_max,
            range=minimum,
        )

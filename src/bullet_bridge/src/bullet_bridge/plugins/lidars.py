"""Lidars, range sensors and point clouds."""

from __future__ import annotations

import io
import itertools
import os
from typing import Any

import numpy as np
import rospkg
from bullet_sim.errors import ModelError, SimError
from bullet_sim.files import read_unpacked
from bullet_sim.parts.outputs import PointsOutput
from bullet_sim.plugins import lidars as core
from bullet_sim.pose import Array, Pose
from bullet_sim.sensors.lidar import PatternLidar
from sensor_msgs.msg import PointCloud, PointCloud2
from tf2_msgs.msg import TFMessage

from bullet_bridge.plugins.base import PluginContext, Sensor, ros_side
from bullet_bridge.transport import conversions
from bullet_bridge.transport.packed import PackedCloud
from bullet_bridge.transport.senders import Converted, sends

# velodyne_gazebo_plugins' layout of a point.
_POINT, _FIELDS = conversions.point_layout(
    22, ("intensity", 12, "<f4"), ("ring", 16, "<u2"), ("time", 18, "<f4")
)


def velodyne_cloud(
    time: float,
    spec: core.CloudSpec,
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


@sends(PointsOutput)
def _points(part: Any, output: PointsOutput) -> Any:
    if output.message == "sensor_msgs/PointCloud":
        pub = part.publisher(output.topic, PointCloud, relayed=False)
        return PackedCloud(pub, output.spec.frame_id)
    pub = part.publisher(output.topic, PointCloud2, relayed=False)
    return Converted(pub, lambda time, *values: velodyne_cloud(time, output.spec, *values))


# livox_laser_simulation's layouts of a point.
_XYZ, _XYZ_FIELDS = conversions.point_layout(16)
_XYZRTL, _XYZRTL_FIELDS = conversions.point_layout(
    32, ("reflectivity", 16, "<f4"), ("tag", 20, "u1"), ("line", 21, "u1")
)
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


@ros_side(core.PatternSpec)
class PatternSensor(Sensor, core.RaysSensor):
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
        self._cloud = PackedCloud(self.pub, self.spec.frame_id)

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

    def _make_lidar(self, spec: Any) -> PatternLidar:
        return PatternLidar(spec, _read_pattern_of(spec.pattern))

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
            self._cloud.send(time, points)
            return None
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

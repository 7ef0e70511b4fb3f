"""Lidars, range sensors and point clouds."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from bullet_sim.parts.base import Sensor, part_of
from bullet_sim.parts.errors import TunedSensor
from bullet_sim.parts.outputs import NumbersOutput, PointsOutput, ScanOutput
from bullet_sim.plugins import lidars as specs
from bullet_sim.pose import Array
from bullet_sim.sensors.errors import SensorErrors
from bullet_sim.sensors.lidar import LayeredLidar, Lidar


class RaysSensor(Sensor):
    """Casts the rays of a lidar, all of a scan at one time.

    Attributes:
        lidar: class of the core's lidar.
        too_near: what is nearer than the minimum range has the range -inf; False: rays begin there.
        bias: added to all ranges [m].
    """

    STATE: ClassVar[tuple[str, ...]] = ("bias",)
    lidar: ClassVar[type[Lidar]] = Lidar
    too_near: ClassVar[bool] = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._lidar: Any = self._make_lidar()

    def _make_lidar(self) -> Any:
        return self.lidar(self.spec)

    def start(self, time: float) -> None:
        """Draw the bias, as GaussianNoiseModel of Gazebo: with either sign."""
        self.bias = 0.0  # [m]
        if any(self.spec.bias):
            sign = -1.0 if self.rng.random() < 0.5 else 1.0
            self.bias = sign * float(self.rng.normal(*self.spec.bias))

    def _scan(self) -> Array:
        position, orientation, _, _ = self.model.link_motion(self.spec.link)
        return self._lidar.scan(
            self.world.visible if self.spec.sees_visuals else self.world.engine,
            position,
            orientation,
            self.rng,
            self.model.body.number,
            self.too_near,
            self.bias,
        )

    def _intensities(self) -> Array | None:
        """Of the last scan; None: all are 0."""
        intensities: Array | None = self._lidar.intensities(self.world.models.values())
        return intensities


@part_of(specs.RaySpec)
class LidarSensor(RaysSensor):
    """sensor_msgs/LaserScan; of several layers all ranges, layer by layer, as upstream."""

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._layers = self.spec.layers if isinstance(self.spec, specs.LayeredScanSpec) else 1
        count = len(self._lidar.angles) * self._layers
        increment = self._lidar.angle_increment
        self._sender = self.output(ScanOutput(self.spec.topic, self.spec, increment, count))

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


@part_of(specs.CloudSpec)
class CloudSensor(RaysSensor):
    """sensor_msgs/PointCloud2 of a velodyne."""

    lidar = LayeredLidar

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        output = PointsOutput(self.spec.topic, self.spec, len(self._lidar.rings))
        self._sender = self.output(output)

    def update(self, time: float, period: float) -> None:
        points, intensities = self._lidar.points(self._scan()), self._intensities()
        if self.spec.min_intensity > -math.inf:
            values = np.zeros(len(points)) if intensities is None else intensities
            points = np.where((values < self.spec.min_intensity)[:, None], math.nan, points)
        self._sender.send(time, points, self._lidar.rings, intensities)


@part_of(specs.BlockCloudSpec)
class BlockLaserSensor(RaysSensor):
    """sensor_msgs/PointCloud of libgazebo_ros_block_laser: a point of each ray, layer by layer.

    As upstream's: where nothing was hit beyond the minimum range it is at the maximum range,
    without noise; each is half a ray's angle beyond its ray, but that of the last one; with a
    single ray or layer all are NaN.
    Its intensity is the mean of four rays': the next one's and the next layer's count as well.
    """

    lidar, too_near = LayeredLidar, False
    CACHE: ClassVar[tuple[str, ...]] = ("_aims",)

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec, count = self.spec, len(self._aims)
        self._sender = self.output(PointsOutput(spec.topic, spec, count, "sensor_msgs/PointCloud"))

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

    def update(self, time: float, period: float) -> None:
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
        self._sender.send(time, points, values)


_FARTHEST = 1e-6  # [m] a range that is closer to the maximum has no noise in block_laser


def _half_a_ray_beyond(first: float, last: float, count: int) -> Array:
    """Angles (count,) [rad] as block_laser has them; NaN for a single one."""
    if count == 1:
        return np.full(1, math.nan)
    rays = np.arange(count)
    return first + 0.5 * (rays + np.minimum(rays + 1, count - 1)) * (last - first) / (count - 1)


@part_of(specs.RangeSpec)
class RangeSensor(RaysSensor, TunedSensor):
    """sensor_msgs/Range: the closest hit, max_range where there is none."""

    lidar = LayeredLidar

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self.errors = (SensorErrors(self.spec.errors),)
        self._sender = self.output(
            NumbersOutput(self.spec.topic, self.spec, "sensor_msgs/Range", "range")
        )

    @property
    def resets_with_model(self) -> bool:
        """hector's sonar alone has a Reset()."""
        return bool(self.spec.tunable)

    def tuned(self) -> dict[str, SensorErrors]:
        return {self.spec.topic: self.errors[0]} if self.spec.tunable else {}

    def update(self, time: float, period: float) -> None:
        spec, ranges, elapsed = self.spec, self._scan(), self.elapsed(time)
        minimum = float(np.clip(ranges.min(), spec.range_min, spec.range_max))
        if minimum < spec.range_max:
            minimum = self.errors[0].measured((minimum,) * 3, elapsed, self.rng)[0]
            lowest = spec.range_min if spec.limited else -math.inf
            minimum = float(np.clip(minimum, lowest, spec.range_max))
        self._sender.send(time, (minimum,))

"""Lidars and range sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.parts.base import Sensor, part_of
from bullet_sim.parts.outputs import NumbersOutput, PointsOutput, ScanOutput
from bullet_sim.plugins.errors import TunedSensor, sensor_errors
from bullet_sim.plugins.registry import sensor_plugin
from bullet_sim.plugins.rules import NAMESPACE, PLAIN, ROOT, UTILS_OF_SENSORS, Rule
from bullet_sim.plugins.spec import SensorSpec, read, reading
from bullet_sim.plugins.xml import SensorXml, Values
from bullet_sim.pose import Array
from bullet_sim.sensors.errors import ErrorModel, SensorErrors
from bullet_sim.sensors.lidar import LayeredLidar, Lidar
from bullet_sim.xml_reader import child_text, is_true, warn_replaced

TYPES = ("ray", "gpu_ray")  # of <sensor>
DEFAULT_MAX_RANGE = 100.0  # [m] of a lidar whose file gives no valid one


@dataclass(frozen=True)
class RaySpec(SensorSpec):
    """A lidar; angles [rad] about +z from +x, counter-clockwise, ranges [m].

    As in Gazebo its rays go from min_angle to max_angle, whichever is smaller; a LaserScan has the
    ranges of all layers, one after the other from the first.

    Attributes:
        rate: scans per simulated second [Hz].
        noise_stddev, noise_mean: of Gaussian noise on ranges [m].
        bias: mean and standard deviation of what is added to all of them [m]: it is drawn at the
            start, with a random sign.
        precision: to a multiple of which ranges with noise are rounded [m]; 0: they are not.
        sees_visuals: it sees what a camera would see, not what collides (gpu_ray).
        layers: number of rays above each other.
        min_elevation, max_elevation: of the first and the last layer [rad], positive up.
    """

    samples: int = 360
    min_angle: float = -3.14159265
    max_angle: float = 3.14159265
    range_min: float = 0.1
    range_max: float = 10.0
    rate: float = reading(lambda xml: xml.output_rate(None), 10.0)
    noise_stddev: float = 0.0
    topic: str = "/scan"
    frame_id: str = reading(lambda xml: xml.frame("frameName", "/world"), "laser")
    visualize: bool = reading(lambda xml: is_true(child_text(xml.sensor, "visualize")), False)
    noise_mean: float = 0.0
    bias: tuple[float, float] = (0.0, 0.0)
    precision: float = 0.0
    sees_visuals: bool = reading(lambda xml: xml.type == "gpu_ray", False)
    layers: int = 1
    min_elevation: float = 0.0
    max_elevation: float = 0.0


@dataclass(frozen=True)
class CloudSpec(RaySpec):
    """A velodyne: PointCloud2 with x, y, z, intensity, ring, time.

    Attributes:
        organized: PointCloud2 of one row a layer, NaN where nothing was hit; else hits only.
        min_intensity: below which a point is none.
    """

    organized: bool = False
    min_intensity: float = -math.inf


@dataclass(frozen=True)
class BlockCloudSpec(RaySpec):
    """A lidar that publishes its points as PointCloud, as libgazebo_ros_block_laser.

    Attributes:
        point_noise: standard deviation on each coordinate [m] and intensity; its rays have none.
    """

    point_noise: float = 0.0


@dataclass(frozen=True)
class PatternSpec(RaySpec):
    """liblivox_laser_simulation: each scan has the next rays of a pattern; samples are its rays.

    Attributes:
        pattern: URI of a CSV file of rays: time, azimuth and zenith [deg].
        taken, step: rays of the pattern that a scan goes on, of which it has each step-th.
        fields: (lowest angle [rad], between two rows [rad], rows) of azimuth and of elevation,
            outside of which hits are left out.
        message: 0: PointCloud, 1: PointCloud2, 2: with reflectivity, 3: livox_ros_driver/CustomMsg.
        shift: added to all ranges [m], as upstream does it.
    """

    pattern: str = ""
    taken: int = 0
    step: int = 1
    fields: tuple[tuple[float, float, int], tuple[float, float, int]] = ((0.0, 0.0, 1),) * 2
    message: int = 0
    shift: float = 0.0


@dataclass(frozen=True)
class RangeSpec(RaySpec):
    """A sonar or infrared sensor: the minimum range of a bundle of rays, as sensor_msgs/Range.

    Attributes:
        infrared: True: infrared; False: ultrasound.
        field_of_view: written into the message [rad].
        errors: of the range [m], all three alike, where it is below the maximum.
        limited: the range with its errors is not below the minimum.
        tunable: dynamic_reconfigure changes the errors.
    """

    infrared: bool = False
    field_of_view: float = 0.05
    errors: ErrorModel = ErrorModel()
    limited: bool = True
    tunable: bool = False


def scan_range(ray: Values) -> tuple[float, float]:
    """(minimum, maximum) range of a lidar [m]."""
    near, far = ray.number("range/min"), ray.number("range/max", DEFAULT_MAX_RANGE)
    if 0.0 <= near < far:
        return near, far
    used = (max(0.0, near), far if far > max(0.0, near) else max(0.0, near) + DEFAULT_MAX_RANGE)
    label = f"{ray.label} <range>"
    message = f"{label} is {near:g} to {far:g}, must be 0 or more, the smaller first"
    warn_replaced(ray.element.find("range"), label, f"{near:g} {far:g}", message, used)
    return used


def rays_of(ray: Values, axis: str, samples: int) -> int:
    """Number of rays of a <scan> along an axis: <samples> times <resolution>, as in Gazebo."""
    resolution = ray.number(f"scan/{axis}/resolution", 1.0)
    count = ray.whole(f"scan/{axis}/samples", samples)
    return max(1, int(count * resolution)) if resolution > 0.0 else count


def rays(xml: SensorXml, samples: int = 1) -> dict[str, Any]:
    """Angles, ranges, layers and noise of <ray>; samples: default number of rays."""
    ray = xml.part("ray", "lidar")
    mean, stddev = ray.noise("noise")
    first, last = (ray.number(f"scan/horizontal/{end}_angle") for end in ("min", "max"))
    names = ("bias_mean", "bias_stddev", "precision") if ray.has_noise("noise") else ()
    noise = {name: ray.number(f"noise/{name}") for name in names}
    near, far = scan_range(ray)
    return dict(
        samples=rays_of(ray, "horizontal", samples),
        min_angle=first,
        max_angle=last,
        range_min=near,
        range_max=far,
        layers=rays_of(ray, "vertical", 1),
        min_elevation=ray.number("scan/vertical/min_angle"),
        max_elevation=ray.number("scan/vertical/max_angle"),
        noise_mean=mean,
        noise_stddev=stddev,
        bias=(noise.get("bias_mean", 0.0), abs(noise.get("bias_stddev", 0.0))),
        precision=max(0.0, noise.get("precision", 0.0)),
    )


@sensor_plugin("gazebo_ros_laser", "gazebo_ros_gpu_laser", types=TYPES, rule=UTILS_OF_SENSORS)
def laser(xml: SensorXml) -> RaySpec:
    """RaySpec; the laser plugins have no <updateRate> and no <gaussianNoise>."""
    return read(RaySpec, xml, **rays(xml, 640), topic=xml.topic("topicName", "/world"))


@sensor_plugin(
    "gazebo_ros_velodyne_laser",
    "gazebo_ros_velodyne_gpu_laser",
    types=TYPES,
    rule=Rule(ROOT, ROOT, NAMESPACE),
)
def velodyne(xml: SensorXml) -> CloudSpec:
    """CloudSpec; min_range, max_range narrow the ray's."""
    values, plugin = rays(xml), xml.plugin("lidar")
    near, far = plugin.number("min_range"), plugin.number("max_range", float("inf"))
    values["range_min"] = max(values["range_min"], near)
    values["range_max"] = min(values["range_max"], far)
    values["noise_stddev"] = math.hypot(values["noise_stddev"], plugin.number("gaussianNoise"))
    return read(
        CloudSpec,
        xml,
        **values,
        topic=xml.topic("topicName", "/points"),
        organized=is_true(xml.text("organize_cloud")),
        min_intensity=plugin.number("min_intensity", -math.inf),
    )


def _raw(xml: SensorXml) -> dict[str, Any]:
    """As rays(), for plugins that read the ranges before the sensor adds its noise."""
    return dict(rays(xml), noise_mean=0.0, noise_stddev=0.0, bias=(0.0, 0.0), precision=0.0)


@sensor_plugin("gazebo_ros_block_laser", types=TYPES, rule=PLAIN)
def block_laser(xml: SensorXml) -> BlockCloudSpec:
    """BlockCloudSpec; upstream reads <updateRate> and uses it nowhere."""
    noise = abs(xml.plugin("lidar").number("gaussianNoise"))
    topic = xml.topic("topicName", "/world")
    return read(BlockCloudSpec, xml, **_raw(xml), topic=topic, point_noise=noise)


@sensor_plugin("gazebo_ros_range", types=TYPES, rule=PLAIN)
def range_sensor(xml: SensorXml) -> RangeSpec:
    plugin = xml.plugin("range sensor")
    radiation = "ultrasound" if xml.element.find("radiation") is None else xml.text("radiation")
    return read(
        RangeSpec,
        xml,
        **_raw(xml),
        rate=xml.output_rate(),
        topic=xml.topic("topicName", "/range"),
        infrared=radiation != "ultrasound",
        field_of_view=plugin.number("fov", 0.05),
        errors=ErrorModel(noise=(abs(plugin.number("gaussianNoise")),) * 3),
        limited=False,
    )


@sensor_plugin("hector_gazebo_ros_sonar", types=TYPES)
def sonar(xml: SensorXml) -> RangeSpec:
    """RangeSpec; its field of view is the smaller of both angles.

    Its rate is the plugin's <updateRate>, 10 Hz without one; that of the <sensor> has no effect.
    """
    values = rays(xml)
    wide = abs(values["max_angle"] - values["min_angle"])
    high = abs(values["max_elevation"] - values["min_elevation"])
    return read(
        RangeSpec,
        xml,
        **values,
        rate=max(0.0, xml.plugin("sonar").number("updateRate", 10.0)),
        topic=xml.topic("topicName", "sonar"),
        frame_id=xml.frame("frameId", "/sonar_link"),
        field_of_view=min((angle for angle in (wide, high) if angle > 0.0), default=0.0),
        errors=sensor_errors(xml),
        tunable=True,
    )


@sensor_plugin("livox_laser_simulation", types=("ray",))
def livox(xml: SensorXml) -> PatternSpec:
    """PatternSpec; the numbers are in the plugin's own <ray>, and none of its noise is added.

    Raises:
        ModelError: without <ray>, <csv_file_name>, <samples> or <ros_topic>, or with angles of one
            row alone.
    """
    plugin, element = xml.plugin("livox"), xml.element.find("ray")
    missing = [tag for tag in ("csv_file_name", "samples", "ros_topic") if not xml.text(tag)]
    if element is None or missing:
        raise ModelError(f"{plugin.label} has no {', '.join(missing) or 'ray'} in its plugin")
    ray = Values(element, plugin.label)
    fields = []
    for axis in ("horizontal", "vertical"):
        low, high = (ray.number(f"scan/{axis}/{end}_angle") for end in ("min", "max"))
        rows = rays_of(ray, axis, 1)
        if rows < 2 or high <= low:
            raise ModelError(f"{plugin.label} <{axis}> has {rows} samples, must be at least 2")
        fields.append((low, (high - low) / (rows - 1), rows))
    near, far = scan_range(ray)
    taken, step = plugin.whole("samples", 1), plugin.whole("downsample", 1)
    return read(
        PatternSpec,
        xml,
        samples=-(-taken // step),
        min_angle=0.0,
        max_angle=0.0,
        range_min=0.0,  # its rays begin at the sensor, and are as long as if at the minimum
        range_max=far - near,
        shift=near,
        topic="/" + xml.text("ros_topic").strip("/"),
        frame_id=xml.name,
        pattern=xml.text("csv_file_name"),
        taken=taken,
        step=step,
        fields=(fields[0], fields[1]),
        message=int(plugin.number("publish_pointcloud_type")),
        sees_visuals=False,
    )


class RaysSensor(Sensor):
    """Casts the rays of a lidar, all of a scan at one time.

    Attributes:
        lidar: class of the core's lidar.
        bias: added to all ranges [m].
    """

    STATE: ClassVar[tuple[str, ...]] = ("bias",)
    lidar: ClassVar[type[Lidar]] = Lidar

    def __init__(self, context: Any) -> None:
        self._lidar = self._make_lidar(context.spec)
        spec = context.spec
        # gpu_ray is updated with the cameras, hector's sonar has an UpdateTimer
        self.whole_periods = not (spec.sees_visuals or getattr(spec, "tunable", False))
        super().__init__(context)

    def _make_lidar(self, spec: Any) -> Any:
        return self.lidar(spec)

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
            self.bias,
        )

    def _intensities(self) -> Array | None:
        """Of the last scan; None: all are 0."""
        intensities: Array | None = self._lidar.intensities(self.world.models.values())
        return intensities


@part_of(RaySpec)
class LidarSensor(RaysSensor):
    """sensor_msgs/LaserScan; of several layers all ranges, layer by layer, as upstream."""

    def make_output(self) -> ScanOutput:
        spec, lidar = self.spec, self._lidar
        count = len(lidar.angles) * spec.layers
        return ScanOutput(spec.topic, spec, lidar.angle_increment, count)

    def _make_lidar(self, spec: Any) -> Any:
        return (LayeredLidar if spec.layers > 1 else Lidar)(spec)

    def measure(self, time: float) -> Any:
        ranges, intensities = self._scan(), self._intensities()
        ranges = _by_layers(ranges, self.spec.layers)
        if intensities is not None:
            intensities = _by_layers(intensities, self.spec.layers)
        return ranges, intensities


def _by_layers(values: Array, layers: int) -> Array:
    """Values (n,) of a LayeredLidar's rays, layer by layer instead of direction by direction."""
    return values.reshape(-1, layers).T.ravel()


def _with_next(values: Array, layers: int) -> Array:
    """Means (n,) of each value, the next one of its layer and both of the next layer."""
    rows = np.pad(values.reshape(layers, -1), ((0, 1), (0, 1)), mode="edge")
    means: Array = 0.25 * (rows[:-1, :-1] + rows[:-1, 1:] + rows[1:, :-1] + rows[1:, 1:])
    return means.ravel()


@part_of(CloudSpec)
class CloudSensor(RaysSensor):
    """sensor_msgs/PointCloud2 of a velodyne."""

    lidar = LayeredLidar

    def make_output(self) -> PointsOutput:
        return PointsOutput(self.spec.topic, self.spec, len(self._lidar.rings))

    def measure(self, time: float) -> Any:
        points, intensities = self._lidar.points(self._scan()), self._intensities()
        if self.spec.min_intensity > -math.inf:
            values = np.zeros(len(points)) if intensities is None else intensities
            points = np.where((values < self.spec.min_intensity)[:, None], math.nan, points)
        return points, self._lidar.rings, intensities


@part_of(BlockCloudSpec)
class BlockLaserSensor(RaysSensor):
    """sensor_msgs/PointCloud of libgazebo_ros_block_laser: a point of each ray, layer by layer.

    As upstream's: where nothing was hit beyond the minimum range it is at the maximum range,
    without noise; each is half a ray's angle beyond its ray, but that of the last one; with a
    single ray or layer all are NaN.
    Its intensity is the mean of four rays': the next one's and the next layer's count as well.
    """

    lidar = LayeredLidar
    CACHE: ClassVar[tuple[str, ...]] = ("_aims",)

    def make_output(self) -> PointsOutput:
        count = len(self._aims)
        return PointsOutput(self.spec.topic, self.spec, count, "sensor_msgs/PointCloud")

    def _make_lidar(self, spec: Any) -> Any:
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
        return super()._make_lidar(spec)

    def measure(self, time: float) -> Any:
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
        return points, values


_FARTHEST = 1e-6  # [m] a range that is closer to the maximum has no noise in block_laser


def _half_a_ray_beyond(first: float, last: float, count: int) -> Array:
    """Angles (count,) [rad] as block_laser has them; NaN for a single one."""
    if count == 1:
        return np.full(1, math.nan)
    rays = np.arange(count)
    return first + 0.5 * (rays + np.minimum(rays + 1, count - 1)) * (last - first) / (count - 1)


@part_of(RangeSpec)
class RangeSensor(RaysSensor, TunedSensor):
    """sensor_msgs/Range: the closest hit, max_range where there is none."""

    lidar = LayeredLidar

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self.errors = (SensorErrors(self.spec.errors),)

    def make_output(self) -> NumbersOutput:
        spec = self.spec
        constant = {
            "radiation_type": int(spec.infrared),
            "field_of_view": spec.field_of_view,
            "min_range": spec.range_min,
            "max_range": spec.range_max,
        }
        fields = {"range": 1}
        return NumbersOutput(spec.topic, "sensor_msgs/Range", fields, spec.frame_id, constant)

    @property
    def resets_with_model(self) -> bool:
        """hector's sonar alone has a Reset()."""
        return bool(self.spec.tunable)

    def tuned(self) -> dict[str, SensorErrors]:
        return {self.spec.topic: self.errors[0]} if self.spec.tunable else {}

    def measure(self, time: float) -> Any:
        spec, ranges, (period, times) = self.spec, self._scan(), self.elapsed(time)
        minimum = float(np.clip(ranges.min(), spec.range_min, spec.range_max))
        if minimum < spec.range_max:
            minimum = self.errors[0].measured((minimum,) * 3, period, times, self.rng)[0]
            lowest = spec.range_min if spec.limited else -math.inf
            minimum = float(np.clip(minimum, lowest, spec.range_max))
        return ((float(np.float32(minimum)),),)  # as the message has it

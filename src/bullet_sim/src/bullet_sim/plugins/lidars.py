"""Lidars and range sensors: their specifications, read from SDF and plugins."""

from dataclasses import dataclass

from bullet_sim.plugins import cameras
from bullet_sim.plugins.xml import ZERO_POSE, PoseTuple, noise_of
from bullet_sim.xml_reader import child_number, child_text, child_whole, is_true


@dataclass(frozen=True)
class RaySpec:
    """A planar lidar; angles [rad] about +z from +x, counter-clockwise, ranges [m].

    Attributes:
        rate: scans per simulated second [Hz].
        noise_stddev, noise_mean: of Gaussian noise on ranges [m].
    """

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    samples: int = 360
    min_angle: float = -3.14159265
    max_angle: float = 3.14159265
    range_min: float = 0.1
    range_max: float = 10.0
    rate: float = 10.0
    noise_stddev: float = 0.0
    topic: str = "/scan"
    frame_id: str = "laser"
    visualize: bool = False
    noise_mean: float = 0.0


@dataclass(frozen=True)
class CloudSpec(RaySpec):
    """A lidar of one or several layers that publishes points as sensor_msgs/PointCloud2.

    Attributes:
        layers: rays above each other.
        min_elevation, max_elevation: of the lowest and the highest layer [rad], positive up.
        organized: PointCloud2 of one row a layer, NaN where nothing was hit; else hits only.
    """

    layers: int = 1
    min_elevation: float = 0.0
    max_elevation: float = 0.0
    organized: bool = False


@dataclass(frozen=True)
class BlockCloudSpec(CloudSpec):
    """The lidar of libgazebo_ros_block_laser.so, which publishes sensor_msgs/PointCloud."""


@dataclass(frozen=True)
class RangeSpec(RaySpec):
    """A sonar or infrared sensor: the nearest hit of a bundle of rays, as sensor_msgs/Range.

    Attributes:
        layers, min_elevation, max_elevation: as CloudSpec's.
        infrared: True: infrared; False: ultrasound.
        field_of_view: written into the message [rad].
    """

    layers: int = 1
    min_elevation: float = 0.0
    max_elevation: float = 0.0
    infrared: bool = False
    field_of_view: float = 0.05


def _scan(sensor, samples):
    """Values that all of them share, from <ray>; `samples` where it names none."""
    what = f"lidar '{sensor.name}'"
    ray = sensor.part("ray")
    first, last = cameras.sweep(ray, what)
    near, far = cameras.reach(ray, what)
    return dict(
        name=sensor.name,
        link=sensor.link,
        pose=sensor.pose,
        samples=child_whole(ray, "scan/horizontal/samples", what, samples),
        min_angle=first,
        max_angle=last,
        range_min=near,
        range_max=far,
        visualize=is_true(child_text(sensor.element, "visualize", "false")),
    )


def _layers(sensor):
    """As _scan, with layers and noise."""
    what = f"lidar '{sensor.name}'"
    ray = sensor.part("ray")
    return dict(
        _scan(sensor, 1),
        layers=child_whole(ray, "scan/vertical/samples", what, 1),
        min_elevation=child_number(ray, "scan/vertical/min_angle", what, 0.0),
        max_elevation=child_number(ray, "scan/vertical/max_angle", what, 0.0),
        noise_mean=child_number(ray, "noise/mean", what, 0.0),
        noise_stddev=abs(child_number(ray, "noise/stddev", what, 0.0)),
    )


def _sent(sensor, what, values, topic, rate_tag="updateRate"):
    """The values of _layers with the plugin's noise, rate and topic."""
    noise = values["noise_stddev"]
    return dict(
        values,
        noise_stddev=noise or abs(child_number(sensor.plugin, "gaussianNoise", what, 0.0)),
        rate=sensor.drawn_rate(tag=rate_tag),
        topic=sensor.names.text_topic("topicName", topic),
    )


def _frame(sensor, default="/world"):
    return sensor.names.frame(child_text(sensor.plugin, "frameName", default))


def laser(sensor):
    """RaySpec of libgazebo_ros_laser.so."""
    what = f"lidar '{sensor.name}'"
    ray = sensor.part("ray")
    if child_number(ray, "scan/vertical/samples", what, 1) > 1:
        sensor.model.warn(f"{what} has several layers (<vertical>); only the level one is scanned")
    mean, stddev = noise_of(ray, "noise", what)
    return RaySpec(
        **_scan(sensor, 640),
        rate=sensor.drawn_rate(tag="-"),  # the laser plugins ignore <updateRate>
        noise_stddev=stddev or child_number(sensor.plugin, "gaussianNoise", what, 0.0),
        noise_mean=mean,
        topic=sensor.names.text_topic("topicName", "/world"),
        frame_id=_frame(sensor),
    )


def velodyne(sensor):
    """CloudSpec of libgazebo_ros_velodyne_laser.so; min_range, max_range narrow the ray's."""
    what = f"lidar '{sensor.name}'"
    values = _layers(sensor)
    nearest = child_number(sensor.plugin, "min_range", what, 0.0)
    farthest = child_number(sensor.plugin, "max_range", what, float("inf"))
    values.update(
        range_min=max(values["range_min"], nearest), range_max=min(values["range_max"], farthest)
    )
    return CloudSpec(
        **_sent(sensor, what, values, "/velodyne_points", rate_tag="-"),
        frame_id=_frame(sensor, "/velodyne"),
        organized=is_true(child_text(sensor.plugin, "organize_cloud", "false")),
    )


def block_laser(sensor):
    """BlockCloudSpec of libgazebo_ros_block_laser.so."""
    values = _sent(sensor, f"lidar '{sensor.name}'", _layers(sensor), "/world")
    return BlockCloudSpec(**values, frame_id=_frame(sensor))


def range_sensor(sensor):
    """RangeSpec of libgazebo_ros_range.so."""
    what = f"range sensor '{sensor.name}'"
    return RangeSpec(
        **_sent(sensor, what, _layers(sensor), "/range"),
        frame_id=_frame(sensor),
        infrared=child_text(sensor.plugin, "radiation", "infrared").lower() != "ultrasound",
        field_of_view=child_number(sensor.plugin, "fov", what, 0.05),
    )


def sonar(sensor):
    """RangeSpec of libhector_gazebo_ros_sonar.so; its field of view is the narrower of both."""
    values = _layers(sensor)
    wide = values["max_angle"] - values["min_angle"]
    high = values["max_elevation"] - values["min_elevation"]
    angles = [angle for angle in (wide, high) if angle > 0.0]
    return RangeSpec(
        **_sent(sensor, f"sonar '{sensor.name}'", values, "sonar"),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameId", sensor.link), False),
        infrared=False,
        field_of_view=min(angles, default=0.0),
    )

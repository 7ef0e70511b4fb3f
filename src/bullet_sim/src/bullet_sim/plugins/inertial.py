"""IMU, GPS, magnetometer, ground truth: their specifications, read from SDF and plugins."""

import math
from dataclasses import dataclass
from typing import Any

from bullet_sim.plugins.registry import model_plugin, sensor_plugin
from bullet_sim.plugins.xml import ZERO, ZERO_POSE, Names, PluginXml, PoseTuple, SensorXml, Values
from bullet_sim.xml_reader import is_true


@dataclass(frozen=True)
class ImuSpec:
    """An inertial measurement unit; rates [rad/s] and accelerations [m/s^2] in its own frame.

    Attributes:
        rate: messages per simulated second [Hz]; 0: every physics step.
        variance: on the diagonals of the covariances.
    """

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    rate: float = 100.0
    topic: str = "/imu"
    frame_id: str = "imu_link"
    gyro_noise_stddev: float = 0.0
    accel_noise_stddev: float = 0.0
    gyro_noise_mean: float = 0.0
    accel_noise_mean: float = 0.0
    variance: float = 0.0


@dataclass(frozen=True)
class GroundTruthSpec:
    """Pose and velocity of a link without error, as libgazebo_ros_p3d publishes it.

    Attributes:
        link: link whose frame is reported.
        frame_id: the world frame's name in the header.
        rate: messages per simulated second [Hz]; 0: every physics step.
        child_frame_id: the link's name in the message.
        twist_in_child: True: twist in the child frame, as nav_msgs/Odometry asks; False: along
            the world's axes, as upstream's plugin gives it.
        pose: (xyz [m], rpy [rad]) of the reported frame in the link frame.
    """

    link: str
    topic: str
    frame_id: str = "world"
    rate: float = 50.0
    twist_in_child: bool = False
    child_frame_id: str = "base_link"
    noise_stddev: float = 0.0
    pose: PoseTuple = ZERO_POSE


@dataclass(frozen=True)
class GpsSpec:
    """A GPS receiver; x of the world points along reference_heading, y to the left of it.

    Attributes:
        rate: fixes per simulated second [Hz]; 0: every physics step.
        topic, velocity_topic: NavSatFix and Vector3Stamped.
        latitude, longitude: of the world's origin [degrees]; altitude [m].
        heading: of the world's x axis [rad], clockwise from north.
        status, service: of NavSatStatus.
        noise_stddev: of Gaussian noise on x, y, z [m].
        velocity_noise_stddev: on the velocities [m/s].
        offset: constant error [m].
    """

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    rate: float = 4.0
    topic: str = "/fix"
    velocity_topic: str = "/fix_velocity"
    frame_id: str = "world"
    latitude: float = 49.860246
    longitude: float = 8.687077
    altitude: float = 0.0
    heading: float = 0.0
    status: int = 0
    service: int = 1
    noise_stddev: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity_noise_stddev: tuple[float, float, float] = (0.0, 0.0, 0.0)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class MagneticSpec:
    """A magnetometer in the earth's field.

    Attributes:
        rate: messages per simulated second [Hz]; 0: every physics step.
        magnitude: of the field, in the message's unit.
        heading: of the world's x axis [rad], clockwise from north.
        declination, inclination: of the field [rad]; inclination positive downwards.
        field_message: MagneticField instead of Vector3Stamped.
        noise_stddev, offset: along the sensor's axes.
    """

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    rate: float = 0.0
    topic: str = "/magnetic"
    frame_id: str = "base_link"
    magnitude: float = 0.44
    heading: float = 0.0
    declination: float = 0.0
    inclination: float = math.radians(60.0)
    field_message: bool = False
    noise_stddev: tuple[float, float, float] = (0.0, 0.0, 0.0)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)


def _offset(xml: PluginXml) -> PoseTuple:
    """Pose of <xyzOffset> and <rpyOffset>, or <xyzOffsets> and <rpyOffsets>."""
    xyz, rpy = (
        xml.vector(tag, default=xml.vector(f"{tag}s")) for tag in ("xyzOffset", "rpyOffset")
    )
    return xyz, rpy


@model_plugin("gazebo_ros_p3d")
def ground_truth(xml: PluginXml) -> GroundTruthSpec:
    link = xml.link("bodyName", xml.model.root)
    return GroundTruthSpec(
        link=link,
        topic=xml.topic("topicName", "ground_truth"),
        frame_id=xml.frame("frameName", "world"),
        rate=xml.number("updateRate"),
        twist_in_child=xml.text("twistFrame", "world") == "child",
        child_frame_id=link,
        noise_stddev=abs(xml.number("gaussianNoise")),
        pose=_offset(xml),
    )


def _imu_spec(xml: PluginXml, name: str, link: str, pose: PoseTuple, **values: Any) -> ImuSpec:
    """ImuSpec of a plugin with <gaussianNoise>; values: what differs between plugins."""
    noise = abs(Values(xml.element, f"imu '{name}'").number("gaussianNoise"))
    values = {"gyro_noise_stddev": noise, "accel_noise_stddev": noise, **values}
    return ImuSpec(name=name, link=link, pose=pose, variance=noise**2, **values)


@model_plugin("gazebo_ros_imu")
def model_imu(xml: PluginXml) -> ImuSpec:
    link = xml.link("bodyName", xml.model.root)
    return _imu_spec(
        xml,
        xml.name or "imu",
        link,
        _offset(xml),
        rate=xml.number("updateRate"),
        frame_id=xml.frame("frameName", link),
        topic=xml.topic("topicName", "/default_imu"),
    )


@sensor_plugin("gazebo_ros_imu", types=("imu",))
def imu(xml: SensorXml) -> ImuSpec:
    """ImuSpec of a plugin that belongs into <gazebo>, but is often in a <sensor>."""
    return _imu_spec(
        xml,
        xml.name,
        xml.parent,
        xml.pose,
        rate=xml.rate(),
        frame_id=xml.frame("frameName", xml.text("bodyName", xml.parent)),
        topic=xml.topic("topicName", "/default_imu"),
    )


@sensor_plugin("gazebo_ros_imu_sensor", types=("imu",))
def imu_sensor(xml: SensorXml) -> ImuSpec:
    plugin, sensor = xml.plugin("imu"), Values(xml.sensor, f"imu '{xml.name}'")
    mean, stddev = {}, {}
    plugin_noise = abs(plugin.number("gaussianNoise"))
    for key, paths in (
        ("gyro", ("imu/angular_velocity/x/noise", "imu/noise/rate")),
        ("accel", ("imu/linear_acceleration/x/noise", "imu/noise/accel")),
    ):
        values = [sensor.noise(path) for path in paths]
        mean[key] = sum(value[0] for value in values)
        stddev[key] = (plugin_noise**2 + sum(value[1] ** 2 for value in values)) ** 0.5
    rotation = plugin.vector("rpyOffset")
    if any(rotation):
        xml.warn(
            f"{plugin.label} has <rpyOffset> {rotation}, which is ignored: give the sensor a <pose>"
        )
    if is_true(xml.text("initialOrientationAsReference")):
        xml.warn(
            f"{plugin.label} has <initialOrientationAsReference>, which is ignored: its "
            "orientation is in the world frame (REP 145)"
        )
    names = Names(xml.element, xml.model.name, default=xml.model.name)
    return _imu_spec(
        xml,
        xml.name,
        xml.parent,
        xml.pose,
        rate=xml.rate("updateRateHZ", 1.0),
        frame_id=xml.frame("frameName", xml.parent),
        topic=names.topic(xml.text("topicName", "imu_data"), absolute=False),
        gyro_noise_mean=mean["gyro"],
        accel_noise_mean=mean["accel"],
        gyro_noise_stddev=stddev["gyro"],
        accel_noise_stddev=stddev["accel"],
    )


# hector's; drifts are not simulated ---------------------------------------------------------------
@model_plugin("hector_gazebo_ros_imu")
def hector_imu(xml: PluginXml) -> ImuSpec:
    link = xml.link("bodyName", xml.model.root)
    noise = abs(xml.number("gaussianNoise"))
    acceleration = (
        max(abs(value) for value in xml.vector("accelGaussianNoise", broadcast=True)) or noise
    )
    rate = max(abs(value) for value in xml.vector("rateGaussianNoise", broadcast=True))
    return ImuSpec(
        name=xml.name or "imu",
        link=link,
        pose=(ZERO, xml.vector("rpyOffset", broadcast=True)),
        rate=xml.number("updateRate"),
        topic=xml.topic("topicName", "imu"),
        frame_id=xml.frame("frameId", link),
        gyro_noise_stddev=rate,
        accel_noise_stddev=acceleration,
        gyro_noise_mean=xml.vector("rateOffset", broadcast=True)[0],
        accel_noise_mean=xml.vector("accelOffset", broadcast=True)[0],
        variance=acceleration**2,
    )


@model_plugin("hector_gazebo_ros_gps")
def gps(xml: PluginXml) -> GpsSpec:
    link = xml.link("bodyName", xml.model.root)
    return GpsSpec(
        name=xml.name or "gps",
        link=link,
        pose=(xml.vector("xyzOffset", broadcast=True), xml.vector("rpyOffset", broadcast=True)),
        rate=xml.number("updateRate", 4.0),
        topic=xml.topic("topicName", "fix"),
        velocity_topic=xml.topic("velocityTopicName", "fix_velocity"),
        frame_id=xml.frame("frameId", "/world"),
        latitude=xml.number("referenceLatitude", GpsSpec.latitude),
        longitude=xml.number("referenceLongitude", GpsSpec.longitude),
        altitude=xml.number("referenceAltitude"),
        heading=math.radians(xml.number("referenceHeading")),
        status=int(xml.number("status")),
        service=int(xml.number("service", 1.0)),
        noise_stddev=xml.vector("gaussianNoise", broadcast=True),
        velocity_noise_stddev=xml.vector("velocityGaussianNoise", broadcast=True),
        offset=xml.vector("offset", broadcast=True),
    )


@model_plugin("hector_gazebo_ros_magnetic")
def magnetic(xml: PluginXml) -> MagneticSpec:
    link = xml.link("bodyName", xml.model.root)
    return MagneticSpec(
        name=xml.name or "magnetic",
        link=link,
        rate=xml.number("updateRate"),
        topic=xml.topic("topicName", "magnetic"),
        frame_id=xml.frame("frameId", link),
        magnitude=xml.number("magnitude", 0.44),
        heading=math.radians(xml.number("referenceHeading")),
        declination=math.radians(xml.number("declination")),
        inclination=math.radians(xml.number("inclination", 60.0)),
        field_message=is_true(xml.text("useMagneticFieldMsgs")),
        noise_stddev=xml.vector("gaussianNoise", broadcast=True),
        offset=xml.vector("offset", broadcast=True),
    )

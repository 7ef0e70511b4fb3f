"""IMU, GPS, magnetometer, ground truth: their specifications, read from SDF and plugins."""

import math
from dataclasses import dataclass
from typing import Any

from bullet_sim.plugins.registry import model_plugin, sensor_plugin
from bullet_sim.plugins.xml import ZERO, ZERO_POSE, PluginXml, PoseTuple, SensorXml, Values
from bullet_sim.pose import Vec3
from bullet_sim.xml_reader import is_true


@dataclass(frozen=True)
class ImuSpec:
    """An inertial measurement unit; rates [rad/s] and accelerations [m/s^2] in its own frame.

    Attributes:
        rate: messages per simulated second [Hz]; 0: every physics step.
        gyro_noise_mean, accel_noise_mean: one for all axes, or one for each.
        variance: on the diagonals of the covariances.
        service: name of its std_srvs/Empty; "": none.
    """

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    rate: float = 100.0
    topic: str = "/imu"
    frame_id: str = "imu_link"
    gyro_noise_stddev: float = 0.0
    accel_noise_stddev: float = 0.0
    gyro_noise_mean: float | Vec3 = 0.0
    accel_noise_mean: float | Vec3 = 0.0
    variance: float = 0.0
    service: str = ""


@dataclass(frozen=True)
class ModelImuSpec(ImuSpec):
    """libgazebo_ros_imu.so's, which measures no gravity.

    Attributes:
        pose: xyz has no effect; rpy is multiplied with the link's orientation from the left.
    """


@dataclass(frozen=True)
class BiasedImuSpec(ImuSpec):
    """hector's IMU, whose present biases can be set.

    Attributes:
        bias_topic: of sensor_msgs/Imu with the biases; "": none.
        gyro_frequency, accel_frequency: at which a set bias decays [1/s].
        rate_variances, accel_variances: on the diagonals of these covariances, along the axes; the
            orientation's are those of the acceleration over gravity squared, and of the heading.
    """

    rate_variances: Vec3 = (0.0,) * 3
    accel_variances: Vec3 = (0.0,) * 3
    heading_variance: float = 0.0
    bias_topic: str = ""
    gyro_frequency: Vec3 = (1.0 / 3600.0,) * 3
    accel_frequency: Vec3 = (1.0 / 3600.0,) * 3


@dataclass(frozen=True)
class GroundTruthSpec:
    """Pose and velocity of a link without error, as libgazebo_ros_p3d publishes it.

    Attributes:
        link: link whose frame is reported.
        frame_id: of the header.
        rate: messages per simulated second [Hz]; 0: every physics step.
        reference: link that pose and twist are relative to; "": the world; None: a link that does
            not exist, nothing is published.
        child_frame_id: the link's name in the message.
        twist_in_child: True: twist in the child frame, as nav_msgs/Odometry asks; False: along
            the world's axes, as upstream's plugin gives it.
        offset: (xyz [m], rpy [rad]), in the reference frame: added to the position, multiplied from
            the left with the orientation.
    """

    link: str
    topic: str
    frame_id: str = "world"
    rate: float = 50.0
    twist_in_child: bool = False
    child_frame_id: str = "base_link"
    noise_stddev: float = 0.0
    reference: str | None = ""
    offset: PoseTuple = ZERO_POSE


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
    latitude: float = 49.9
    longitude: float = 8.9
    altitude: float = 0.0
    heading: float = 0.0
    status: int = 0
    service: int = 0
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


WORLD_FRAMES = ("/world", "world", "/map", "map")  # values of <frameName> that are no link


@model_plugin("gazebo_ros_p3d")
def ground_truth(xml: PluginXml) -> GroundTruthSpec:
    """GroundTruthSpec; <headerFrame> is Paddock's own: another frame_id than <frameName>."""
    link, frame = xml.link("bodyName", xml.model.root), xml.text("frameName", "world")
    reference: str | None = "" if frame in WORLD_FRAMES else frame
    if reference and reference not in xml.model.links:
        xml.warn(
            f"{xml.label} has frameName '{frame}', which is neither world nor map nor a link; "
            f"links are {', '.join(xml.model.links)}; it publishes nothing, as in Gazebo",
            "ground truth plugins have a frameName that is no link and publish nothing",
            f"'{frame}'",
        )
        reference = None
    return GroundTruthSpec(
        link=link,
        topic=xml.topic("topicName", "ground_truth"),
        frame_id=xml.frame("headerFrame", frame),
        reference=reference,
        rate=xml.number("updateRate"),
        twist_in_child=xml.text("twistFrame", "world") == "child",
        child_frame_id=xml.merged(link),
        noise_stddev=abs(xml.number("gaussianNoise")),
        offset=_offset(xml),
    )


def _imu_spec(
    xml: PluginXml,
    name: str,
    link: str,
    pose: PoseTuple,
    kind: type[ImuSpec] = ImuSpec,
    **values: Any,
) -> ImuSpec:
    """Specification of a plugin with <gaussianNoise>; values: what differs between plugins."""
    noise = abs(Values(xml.element, f"imu '{name}'").number("gaussianNoise"))
    values = {"gyro_noise_stddev": noise, "accel_noise_stddev": noise, **values}
    return kind(name=name, link=link, pose=pose, variance=noise**2, **values)


@model_plugin("gazebo_ros_imu")
def model_imu(xml: PluginXml) -> ImuSpec:
    link = xml.link("bodyName", xml.model.root)
    return _imu_spec(
        xml,
        xml.name or "imu",
        link,
        _offset(xml),
        ModelImuSpec,
        rate=xml.number("updateRate"),
        frame_id=xml.frame("frameName", link, merge=True),
        topic=xml.topic("topicName", "/default_imu"),
        service=xml.topic("serviceName", "/default_imu"),
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
        service=xml.topic("serviceName", "/default_imu"),
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
    return _imu_spec(
        xml,
        xml.name,
        xml.parent,
        xml.pose,
        rate=xml.rate("updateRateHZ", 1.0),
        frame_id=xml.frame("frameName", xml.parent),
        topic=xml.names.topic(xml.text("topicName", "imu_data"), absolute=False),
        gyro_noise_mean=mean["gyro"],
        accel_noise_mean=mean["accel"],
        gyro_noise_stddev=stddev["gyro"],
        accel_noise_stddev=stddev["accel"],
    )


# hector's; drifts are not simulated ---------------------------------------------------------------
def _squares(values: Vec3) -> Vec3:
    x, y, z = values
    return x * x, y * y, z * z


@model_plugin("hector_gazebo_ros_imu")
def hector_imu(xml: PluginXml) -> BiasedImuSpec:
    link = xml.link("bodyName", xml.model.root)
    noise = abs(xml.number("gaussianNoise"))
    of_accel, of_rate = (
        xml.vector(f"{name}GaussianNoise", broadcast=True) for name in ("accel", "rate")
    )
    of_accel = of_accel if any(of_accel) else (noise,) * 3
    acceleration, rate = (max(map(abs, values)) for values in (of_accel, of_rate))
    topic = xml.topic("topicName", "imu")
    gyro_frequency, accel_frequency = (
        xml.vector(f"{name}DriftFrequency", default=(1.0 / 3600.0,) * 3, broadcast=True)
        for name in ("rate", "accel")
    )
    return BiasedImuSpec(
        name=xml.name or "imu",
        link=link,
        pose=(ZERO, xml.vector("rpyOffset", broadcast=True)),
        rate=xml.number("updateRate"),
        topic=topic,
        bias_topic=xml.topic("biasTopicName", f"{topic}/bias"),
        service=xml.topic("serviceName", f"{topic}/calibrate"),
        gyro_frequency=gyro_frequency,
        accel_frequency=accel_frequency,
        frame_id=xml.frame("frameId", xml.merged(link)),
        gyro_noise_stddev=rate,
        accel_noise_stddev=acceleration,
        rate_variances=_squares(of_rate),
        accel_variances=_squares(of_accel),
        heading_variance=xml.number("headingGaussianNoise") ** 2,
        gyro_noise_mean=xml.vector("rateOffset", broadcast=True),
        accel_noise_mean=xml.vector("accelOffset", broadcast=True),
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
        service=int(xml.number("service")),
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
        frame_id=xml.frame("frameId", xml.merged(link)),
        magnitude=xml.number("magnitude", 0.44),
        heading=math.radians(xml.number("referenceHeading")),
        declination=math.radians(xml.number("declination")),
        inclination=math.radians(xml.number("inclination", 60.0)),
        field_message=is_true(xml.text("useMagneticFieldMsgs")),
        noise_stddev=xml.vector("gaussianNoise", broadcast=True),
        offset=xml.vector("offset", broadcast=True),
    )

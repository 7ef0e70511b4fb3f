"""IMU, GPS, magnetometer, ground truth: their specifications, read from SDF and plugins."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from bullet_sim.plugins.registry import model_plugin, sensor_plugin
from bullet_sim.plugins.rules import MODEL, PLAIN, ROOT, Rule
from bullet_sim.plugins.spec import SensorSpec, number, read, reading, switch, topic_of
from bullet_sim.plugins.xml import (
    ZERO,
    ZERO_POSE,
    PluginXml,
    PoseTuple,
    SensorXml,
    Values,
    offset_of_merged,
)
from bullet_sim.pose import Pose, Quat, Vec3, quaternion_from_rpy
from bullet_sim.xml_reader import document_root

HOUR: Vec3 = (1.0 / 3600.0,) * 3  # [1/s]
OF_WORLD = "useWorldSphericalCoordinates"
OLD_YAW = "headingGaussianNoise"  # of older versions of hector's IMU, with its like


@dataclass(frozen=True)
class ErrorModel:
    """Errors of one measurement of hector's sensors, along its three axes.

    Attributes:
        offset: constant.
        drift: standard deviation of the drift at the start, and of what it wanders to.
        frequency: at which a drift decays [1/s].
        noise: standard deviation of the white noise.
        scale: factor of the true value.
    """

    offset: Vec3 = ZERO
    drift: Vec3 = ZERO
    frequency: Vec3 = HOUR
    noise: Vec3 = ZERO
    scale: Vec3 = (1.0,) * 3


@dataclass(frozen=True)
class BiasModel:
    """What a <noise> of SDF has besides its mean and its deviation, along three axes.

    Attributes:
        mean, stddev: of the bias at the start, which then gets a random sign.
        wander, time: deviation of what is added to it each second, and time [s] in which it decays;
            either 0: it stays.
        precision: to a multiple of which measurements are rounded; 0: they are not.
    """

    mean: Vec3 = ZERO
    stddev: Vec3 = ZERO
    wander: Vec3 = ZERO
    time: Vec3 = ZERO
    precision: Vec3 = ZERO


def sensor_errors(xml: PluginXml, prefix: str = "", noise: float = 0.0) -> ErrorModel:
    """Errors that a plugin's tags give.

    Args:
        prefix: of the tags: "accel" reads <accelOffset>; empty: <offset> ...
        noise: standard deviation of all axes; 0: that of the tag.
    """

    def vector(name: str, default: Vec3) -> Vec3:
        tag = f"{prefix}{name}" if prefix else f"{name[0].lower()}{name[1:]}"
        return xml.vector(tag, default=default, broadcast=True)

    return ErrorModel(
        offset=vector("Offset", ZERO),
        drift=vector("Drift", ZERO),
        frequency=vector("DriftFrequency", HOUR),
        noise=(noise,) * 3 if noise else vector("GaussianNoise", ZERO),
        scale=vector("ScaleError", (1.0,) * 3),
    )


def _timer(xml: PluginXml, default: float = 0.0) -> float:
    """Rate [Hz] of hector's UpdateTimer: <updatePeriod>, seconds and nanoseconds, wins."""
    rate = xml.number("updateRate", default)
    seconds, _, rest = xml.text("updatePeriod").partition(" ")
    if xml.element.find("updatePeriod") is None:
        return max(0.0, rate)
    try:
        period = int(seconds) + int(rest or "0") * 1e-9
    except ValueError:
        period = 0.0
    return 1.0 / period if period > 0.0 else 0.0


def _of_place(tag: str, default: float = 0.0, then: Callable[[float], float] = float) -> Any:
    """A number of the place on the earth; None: that of the world counts."""

    def of(xml: PluginXml) -> float | None:
        if xml.switch(OF_WORLD) and xml.element.find(tag) is None:
            return None
        return then(xml.number(tag, default))

    return reading(of, then(default))


def _errors(prefix: str = "") -> Any:
    """See sensor_errors."""
    return reading(lambda xml: sensor_errors(xml, prefix), ErrorModel())


def _link(xml: PluginXml) -> str:
    """Link <bodyName>; the root link without one."""
    return xml.link("bodyName", xml.model.root)


def _frame(xml: PluginXml) -> str:
    """Frame <frameId>; without one the link."""
    return xml.frame("frameId", xml.merged(_link(xml)))


@dataclass(frozen=True)
class ImuSpec(SensorSpec):
    """An inertial measurement unit; rates [rad/s] and accelerations [m/s^2] in its own frame.

    Attributes:
        rate: messages per simulated second [Hz]; 0: every physics step.
        gyro_noise_mean, accel_noise_mean, and their like: one for all axes, or one for each.
        gyro_bias, accel_bias: their biases.
        variance: on the diagonals of the covariances.
        service: name of its std_srvs/Empty; "": none.
        turn: quaternion that is multiplied with the orientation from the left.
        relative: the orientation is relative to that at the start.
        orientation_noise: standard deviation on each number of the quaternion.
    """

    NAME = "imu"
    rate: float = 100.0
    topic: str = "/imu"
    frame_id: str = "imu_link"
    gyro_noise_stddev: float | Vec3 = 0.0
    accel_noise_stddev: float | Vec3 = 0.0
    gyro_noise_mean: float | Vec3 = 0.0
    accel_noise_mean: float | Vec3 = 0.0
    variance: float = 0.0
    gyro_bias: BiasModel = BiasModel()
    accel_bias: BiasModel = BiasModel()
    service: str = ""
    turn: Quat = (0.0, 0.0, 0.0, 1.0)
    relative: bool = False
    orientation_noise: float = 0.0


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
        gyro, accel: errors of the rates [rad/s] and of the acceleration [m/s^2]. The squares of
            their noise are on the diagonals of these covariances; the orientation's are those of
            the acceleration over gravity squared, and of the heading.
        heading: errors of the heading [rad], all three alike.
    """

    bias_topic: str = ""
    gyro: ErrorModel = ErrorModel()
    accel: ErrorModel = ErrorModel()
    heading: ErrorModel = ErrorModel()


@dataclass(frozen=True)
class GroundTruthSpec:
    """Pose and velocity of a link without error, as libgazebo_ros_p3d publishes it.

    Attributes:
        link: link whose frame is reported.
        frame_id: of the header, <frameName> unless <headerFrame> says another.
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


@model_plugin("hector_gazebo_ros_gps")
@dataclass(frozen=True)
class GpsSpec(SensorSpec):
    """A GPS receiver; x of the world points along reference_heading, y to the left of it.

    Attributes:
        rate: fixes per simulated second [Hz]; 0: every physics step.
        topic, velocity_topic: NavSatFix and Vector3Stamped.
        latitude, longitude: of the world's origin [degrees]; altitude [m].
        heading: of the world's x axis [rad], clockwise from north. None of these: the world's own.
        status, service: of NavSatStatus.
        errors, velocity_errors: of x, y, z [m] and of the velocities [m/s].
    """

    NAME = "gps"
    link: str = reading(_link)
    pose: PoseTuple = ZERO_POSE
    rate: float = reading(lambda xml: _timer(xml, 4.0), 4.0)
    topic: str = topic_of("topicName", "fix")
    velocity_topic: str = topic_of("velocityTopicName", "fix_velocity")
    frame_id: str = reading(lambda xml: xml.frame("frameId", "/world"), "world")
    latitude: float | None = _of_place("referenceLatitude", 49.9)
    longitude: float | None = _of_place("referenceLongitude", 8.9)
    altitude: float | None = _of_place("referenceAltitude")
    heading: float | None = _of_place("referenceHeading", 0.0, math.radians)
    status: int = number("status", 0.0, int)
    service: int = number("service", 0.0, int)
    errors: ErrorModel = _errors()
    velocity_errors: ErrorModel = _errors("velocity")


@model_plugin("hector_gazebo_ros_magnetic")
@dataclass(frozen=True)
class MagneticSpec(SensorSpec):
    """A magnetometer in the earth's field.

    Attributes:
        rate: messages per simulated second [Hz]; 0: every physics step.
        magnitude: of the field, in the message's unit.
        heading: of the world's x axis [rad], clockwise from north; None: the world's own.
        declination, inclination: of the field [rad]; inclination positive downwards.
        field_message: MagneticField instead of Vector3Stamped.
        errors: along the sensor's axes.
    """

    NAME = "magnetic"
    link: str = reading(_link)
    pose: PoseTuple = ZERO_POSE
    rate: float = reading(_timer, 0.0)
    topic: str = topic_of("topicName", "magnetic")
    frame_id: str = reading(_frame, "base_link")
    magnitude: float = number("magnitude", 0.44)
    heading: float | None = _of_place("referenceHeading", 0.0, math.radians)
    declination: float = number("declination", 0.0, math.radians)
    inclination: float = number("inclination", 60.0, math.radians)
    field_message: bool = switch("useMagneticFieldMsgs")
    errors: ErrorModel = _errors()


def _offset(xml: PluginXml, *tags: str) -> PoseTuple:
    """Pose of <xyzOffset> and <rpyOffset>.

    Args:
        tags: of links; where sdformat writes those that they are merged into, it moves the pose.
    """
    xyz, rpy = xml.vector("xyzOffset"), xml.vector("rpyOffset")
    robot = document_root(xml.element)
    names = [name for name in (xml.text(tag) for tag in tags) if name in xml.model.links]
    if robot.tag != "robot" or all(xml.merged(name) == name for name in names):
        return xyz, rpy
    moved = offset_of_merged(xml.model, names, Pose.from_xyz_rpy(xyz, rpy))
    return moved.position, moved.rpy


NANO = 1e-9  # of a ratio of rates, by which it may be off
WORLD_FRAMES = ("/world", "world", "/map", "map")  # values of <frameName> that are no link


@model_plugin("gazebo_ros_p3d", rule=PLAIN)
def ground_truth(xml: PluginXml) -> GroundTruthSpec:
    """GroundTruthSpec; <headerFrame> and <twistFrame> are Paddock's own, see there."""
    link = xml.merged(xml.link("bodyName"))
    frame = xml.merged(xml.text("frameName", "world"))
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
        topic=xml.given_topic(),
        frame_id=xml.frame("headerFrame", frame),
        reference=reference,
        rate=xml.number("updateRate"),
        twist_in_child=xml.text("twistFrame", "world") == "child",
        child_frame_id=link,
        noise_stddev=abs(xml.number("gaussianNoise")),
        offset=_offset(xml, "bodyName", "frameName"),
    )


def _imu_spec(xml: PluginXml, kind: type[ImuSpec], **values: Any) -> ImuSpec:
    """Specification of a plugin with <gaussianNoise>; values: what differs between plugins."""
    name = xml.name or kind.NAME
    noise = abs(Values(xml.element, f"imu '{name}'").number("gaussianNoise"))
    values = {"gyro_noise_stddev": noise, "accel_noise_stddev": noise, **values}
    return read(kind, xml, variance=noise**2, **values)


def _of_imu(xml: PluginXml) -> dict[str, str]:
    """Topic and service of libgazebo_ros_imu.so."""
    return {
        name: xml.topic(tag, "/default_imu")
        for name, tag in (("topic", "topicName"), ("service", "serviceName"))
    }


@model_plugin("gazebo_ros_imu")
def model_imu(xml: PluginXml) -> ImuSpec:
    link = xml.merged(xml.link("bodyName"))
    return _imu_spec(
        xml,
        ModelImuSpec,
        link=link,
        pose=_offset(xml, "bodyName", "frameName"),
        rate=xml.number("updateRate"),
        frame_id=xml.frame("frameName", link, merge=True),
        **_of_imu(xml),
    )


@sensor_plugin("gazebo_ros_imu", types=("imu",))
def imu(xml: SensorXml) -> ImuSpec:
    """ImuSpec of a plugin that belongs into <gazebo>, but is often in a <sensor>."""
    frame = xml.frame("frameName", xml.text("bodyName", xml.parent))
    return _imu_spec(xml, ImuSpec, rate=xml.rate(), frame_id=frame, **_of_imu(xml))


def _alike(values: list[float]) -> float | Vec3:
    """A number for all axes, or three."""
    x, y, z = values
    return x if x == y == z else (x, y, z)


def _bias(sensor: Values, paths: list[str]) -> BiasModel:
    """Bias of three axes, each with the path of its <noise>."""

    def of(tag: str) -> Vec3:
        x, y, z = (sensor.number(f"{path}/{tag}") for path in paths)
        return x, y, z

    return BiasModel(
        of("bias_mean"),
        of("bias_stddev"),
        of("dynamic_bias_stddev"),
        of("dynamic_bias_correlation_time"),
        of("precision"),
    )


@sensor_plugin("gazebo_ros_imu_sensor", types=("imu",), rule=Rule(MODEL, ROOT))
def imu_sensor(xml: SensorXml) -> ImuSpec:
    """ImuSpec of a plugin that needs a <frameName>.

    Raises:
        MissingPart: there is none.
    """
    if xml.element.find("frameName") is None:
        raise xml.lacks("frameName")
    plugin, sensor = xml.plugin("imu"), Values(xml.sensor, f"imu '{xml.name}'")
    own, wanted = sensor.number("update_rate"), plugin.number("updateRateHZ", 1.0)
    rate = xml.rate("updateRateHZ", 1.0)
    if 0.0 < wanted < own:  # the first measurement that is late enough
        rate = own / math.ceil(own / wanted - NANO)
    mean, stddev, bias = {}, {}, {}
    plugin_noise = abs(plugin.number("gaussianNoise"))
    for key, tag in (("gyro", "angular_velocity"), ("accel", "linear_acceleration")):
        paths = [f"imu/{tag}/{axis}/noise" for axis in "xyz"]
        values = [sensor.noise(path) for path in paths]
        mean[key] = _alike([value[0] for value in values])
        stddev[key] = _alike([math.hypot(plugin_noise, value[1]) for value in values])
        bias[key] = _bias(sensor, paths)
    return _imu_spec(
        xml,
        ImuSpec,
        rate=rate,
        frame_id=xml.frame("frameName", xml.parent),
        topic=xml.topic("topicName", "imu_data"),
        gyro_noise_mean=mean["gyro"],
        accel_noise_mean=mean["accel"],
        gyro_noise_stddev=stddev["gyro"],
        accel_noise_stddev=stddev["accel"],
        gyro_bias=bias["gyro"],
        accel_bias=bias["accel"],
        orientation_noise=plugin_noise,
        turn=quaternion_from_rpy(*plugin.vector("rpyOffset")),
        relative=xml.switch("initialOrientationAsReference"),
    )


@model_plugin("hector_gazebo_ros_imu")
def hector_imu(xml: PluginXml) -> BiasedImuSpec:
    noise, topic = abs(xml.number("gaussianNoise")), xml.topic("topicName", "imu")
    return read(
        BiasedImuSpec,
        xml,
        link=_link(xml),
        pose=(ZERO, xml.vector("rpyOffset", broadcast=True)),
        rate=_timer(xml),
        topic=topic,
        bias_topic=xml.topic("biasTopicName", f"{topic}/bias"),
        service=xml.topic("serviceName", f"{topic}/calibrate"),
        frame_id=_frame(xml),
        gyro=sensor_errors(xml, "rate", noise),
        accel=sensor_errors(xml, "accel", noise),
        heading=sensor_errors(xml, "yaw" if xml.element.find(OLD_YAW) is None else "heading"),
    )

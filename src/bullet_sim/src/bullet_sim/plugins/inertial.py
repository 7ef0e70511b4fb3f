"""IMU, GPS, magnetometer, ground truth: their specifications, read from SDF and plugins."""

import math
from dataclasses import dataclass

from bullet_sim.plugins.xml import ZERO_POSE, Names, PoseTuple, noise_of, plugin_label
from bullet_sim.xml_reader import child_floats, child_number, child_text, floats, is_true


@dataclass(frozen=True)
class ImuSpec:
    """An inertial measurement unit; rates [rad/s] and accelerations [m/s^2] in its own frame.

    Attributes:
        rate: messages per simulated second [Hz]; 0: one a physics step.
        variance: written on the diagonals of the covariances.
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
        rate: messages per simulated second [Hz]; 0: one a physics step.
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
        rate: fixes per simulated second [Hz]; 0: one a physics step.
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
        rate: messages per simulated second [Hz]; 0: one a physics step.
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


def imu_spec(names, plugin, name, link, pose, **values):
    """ImuSpec of a plugin with <gaussianNoise>; values: what differs between plugins."""
    noise = abs(child_number(plugin, "gaussianNoise", f"imu '{name}'", 0.0))
    values.setdefault("gyro_noise_stddev", noise)
    values.setdefault("accel_noise_stddev", noise)
    return ImuSpec(name=name, link=link, pose=pose, variance=noise**2, **values)


def imu(sensor):
    """libgazebo_ros_imu.so in a <sensor>: it belongs into <gazebo>, but is often found here."""
    frame = child_text(sensor.plugin, "frameName") or child_text(
        sensor.plugin, "bodyName", sensor.link
    )
    return imu_spec(
        sensor.names,
        sensor.plugin,
        sensor.name,
        sensor.link,
        sensor.pose,
        rate=sensor.rate(),
        frame_id=sensor.names.frame(frame, prefixed=False),
        topic=sensor.names.text_topic("topicName", "/default_imu"),
    )


def imu_sensor(sensor):
    """ImuSpec of libgazebo_ros_imu_sensor.so."""
    what = f"imu '{sensor.name}'"
    names = sensor.names
    if sensor.plugin.find("robotNamespace") is None and not names.namespace:
        names = Names(sensor.plugin, sensor.model.name, sensor.model.name)
    mean, stddev = {}, {}
    plugin_noise = abs(child_number(sensor.plugin, "gaussianNoise", what, 0.0))
    for key, paths in (
        ("gyro", ("imu/angular_velocity/x/noise", "imu/noise/rate")),
        ("accel", ("imu/linear_acceleration/x/noise", "imu/noise/accel")),
    ):
        values = [noise_of(sensor.element, path, what) for path in paths]
        mean[key] = sum(value[0] for value in values)
        stddev[key] = (plugin_noise**2 + sum(value[1] ** 2 for value in values)) ** 0.5
    turn = child_floats(sensor.plugin, "rpyOffset", 3, what, (0.0, 0.0, 0.0))
    if any(turn):
        sensor.model.warn(
            f"{what} has <rpyOffset> {turn}, which is ignored: give the sensor a <pose>"
        )
    if is_true(child_text(sensor.plugin, "initialOrientationAsReference", "false")):
        sensor.model.warn(
            f"{what} wants <initialOrientationAsReference>; its orientation is "
            "in the world all the same (REP 145)"
        )
    return imu_spec(
        names,
        sensor.plugin,
        sensor.name,
        sensor.link,
        sensor.pose,
        rate=sensor.rate("updateRateHZ", 1.0),
        frame_id=names.frame(child_text(sensor.plugin, "frameName", sensor.link), False),
        topic=names.topic(child_text(sensor.plugin, "topicName", "imu_data"), absolute=False),
        gyro_noise_mean=mean["gyro"],
        accel_noise_mean=mean["accel"],
        gyro_noise_stddev=stddev["gyro"],
        accel_noise_stddev=stddev["accel"],
    )


def _link(element, model):
    """Link of <bodyName>, the root link where there is none; None with a warning if unknown."""
    link = child_text(element, "bodyName", model.root).rsplit("::", 1)[-1]
    if link not in model.links:
        model.warn(
            f"{plugin_label(element)} has bodyName '{link}', which is no link; it is left out",
            "plugins name a link that does not exist and are left out",
            plugin_label(element),
        )
        return None
    return link


def _vector(element, tag):
    """(3,) numbers of a tag; a single one counts for all axes, none is 0."""
    text = child_text(element, tag)
    if text is None:
        return (0.0, 0.0, 0.0)
    values = floats(text, None, f"{plugin_label(element)} <{tag}>")
    if len(values) == 1:
        return values * 3
    return floats(text, 3, f"{plugin_label(element)} <{tag}>")


def _offset_pose(element):
    return (_vector(element, "xyzOffset"), _vector(element, "rpyOffset"))


def hector_imu(element, model, names):
    """ImuSpec of libhector_gazebo_ros_imu.so; drifts are not simulated."""
    link = _link(element, model)
    if link is None:
        return
    noise = abs(child_number(element, "gaussianNoise", plugin_label(element), 0.0))
    acceleration = max(map(abs, _vector(element, "accelGaussianNoise"))) or noise
    rate = max(map(abs, _vector(element, "rateGaussianNoise")))
    model.sensors.append(
        ImuSpec(
            name=element.get("name") or "imu",
            link=link,
            pose=((0.0, 0.0, 0.0), _vector(element, "rpyOffset")),
            rate=child_number(element, "updateRate", plugin_label(element), 0.0),
            topic=names.text_topic("topicName", "imu"),
            frame_id=names.frame(child_text(element, "frameId", link), prefixed=False),
            gyro_noise_stddev=rate,
            accel_noise_stddev=acceleration,
            gyro_noise_mean=_vector(element, "rateOffset")[0],
            accel_noise_mean=_vector(element, "accelOffset")[0],
            variance=acceleration**2,
        )
    )


def gps(element, model, names):
    """GpsSpec of libhector_gazebo_ros_gps.so; drifts are not simulated."""
    link = _link(element, model)
    if link is None:
        return
    what = plugin_label(element)

    def number(tag, default):
        return child_number(element, tag, what, default)

    model.sensors.append(
        GpsSpec(
            name=element.get("name") or "gps",
            link=link,
            pose=_offset_pose(element),
            rate=number("updateRate", 4.0),
            topic=names.text_topic("topicName", "fix"),
            velocity_topic=names.text_topic("velocityTopicName", "fix_velocity"),
            frame_id=names.frame(child_text(element, "frameId", "/world"), prefixed=False),
            latitude=number("referenceLatitude", GpsSpec.latitude),
            longitude=number("referenceLongitude", GpsSpec.longitude),
            altitude=number("referenceAltitude", 0.0),
            heading=math.radians(number("referenceHeading", 0.0)),
            status=int(number("status", 0.0)),
            service=int(number("service", 1.0)),
            noise_stddev=_vector(element, "gaussianNoise"),
            velocity_noise_stddev=_vector(element, "velocityGaussianNoise"),
            offset=_vector(element, "offset"),
        )
    )


def magnetic(element, model, names):
    """MagneticSpec of libhector_gazebo_ros_magnetic.so; drifts are not simulated."""
    link = _link(element, model)
    if link is None:
        return
    what = plugin_label(element)

    def angle(tag, default):
        return math.radians(child_number(element, tag, what, default))

    model.sensors.append(
        MagneticSpec(
            name=element.get("name") or "magnetic",
            link=link,
            rate=child_number(element, "updateRate", what, 0.0),
            topic=names.text_topic("topicName", "magnetic"),
            frame_id=names.frame(child_text(element, "frameId", link), prefixed=False),
            magnitude=child_number(element, "magnitude", what, 0.44),
            heading=angle("referenceHeading", 0.0),
            declination=angle("declination", 0.0),
            inclination=angle("inclination", 60.0),
            field_message=is_true(child_text(element, "useMagneticFieldMsgs", "false")),
            noise_stddev=_vector(element, "gaussianNoise"),
            offset=_vector(element, "offset"),
        )
    )

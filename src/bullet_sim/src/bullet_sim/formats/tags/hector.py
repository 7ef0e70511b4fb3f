"""Model plugins of hector_gazebo_plugins -> specifications."""

import math

from bullet_sim.description.field_specs import GpsSpec, MagneticSpec
from bullet_sim.description.specs import ImuSpec
from bullet_sim.formats.xml_read import child_number, child_text, floats, is_true


def _what(element):
    return f"plugin '{element.get('filename')}'"


def _link(element, model):
    """Link of <bodyName>, the root link where there is none; None with a warning if unknown."""
    link = child_text(element, "bodyName", model.root).rsplit("::", 1)[-1]
    if link not in model.links:
        model.warn(
            f"{_what(element)} has bodyName '{link}', which is no link; it is left out",
            "plugins name a link that does not exist and are left out",
            _what(element),
        )
        return None
    return link


def _vector(element, tag):
    """(3,) numbers of a tag; a single one counts for all axes, none is 0."""
    text = child_text(element, tag)
    if text is None:
        return (0.0, 0.0, 0.0)
    values = floats(text, None, f"{_what(element)} <{tag}>")
    if len(values) == 1:
        return values * 3
    return floats(text, 3, f"{_what(element)} <{tag}>")


def _offset_pose(element):
    return (_vector(element, "xyzOffset"), _vector(element, "rpyOffset"))


def imu(element, model, names):
    """ImuSpec of libhector_gazebo_ros_imu.so; drifts are not simulated."""
    link = _link(element, model)
    if link is None:
        return
    noise = abs(child_number(element, "gaussianNoise", _what(element), 0.0))
    acceleration = max(map(abs, _vector(element, "accelGaussianNoise"))) or noise
    rate = max(map(abs, _vector(element, "rateGaussianNoise")))
    model.sensors.append(
        ImuSpec(
            name=element.get("name") or "imu",
            link=link,
            pose=((0.0, 0.0, 0.0), _vector(element, "rpyOffset")),
            rate=child_number(element, "updateRate", _what(element), 0.0),
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
    what = _what(element)

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
    what = _what(element)

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

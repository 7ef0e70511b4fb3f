"""<sensor type="imu"> and IMU plugins -> specifications."""

from bullet_sim.description.specs import ImuSpec
from bullet_sim.formats.plugin_names import Names
from bullet_sim.formats.tags.sensor_element import noise_of
from bullet_sim.formats.xml_read import child_floats, child_number, child_text, is_true


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

"""<sensor type="ray"> with plugins that publish points or a range -> specifications."""

from bullet_sim.description.ray_specs import CloudSpec, RangeSpec
from bullet_sim.formats.tags import lenses
from bullet_sim.formats.xml_read import child_number, child_text, child_whole, is_true


def _scan(sensor):
    """Values that all of them share, from <ray> and the plugin's frame."""
    what = f"lidar '{sensor.name}'"
    ray = sensor.element.find("ray")
    ray = sensor.element if ray is None else ray

    first, last = lenses.sweep(ray, what)
    near, far = lenses.reach(ray, what)
    return dict(
        name=sensor.name,
        link=sensor.link,
        pose=sensor.pose,
        samples=child_whole(ray, "scan/horizontal/samples", what, 1),
        min_angle=first,
        max_angle=last,
        layers=child_whole(ray, "scan/vertical/samples", what, 1),
        min_elevation=child_number(ray, "scan/vertical/min_angle", what, 0.0),
        max_elevation=child_number(ray, "scan/vertical/max_angle", what, 0.0),
        range_min=near,
        range_max=far,
        noise_mean=child_number(ray, "noise/mean", what, 0.0),
        noise_stddev=abs(child_number(ray, "noise/stddev", what, 0.0)),
        visualize=is_true(child_text(sensor.element, "visualize", "false")),
    )


def velodyne(sensor):
    """CloudSpec of libgazebo_ros_velodyne_laser.so; min_range, max_range narrow the ray's."""
    what = f"lidar '{sensor.name}'"
    values = _scan(sensor)
    nearest = child_number(sensor.plugin, "min_range", what, 0.0)
    farthest = child_number(sensor.plugin, "max_range", what, float("inf"))
    values.update(
        range_min=max(values["range_min"], nearest),
        range_max=min(values["range_max"], farthest),
        noise_stddev=values["noise_stddev"]
        or abs(child_number(sensor.plugin, "gaussianNoise", what, 0.0)),
        rate=sensor.drawn_rate(tag="-"),
        topic=sensor.names.text_topic("topicName", "/velodyne_points"),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameName", "/velodyne")),
        organized=is_true(child_text(sensor.plugin, "organize_cloud", "false")),
    )
    return CloudSpec(layout="velodyne", **values)


def block_laser(sensor):
    """CloudSpec of libgazebo_ros_block_laser.so."""
    what = f"lidar '{sensor.name}'"
    values = _scan(sensor)
    values.update(
        noise_stddev=values["noise_stddev"]
        or abs(child_number(sensor.plugin, "gaussianNoise", what, 0.0)),
        rate=sensor.drawn_rate(),
        topic=sensor.names.text_topic("topicName", "/world"),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameName", "/world")),
    )
    return CloudSpec(layout="block", **values)


def range_sensor(sensor):
    """RangeSpec of libgazebo_ros_range.so."""
    what = f"range sensor '{sensor.name}'"
    values = _scan(sensor)
    values.update(
        noise_stddev=values["noise_stddev"]
        or abs(child_number(sensor.plugin, "gaussianNoise", what, 0.0)),
        rate=sensor.drawn_rate(),
        topic=sensor.names.text_topic("topicName", "/range"),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameName", "/world")),
    )
    return RangeSpec(
        infrared=child_text(sensor.plugin, "radiation", "infrared").lower() != "ultrasound",
        field_of_view=child_number(sensor.plugin, "fov", what, 0.05),
        **values,
    )


def sonar(sensor):
    """RangeSpec of libhector_gazebo_ros_sonar.so; its field of view is the narrower of both."""
    what = f"sonar '{sensor.name}'"
    values = _scan(sensor)
    wide = values["max_angle"] - values["min_angle"]
    high = values["max_elevation"] - values["min_elevation"]
    values.update(
        noise_stddev=values["noise_stddev"]
        or abs(child_number(sensor.plugin, "gaussianNoise", what, 0.0)),
        rate=sensor.drawn_rate(),
        topic=sensor.names.text_topic("topicName", "sonar"),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameId", sensor.link), False),
    )
    angles = [angle for angle in (wide, high) if angle > 0.0]
    return RangeSpec(infrared=False, field_of_view=min(angles, default=0.0), **values)

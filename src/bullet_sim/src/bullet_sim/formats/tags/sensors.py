"""<sensor> elements of URDF and SDF with their gazebo_ros plugins -> specifications."""

from bullet_sim.description.specs import ContactSpec
from bullet_sim.errors import ModelError
from bullet_sim.formats.plugin_names import Names, library
from bullet_sim.formats.tags import cameras, imus, rays
from bullet_sim.formats.tags.sensor_element import SensorElement
from bullet_sim.formats.xml_read import child_text, sdf_pose

# Model plugins that read no <sensor>: with these alone, a sensor without a plugin has no topic.
_READ_NO_SENSOR = {
    "gazebo_ros_control",
    "gazebo_ros_diff_drive",
    "gazebo_ros_f3d",
    "gazebo_ros_ft_sensor",
    "gazebo_ros_hand_of_god",
    "gazebo_ros_joint_pose_trajectory",
    "gazebo_ros_joint_state_publisher",
    "gazebo_ros_p3d",
    "gazebo_ros_skid_steer_drive",
    "roboticsgroup_gazebo_mimic_joint_plugin",
    "roboticsgroup_upatras_gazebo_mimic_joint_plugin",
}


def parse_sensor(element, link, model):
    """Specifications of one <sensor>, which go into the model's list.

    Args:
        element: the <sensor>.
        link: name of the link that carries it.
        model: ModelDescription; gets warnings, too.
    """
    kind, name = element.get("type"), element.get("name") or "sensor"
    readers = _READERS.get(kind)
    if readers is None:
        model.warn(
            f"sensor '{name}' has type '{kind}', known are {', '.join(_READERS)}; it is left out",
            "sensors have a type that is not known here and are left out",
            f"'{name}' ({kind})",
        )
        return
    plugins = element.findall("plugin")
    if not plugins and not _is_for_a_plugin(element):
        model.warn(
            f"sensor '{name}' has no ROS plugin and so no topic; it is left out",
            "sensors have no ROS plugin and so no topic and are left out",
            f"'{name}'",
        )
    pose = sdf_pose(element, f"sensor '{name}'")
    for plugin in plugins:
        reader = readers.get(library(plugin))
        if reader is None:
            model.warn(
                f"plugin '{plugin.get('filename')}' of sensor '{name}' is not known here "
                f"and is ignored; a sensor of type {kind} takes "
                f"{', '.join(f'lib{known}.so' for known in readers)}",
                "plugins of sensors are not known here and are ignored",
                f"'{plugin.get('filename')}'",
            )
            continue
        place = (pose.position, pose.rpy)
        sensor = SensorElement(element, plugin, Names(plugin, model.name), name, link, place, model)
        try:
            found = reader(sensor)
            model.sensors += found if isinstance(found, list) else [found]
        except ModelError as error:
            model.warn(f"{error}; sensor '{name}' is left out", "sensors are left out", f"'{name}'")


def _is_for_a_plugin(sensor):
    """Whether a sensor without a plugin may be one that a plugin of its model reads."""
    holders = [node for node in sensor.document.root.iter() if node.tag in ("model", "gazebo")]
    plugins = {library(plugin) for holder in holders for plugin in holder.findall("plugin")}
    return bool(plugins - _READ_NO_SENSOR)


def _bumper(sensor):
    collisions = tuple(
        found.text.strip()
        for found in sensor.element.findall("contact/collision")
        if found.text and found.text.strip()
    )
    return ContactSpec(
        name=sensor.name,
        link=sensor.link,
        collisions=collisions,
        rate=sensor.rate(tag="-"),
        topic=sensor.names.text_topic("bumperTopicName", "bumper_states"),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameName", "world"), False),
    )


_CAMERAS = {"gazebo_ros_camera": cameras.camera}
_DEPTH = {
    "gazebo_ros_depth_camera": cameras.depth_camera,
    "gazebo_ros_openni_kinect": cameras.kinect,
}
_LASERS = {
    "gazebo_ros_laser": rays.laser,
    "gazebo_ros_gpu_laser": rays.laser,
    "gazebo_ros_velodyne_laser": rays.velodyne,
    "gazebo_ros_velodyne_gpu_laser": rays.velodyne,
    "gazebo_ros_block_laser": rays.block_laser,
    "gazebo_ros_range": rays.range_sensor,
    "hector_gazebo_ros_sonar": rays.sonar,
}
_READERS = {
    "camera": _CAMERAS | _DEPTH,
    "multicamera": {"gazebo_ros_multicamera": cameras.multicamera},
    cameras.WIDE: {"gazebo_ros_camera": cameras.wide_angle_camera},
    "depth": _DEPTH | _CAMERAS,
    "depth_camera": _DEPTH | _CAMERAS,
    "ray": _LASERS,
    "gpu_ray": _LASERS,
    "imu": {"gazebo_ros_imu_sensor": imus.imu_sensor, "gazebo_ros_imu": imus.imu},
    "contact": {"gazebo_ros_bumper": _bumper},
}

"""<plugin> and <sensor> elements of a model -> the reader of each."""

from bullet_sim.description.model import DEFAULT_SIM_TYPE, STEER_BOT_SIM_TYPE
from bullet_sim.errors import ModelError
from bullet_sim.plugins import cameras, forces, inertial, lidars
from bullet_sim.plugins.drives import (
    JointTransformsSpec,
    RootTransformSpec,
    diff_drive,
    joint_states,
    mimic_joint,
    planar_move,
    skid_steer,
)
from bullet_sim.plugins.forces import ContactSpec
from bullet_sim.plugins.inertial import GroundTruthSpec, imu_spec
from bullet_sim.plugins.xml import Names, SensorElement, library, plugin_label
from bullet_sim.xml_reader import child_floats, child_number, child_text, sdf_pose


def parse_plugin(element, model):
    """Read one model plugin into the model description; an unknown one is a warning.

    Args:
        element: the <plugin>.
        model: ModelDescription.
    """
    reader = _PLUGIN_READERS.get(library(element))
    if reader is None:
        name = element.get("filename")
        model.warn(
            f"plugin '{name}' is not known here and is ignored",
            "plugins are not known here and are ignored",
            f"'{name}'",
        )
        return
    try:
        reader(element, model, Names(element, model.name))
    except ModelError as error:
        model.warn(f"{error}; the plugin is left out", "plugins are left out", str(error))


def _control(element, model, _):
    model.control_namespace = child_text(element, "robotNamespace", "")
    model.control_period = child_number(element, "controlPeriod", "gazebo_ros_control", 0.0)
    kind = child_text(element, "robotSimType", DEFAULT_SIM_TYPE).replace("::", "/")
    if kind not in (DEFAULT_SIM_TYPE, STEER_BOT_SIM_TYPE):
        model.warn(
            f"gazebo_ros_control has robotSimType '{kind}', known are {DEFAULT_SIM_TYPE} and "
            f"{STEER_BOT_SIM_TYPE}; the first is used"
        )
        kind = DEFAULT_SIM_TYPE
    model.robot_sim_type = kind


def _body(element, model, what):
    """Link of a <bodyName>, or None with a warning; 'model::link' is taken, too."""
    name = child_text(element, "bodyName", model.root)
    link = name if name in model.links else name.rsplit("::", 1)[-1].lstrip("/")
    if link not in model.links:
        model.warn(
            f"{what} has bodyName '{link}', which is no link; it is left out",
            "plugins name a link that does not exist and are left out",
            what,
        )
        return None
    return link


def _offset(element, what):
    pose = []
    for tag in ("xyzOffset", "rpyOffset"):
        plural = child_floats(element, f"{tag}s", 3, what, (0.0, 0.0, 0.0))
        pose.append(child_floats(element, tag, 3, what, plural))
    return tuple(pose)


def _ground_truth(element, model, names):
    what = plugin_label(element)
    link = _body(element, model, what)
    if link is None:
        return
    model.sensors.append(
        GroundTruthSpec(
            link=link,
            topic=names.text_topic("topicName", "ground_truth"),
            frame_id=names.frame(child_text(element, "frameName", "world"), prefixed=False),
            rate=child_number(element, "updateRate", what, 0.0),
            twist_in_child=child_text(element, "twistFrame", "world") == "child",
            child_frame_id=link,
            noise_stddev=abs(child_number(element, "gaussianNoise", what, 0.0)),
            pose=_offset(element, what),
        )
    )


def _imu(element, model, names):
    what = plugin_label(element)
    link = _body(element, model, what)
    if link is None:
        return
    frame = child_text(element, "frameName", link)
    model.sensors.append(
        imu_spec(
            names,
            element,
            element.get("name") or "imu",
            link,
            _offset(element, what),
            rate=child_number(element, "updateRate", what, 0.0),
            frame_id=names.frame(frame, prefixed=False),
            topic=names.text_topic("topicName", "/default_imu"),
        )
    )


def _state_publisher(element, model, names):
    what = plugin_label(element)
    name = element.get("name") or "state_publisher"
    rate = child_number(element, "updateRate", what, 50.0)
    model.sensors.append(JointTransformsSpec(name, model.root, rate))
    if frame := child_text(element, "frameName", ""):
        rate = child_number(element, "frameRate", what, 50.0)
        frame = names.frame(frame, prefixed=False)
        model.sensors.append(RootTransformSpec(name, model.root, frame, rate))


_PLUGIN_READERS = {
    "gazebo_ros_control": _control,
    "gazebo_ros_p3d": _ground_truth,
    "gazebo_ros_imu": _imu,
    "gazebo_ros_diff_drive": diff_drive,
    "gazebo_ros_skid_steer_drive": skid_steer,
    "gazebo_ros_joint_state_publisher": joint_states,
    "gazebo_ros_planar_move": planar_move,
    "paddock_state_publisher": _state_publisher,
    "roboticsgroup_gazebo_mimic_joint_plugin": mimic_joint,
    "roboticsgroup_upatras_gazebo_mimic_joint_plugin": mimic_joint,
    "gazebo_ros_ft_sensor": forces.ft_sensor,
    "gazebo_ros_f3d": forces.f3d,
    "gazebo_ros_hand_of_god": forces.hand_of_god,
    "gazebo_ros_joint_pose_trajectory": forces.joint_pose_trajectory,
    "realsense_gazebo_plugin": cameras.realsense,
    "hector_gazebo_ros_imu": inertial.hector_imu,
    "hector_gazebo_ros_gps": inertial.gps,
    "hector_gazebo_ros_magnetic": inertial.magnetic,
}


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
    readers = _SENSOR_READERS.get(kind)
    if readers is None:
        model.warn(
            f"sensor '{name}' has type '{kind}', known are {', '.join(_SENSOR_READERS)};"
            " it is left out",
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
    "gazebo_ros_laser": lidars.laser,
    "gazebo_ros_gpu_laser": lidars.laser,
    "gazebo_ros_velodyne_laser": lidars.velodyne,
    "gazebo_ros_velodyne_gpu_laser": lidars.velodyne,
    "gazebo_ros_block_laser": lidars.block_laser,
    "gazebo_ros_range": lidars.range_sensor,
    "hector_gazebo_ros_sonar": lidars.sonar,
}
_SENSOR_READERS = {
    "camera": _CAMERAS | _DEPTH,
    "multicamera": {"gazebo_ros_multicamera": cameras.multicamera},
    cameras.WIDE: {"gazebo_ros_camera": cameras.wide_angle_camera},
    "depth": _DEPTH | _CAMERAS,
    "depth_camera": _DEPTH | _CAMERAS,
    "ray": _LASERS,
    "gpu_ray": _LASERS,
    "imu": {"gazebo_ros_imu_sensor": inertial.imu_sensor, "gazebo_ros_imu": inertial.imu},
    "contact": {"gazebo_ros_bumper": _bumper},
}

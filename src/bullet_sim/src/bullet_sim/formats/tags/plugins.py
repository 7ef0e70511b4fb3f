"""<plugin> elements of a model: ros_control, and plugins that publish without a <sensor>."""

from bullet_sim.description.field_specs import JointTransformsSpec, RootTransformSpec
from bullet_sim.description.parts import DEFAULT_SIM_TYPE, STEER_BOT_SIM_TYPE
from bullet_sim.description.specs import GroundTruthSpec
from bullet_sim.errors import ModelError
from bullet_sim.formats.plugin_names import Names, library
from bullet_sim.formats.tags import cameras, hector, wrenches
from bullet_sim.formats.tags.imus import imu_spec
from bullet_sim.formats.tags.wheels import (
    diff_drive,
    joint_states,
    mimic_joint,
    planar_move,
    skid_steer,
)
from bullet_sim.formats.xml_read import child_floats, child_number, child_text


def parse_plugin(element, model):
    """Read one model plugin into the model description; an unknown one is a warning.

    Args:
        element: the <plugin>.
        model: ModelDescription.
    """
    reader = _READERS.get(library(element))
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
    what = f"plugin '{element.get('filename')}'"
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
    what = f"plugin '{element.get('filename')}'"
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
    what = f"plugin '{element.get('filename')}'"
    name = element.get("name") or "state_publisher"
    rate = child_number(element, "updateRate", what, 50.0)
    model.sensors.append(JointTransformsSpec(name, model.root, rate))
    if frame := child_text(element, "frameName", ""):
        rate = child_number(element, "frameRate", what, 50.0)
        frame = names.frame(frame, prefixed=False)
        model.sensors.append(RootTransformSpec(name, model.root, frame, rate))


_READERS = {
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
    "gazebo_ros_ft_sensor": wrenches.ft_sensor,
    "gazebo_ros_f3d": wrenches.f3d,
    "gazebo_ros_hand_of_god": wrenches.hand_of_god,
    "gazebo_ros_joint_pose_trajectory": wrenches.joint_pose_trajectory,
    "realsense_gazebo_plugin": cameras.realsense,
    "hector_gazebo_ros_imu": hector.imu,
    "hector_gazebo_ros_gps": hector.gps,
    "hector_gazebo_ros_magnetic": hector.magnetic,
}

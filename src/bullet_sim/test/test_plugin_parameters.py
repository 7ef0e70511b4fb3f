"""Each parameter of each plugin, by plugin_parameters.yaml: its default and what is read of it."""

import math
import pathlib

import pytest
import yaml
from bullet_sim.formats.urdf import parse_urdf
from plugin_robots import CAMERA, LINKS, robot_with

pytestmark = pytest.mark.usefixtures("sketches")

TABLE = yaml.safe_load(
    pathlib.Path(__file__).with_name("plugin_parameters.yaml").read_text(encoding="utf-8")
)
MIMIC = {"joint": "left_joint", "mimicJoint": "right_joint"}
NEEDED = {  # library -> parameters without which it does nothing, or has no default
    "gazebo_ros_camera": {"cameraName": "cam"},
    "gazebo_ros_ft_sensor": {"jointName": "left_joint", "topicName": "t"},
    "gazebo_ros_f3d": {"bodyName": "foot", "topicName": "t"},
    "gazebo_ros_imu_sensor": {"frameName": "f"},
    "gazebo_ros_force": {"bodyName": "base", "topicName": "t"},
    "gazebo_ros_vacuum_gripper": {"bodyName": "base", "topicName": "t"},
    "gazebo_ros_hand_of_god": {"linkName": "base"},
    "gazebo_ros_imu": {"bodyName": "foot"},
    "gazebo_ros_p3d": {"bodyName": "foot", "topicName": "t", "frameName": "world"},
    "gazebo_ros_joint_state_publisher": {"jointName": "left_joint"},
    "roboticsgroup_upatras_gazebo_mimic_joint_plugin": MIMIC,
    "diffdrive_plugin_6w": {
        f"{place}{side}Joint": f"{prefix}{side.lower()}_joint"
        for place, prefix in (("front", "front_"), ("mid", ""), ("rear", "rear_"))
        for side in ("Left", "Right")
    },
    "diffdrive_plugin_multi_wheel": {"leftJoints": "left_joint", "rightJoints": "right_joint"},
}
ABSOLUTE = (  # their default topic begins with a slash, so that no namespace goes before it
    "gazebo_ros_block_laser", "gazebo_ros_laser", "gazebo_ros_gpu_laser", "gazebo_ros_range",
    "gazebo_ros_imu", "gazebo_ros_velodyne_laser", "gazebo_ros_velodyne_gpu_laser",
)  # fmt: skip


def read(library, tags):
    """The description of a robot with this plugin, of the model or of a sensor."""
    return robot_with(library, "".join(f"<{tag}>{text}</{tag}>" for tag, text in tags.items()))


def value(library, tags, attribute):
    """An attribute of what is read, or one of the joint 'spare' or 'right' that mimics another."""
    model = read(library, tags)
    if attribute.startswith("mimic:"):
        joint, field = attribute[len("mimic:") :].split(".")
        mimic = model.joints[joint].mimic
        return mimic and getattr(mimic, field)
    found = model.sensors[0] if model.sensors else model
    for name in attribute.split("."):
        found = getattr(found, name)
    return plain(found)


def plain(found):
    """As YAML has it: lists, and mappings of strings."""
    if isinstance(found, dict):
        return {key: plain(item) for key, item in found.items()}
    if isinstance(found, (tuple, list)):
        return [plain(item) for item in found]
    return str(found) if isinstance(found, str) else found


@pytest.mark.parametrize(
    "library, tag", [(library, tag) for library, tags in TABLE.items() for tag in tags]
)
def test_a_parameter_and_its_default(library, tag):
    text, attribute, default, wanted = TABLE[library][tag]
    others = dict(NEEDED.get(library, {}))
    if tag == "robotNamespace" and library in ABSOLUTE:
        others["topicName"] = "t"
    for given, expected in ((others, default), ({**others, tag: text}, wanted)):
        found = value(library, given, attribute)
        if isinstance(expected, float) and math.isfinite(expected):
            expected = pytest.approx(expected)
        assert found == expected


SPECIAL = [  # library, parameters, attribute, what upstream's source makes of them
    ("gazebo_ros_diff_drive", {"odometrySource": "0"}, "from_wheels", False),
    ("gazebo_ros_diff_drive", {"odometrySource": "Encoder"}, "from_wheels", False),
    ("gazebo_ros_diff_drive", {"publishOdomTF": "no"}, "publish_tf", True),
    ("gazebo_ros_diff_drive", {"publishOdomTF": "False"}, "publish_tf", False),
    ("gazebo_ros_diff_drive", {"publishWheelJointState": "yes"}, "wheel_states_topic", ""),
    ("gazebo_ros_diff_drive", {"publishTf": "yes"}, "publish_odometry", False),
    ("gazebo_ros_diff_drive", {"publishTf": ""}, "publish_odometry", False),
    ("gazebo_ros_diff_drive", {"wheelTorque": "-2"}, "torque", 0.0),
    ("gazebo_ros_diff_drive", {"wheelSeparation": "-0.3"}, "separation", -0.3),
    ("gazebo_ros_skid_steer_drive", {"wheelAcceleration": "1"}, "acceleration", 0.0),
    ("gazebo_ros_skid_steer_drive", {"broadcastTF": "on"}, "publish_tf", False),
    ("gazebo_ros_tricycle_drive", {"publishWheelTF": "yes"}, "wheel_frames", []),
    ("diffdrive_plugin_multi_wheel", {"publishOdometryMsg": "yes"}, "publish_odometry", False),
    ("hector_gazebo_ros_magnetic", {"useMagneticFieldMsgs": "yes"}, "field_message", False),
    ("hector_gazebo_ros_magnetic", {"updatePeriod": "0 250000000"}, "rate", 4.0),
    ("hector_gazebo_ros_gps", {"updatePeriod": "2", "updateRate": "7"}, "rate", 0.5),
    ("hector_gazebo_ros_gps", {"xyzOffset": "1 2 3"}, "pose", [[0.0] * 3, [0.0] * 3]),
    ("hector_gazebo_ros_gps", {"useWorldSphericalCoordinates": "1"}, "latitude", None),
    ("hector_gazebo_ros_gps", {"useWorldSphericalCoordinates": "1"}, "heading", None),
]


@pytest.mark.parametrize("library, tags, attribute, expected", SPECIAL)
def test_what_upstream_makes_of_special_values(library, tags, attribute, expected):
    assert value(library, {**NEEDED.get(library, {}), **tags}, attribute) == expected


def test_of_several_joint_names_the_first_counts():
    names = "<jointName>left_joint</jointName><jointName>right_joint</jointName>"
    (spec,) = robot_with("gazebo_ros_joint_state_publisher", names).sensors
    assert spec.joints == ("left_joint",)


def test_parameters_of_a_cameras_distortion():
    lens = "<distortion><k1>-0.1</k1><center>0.5 0.5</center></distortion>"
    for tag, attribute in (("autoDistortion", "coefficients"), ("borderCrop", "crop")):
        found = []
        for text in ("true", "false"):
            body = (
                '<gazebo reference="base"><sensor name="s" type="camera"><update_rate>10'
                f"</update_rate><camera><horizontal_fov>1</horizontal_fov>{lens}</camera>"
                f'<plugin name="p" filename="libgazebo_ros_camera.so"><{tag}>{text}</{tag}>'
                "</plugin></sensor></gazebo>"
            )
            (spec,) = parse_urdf(f'<robot name="r">{LINKS}{body}</robot>', str, "bot").sensors
            found.append(spec)
        assert found[0] != found[1], (tag, attribute)


def test_the_level_of_the_log_is_that_of_the_last_plugin():
    for library in ("gazebo_ros_diff_drive", "gazebo_ros_tricycle_drive"):
        assert read(library, {"rosDebugLevel": "warn"}).log_level == "WARN", library
        assert read(library, {"rosDebugLevel": "na"}).log_level == "", library


def test_the_parameter_of_gazebo_ros_control():
    assert read("gazebo_ros_control", {}).robot_param == "robot_description"
    assert read("gazebo_ros_control", {"robotParam": "arm"}).robot_param == "arm"


REALSENSE = {  # parameter -> text, camera, attribute, default, read
    "colorTopicName": ("t", 0, "topic", "/p/color/image_raw", "/p/t"),
    "infrared1TopicName": ("t", 1, "topic", "/p/infra1/image_raw", "/p/t"),
    "infrared2TopicName": ("t", 2, "topic", "/p/infra2/image_raw", "/p/t"),
    "depthTopicName": ("t", 3, "topic", "/p/depth/image_raw", "/p/t"),
    "colorOpticalframeName": ("f", 0, "frame_id", "base", "f"),
    "infrared1OpticalframeName": ("f", 1, "frame_id", "base", "f"),
    "infrared2OpticalframeName": ("f", 2, "frame_id", "base", "f"),
    "depthOpticalframeName": ("f", 3, "frame_id", "base", "f"),
    "rangeMinDepth": ("3", 3, "range_min", 0.0, 3.0),
    "rangeMaxDepth": ("3", 3, "range_max", 65.535, 3.0),
    "pointCloud": ("true", 3, "points_topic", "", "/p/depth/color/points"),
    "pointCloudTopicName": ("t", 3, "points_topic", "/p/depth/color/points", "/p/t"),
    "pointCloudCutoff": ("3", 3, "cutoff", 0.0, 3.0),
    "pointCloudCutoffMax": ("3", 3, "cutoff_max", 5.0, 3.0),
}


def realsense(tags, prefix=""):
    """Specifications of the four cameras of a RealSense plugin."""
    cameras = "".join(
        f'<sensor name="{prefix}{name}" type="{kind}"><update_rate>30</update_rate>{CAMERA}'
        "</sensor>"
        for name, kind in (
            ("color", "camera"),
            ("ired1", "camera"),
            ("ired2", "camera"),
            ("depth", "depth"),
        )
    )
    texts = "".join(f"<{tag}>{text}</{tag}>" for tag, text in tags.items())
    plugin = f'<plugin name="p" filename="librealsense_gazebo_plugin.so">{texts}</plugin>'
    body = f'<gazebo reference="base">{cameras}</gazebo><gazebo>{plugin}</gazebo>'
    return parse_urdf(f'<robot name="r">{LINKS}{body}</robot>', str, "bot").sensors


@pytest.mark.parametrize("tag", REALSENSE)
def test_a_parameter_of_a_realsense(tag):
    text, camera, attribute, default, wanted = REALSENSE[tag]
    others = {"pointCloud": "true"} if tag.startswith("pointCloud") and tag != "pointCloud" else {}
    assert getattr(realsense(others)[camera], attribute) == pytest.approx(default)
    assert getattr(realsense({**others, tag: text})[camera], attribute) == pytest.approx(wanted)


def test_the_prefix_of_a_realsenses_cameras():
    found = realsense({"prefix": "front_"}, "front_")
    assert [spec.name for spec in found] == [
        f"front_{n}" for n in ("color", "ired1", "ired2", "depth")
    ]

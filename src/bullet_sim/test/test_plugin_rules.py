"""Namespaces and frames' prefixes that plugins take from outside their own element."""

import pytest
from bullet_sim.formats.sdf.world import parse_model, parse_world
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.rules import MODEL, NAMESPACE, NEAREST, OWN, RULES, FramePrefix
from plugin_robots import LINKS, robot_with

pytestmark = pytest.mark.usefixtures("sketches")

TAGS = (
    "<bodyName>base</bodyName><jointName>left_joint</jointName><linkName>base</linkName>"
    "<joint>left_joint</joint><mimicJoint>right_joint</mimicJoint><frameName>eye</frameName>"
    "<cameraName>cam</cameraName><topicName>t</topicName><updateRate>10</updateRate>"
    "<steeringJoint>left_joint</steeringJoint><actuatedWheelJoint>right_joint</actuatedWheelJoint>"
    "<encoderWheelLeftJoint>front_left_joint</encoderWheelLeftJoint>"
    "<encoderWheelRightJoint>front_right_joint</encoderWheelRightJoint>"
    "<leftJoints>left_joint front_left_joint</leftJoints><rightJoints>right_joint</rightJoints>"
    "<frontLeftJoint>front_left_joint</frontLeftJoint><midLeftJoint>left_joint</midLeftJoint>"
    "<rearLeftJoint>rear_left_joint</rearLeftJoint><midRightJoint>right_joint</midRightJoint>"
    "<frontRightJoint>front_right_joint</frontRightJoint>"
    "<rearRightJoint>rear_right_joint</rearRightJoint>"
)


def specs_of(library, namespace):
    """The specifications of a plugin of the model 'bot', as a plugin of a model or of a sensor."""
    return robot_with(library, namespace + TAGS)


@pytest.mark.parametrize("library", RULES)
@pytest.mark.parametrize("tag", ["", "<robotNamespace/>", "<robotNamespace>/</robotNamespace>"])
def test_namespaces_without_a_name(library, tag):
    rule, model = RULES[library], specs_of(library, tag)
    wanted = {"": rule.missing, "<robotNamespace/>": rule.empty}.get(tag)
    start = "/bot/" if wanted == MODEL else "/"
    if library == "gazebo_ros_control":
        assert model.control_namespace.rstrip("/") == start.rstrip("/")
    for spec in model.sensors:
        for name in ("topic", "command_topic"):
            topic = getattr(spec, name, "/tf")
            if topic != "/tf":
                assert topic.startswith("/bot/") == (start == "/bot/"), (name, topic)


EXPECTED = {  # library -> (missing, empty), as their sources have it
    "gazebo_ros_diff_drive": ("/bot/cmd_vel", "/bot/cmd_vel"),
    "gazebo_ros_skid_steer_drive": ("/cmd_vel", "/cmd_vel"),
    "gazebo_ros_planar_move": ("/cmd_vel", "/cmd_vel"),
    "gazebo_ros_tricycle_drive": ("/bot/cmd_vel", "/bot/cmd_vel"),
}
TOPICS = {
    "gazebo_ros_laser": ("/t", "/bot/t"),
    "gazebo_ros_camera": ("/cam/image_raw", "/bot/cam/image_raw"),
    "gazebo_ros_imu_sensor": ("/bot/t", "/t"),
    "gazebo_ros_bumper": ("/bumper_states", "/bumper_states"),
    "gazebo_ros_p3d": ("/t", "/t"),
    "gazebo_ros_range": ("/t", "/t"),
    "gazebo_ros_joint_state_publisher": ("/bot/joint_states", "/bot/joint_states"),
    "hector_gazebo_ros_gps": ("/t", "/t"),
}


@pytest.mark.parametrize("library", [*EXPECTED, *TOPICS])
def test_topics_of_some_plugins(library):
    attribute = "command_topic" if library in EXPECTED else "topic"
    wanted = {**EXPECTED, **TOPICS}[library]
    if "skid" in library:
        tags = "".join(
            f"<{side}{end}Joint>{end.lower()}_{side}_joint</{side}{end}Joint>"
            for side in ("left", "right")
            for end in ("Front", "Rear")
        )
    else:
        tags = ""
    found = tuple(
        getattr(specs_of(library, tag + tags).sensors[0], attribute)
        for tag in ("", "<robotNamespace/>")
    )
    assert found == wanted


WITH_SENSORS = {"gazebo_ros_kobuki"}  # needs many; test_kobuki.py has its frames


@pytest.mark.parametrize(
    "library", [name for name in RULES if RULES[name].prefix and name not in WITH_SENSORS]
)
def test_frames_know_where_their_prefix_comes_from(library):
    (spec, *_) = specs_of(library, "<robotNamespace>tb3</robotNamespace>").sensors
    frame = spec.prefix if library == "paddock_state_publisher" else spec.frame_id
    cameras = {"gazebo_ros_multicamera", "gazebo_ros_triggered_multicamera"}
    group = "/cam/left" if library in cameras else ""
    group = group or ("/cam" if hasattr(spec, "info_topic") else "")
    assert frame.prefix == FramePrefix(RULES[library].prefix, f"tb3{group}")


@pytest.mark.parametrize("library", [name for name in RULES if not RULES[name].prefix])
def test_frames_without_a_prefix(library):
    for spec in specs_of(library, "").sensors:
        assert getattr(getattr(spec, "frame_id", None), "prefix", None) is None


def test_a_name_with_a_slash_gets_no_prefix():
    text = "<robotNamespace>tb3</robotNamespace><frameName>/map</frameName><topicName>t</topicName>"
    plugin = f'<plugin filename="libgazebo_ros_p3d.so">{text}<bodyName>base</bodyName></plugin>'
    robot = f'<robot name="r">{LINKS}<gazebo>{plugin}</gazebo></robot>'
    (spec,) = parse_urdf(robot, str, "bot").sensors
    assert spec.frame_id == "map" and spec.frame_id.prefix is None
    assert getattr(spec.child_frame_id, "prefix", None) is None, "as upstream"


@pytest.mark.parametrize(
    "source, namespace, parameter, expected",
    [
        (OWN, "a", "", ""),
        (OWN, "a", "p", "p/"),
        (NEAREST, "a", "/p", "p/"),
        (NEAREST, "a", "p/", "p//"),  # as tf::resolve
        (NAMESPACE, "a", "", "a/"),
        (NAMESPACE, "", "p", "p/"),
        (NAMESPACE, "", "", ""),
    ],
)
def test_prefixes(source, namespace, parameter, expected):
    assert FramePrefix(source, namespace).of(parameter) == expected


def test_frames_of_wheels_are_those_of_the_merged_links():
    tags = "<robotNamespace>tb3</robotNamespace><publishWheelTF>1</publishWheelTF>"
    (spec,) = specs_of("gazebo_ros_diff_drive", tags).sensors
    assert spec.wheel_frames["left_joint"] == ("foot", "left")
    assert spec.wheel_frames["left_joint"][0].prefix == FramePrefix(NEAREST, "tb3")


CART = (
    '<sdf version="1.6"><model name="file"><link name="base"/>'
    + "".join(
        f'<link name="{side}"/><joint name="{side}_joint" type="revolute"><parent>base</parent>'
        f"<child>{side}</child><axis><xyz>0 1 0</xyz></axis></joint>"
        for side in ("left", "right")
    )
    + '<plugin name="d" filename="libgazebo_ros_diff_drive.so"/></model></sdf>'
)


def test_an_included_model_has_its_own_name_as_namespace(tmp_path):
    (tmp_path / "cart.sdf").write_text(CART)
    include = "<include><uri>cart</uri>{}</include>"
    text = (
        '<sdf version="1.6"><world name="w">'
        + "".join(include.format(f"<name>{name}</name>") for name in ("a", "b"))
        + include.format("")
        + "</world></sdf>"
    )
    world = parse_world(text, lambda _: str(tmp_path / "cart.sdf"))
    topics = [model.sensors[0].command_topic for model, _ in world.models]
    assert topics == ["/a/cmd_vel", "/b/cmd_vel", "/file/cmd_vel"]


def test_a_spawned_model_has_its_own_name_as_namespace(tmp_path):
    model, _ = parse_model(CART, str, name="c")
    assert (model.name, model.sensors[0].topic) == ("c", "/c/odom")
    (tmp_path / "cart.sdf").write_text(CART)
    text = '<sdf version="1.6"><world name="w"><include><uri>c</uri></include></world></sdf>'
    model, _ = parse_model(text, lambda _: str(tmp_path / "cart.sdf"), name="d")
    assert (model.name, model.sensors[0].topic) == ("d", "/d/odom")

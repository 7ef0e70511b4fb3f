"""Bases moved by forces, a tricycle's wheel or many wheels: what is read, and the arithmetic."""

import math
from types import SimpleNamespace

import pytest
from bullet_sim.controllers.bases import TricycleMotion, after_arc
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.bases import UNLIMITED, ForceMoveSpec, ManyWheelsSpec, TricycleSpec
from bullet_sim.plugins.forces import SlippingWheel

JOINTS = ("steer", "front", "left", "right")
ROBOT = (
    '<robot name="r"><link name="base_footprint"/><link name="base"/><joint name="f" type="fixed">'
    '<parent link="base_footprint"/><child link="base"/></joint>'
    + "".join(
        f'<link name="{name}"/><joint name="{name}_j" type="continuous"><parent link="base"/>'
        f'<child link="{name}"/></joint>'
        for name in JOINTS
    )
    + "{}</robot>"
)


def read(library, tags):
    """(specifications, warnings) of a plugin of the model 'bot'."""
    plugin = f'<gazebo><plugin name="p" filename="lib{library}.so">{tags}</plugin></gazebo>'
    model = parse_urdf(ROBOT.format(plugin), str, "bot")
    return model.sensors, model.warnings


def test_force_based_move_has_hectors_defaults():
    ((spec,), warnings) = read("gazebo_ros_force_based_move", "")
    assert spec == ForceMoveSpec("p", "base_footprint", base="base_footprint")
    assert (spec.gains, spec.timeout, spec.maxima) == ((1e4, 1e4, 100.0), -1.0, UNLIMITED)
    assert warnings == []


def test_force_based_move_reads_all_of_its_parameters():
    tags = (
        "<robotNamespace>ns</robotNamespace><commandTopic>go</commandTopic><odometryTopic>o"
        "</odometryTopic><odometryFrame>of</odometryFrame><robotBaseFrame>base</robotBaseFrame>"
        "<x_velocity_p_gain>1</x_velocity_p_gain><y_velocity_p_gain>2</y_velocity_p_gain>"
        "<yaw_velocity_p_gain>3</yaw_velocity_p_gain><odometryRate>50</odometryRate>"
        "<publishOdometryTf>false</publishOdometryTf>"
    )
    ((spec,), _) = read("gazebo_ros_force_based_move", tags)
    assert (spec.base, spec.gains, spec.rate, spec.publish_tf) == ("base", (1, 2, 3), 50.0, False)
    assert (spec.command_topic, spec.topic) == ("/ns/go", "/ns/o")
    assert (spec.frame_id, spec.child_frame_id) == ("of", "base")


@pytest.mark.parametrize(
    "library, tags, timeout, maxima, sideways, holds",
    [
        ("ridgeback_ros_force_based_move", "", 0.25, UNLIMITED, False, False),
        (
            "ridgeback_ros_force_based_move",
            "<cmdVelTimeOut>1</cmdVelTimeOut>",
            1.0,
            UNLIMITED,
            False,
            False,
        ),
        ("nexus_ros_force_based_move", "", 0.25, (0.6, 0.6, 0.5), True, False),
        (
            "nexus_ros_force_based_move",
            "<max_x_velocity>2</max_x_velocity><max_yaw_velocity>3</max_yaw_velocity>",
            0.25,
            (2.0, 2.0, 3.0),
            True,
            False,
        ),
        (
            "robotnik_force_based_move",
            "<commandWatchdog>1</commandWatchdog>",
            1.0,
            UNLIMITED,
            True,
            True,
        ),
        ("r550_force_based_move", "", -1.0, UNLIMITED, True, False),
    ],
)
def test_packages_variants_of_force_based_move(library, tags, timeout, maxima, sideways, holds):
    ((spec,), _) = read(library, tags)
    assert (spec.timeout, spec.maxima) == (timeout, maxima)
    assert (spec.sideways, spec.holds) == (sideways, holds)


WHEELS = (
    "<steeringJoint>steer_j</steeringJoint><actuatedWheelJoint>front_j</actuatedWheelJoint>"
    "<encoderWheelLeftJoint>left_j</encoderWheelLeftJoint>"
    "<encoderWheelRightJoint>right_j</encoderWheelRightJoint>"
)


def test_tricycle_has_upstreams_defaults():
    ((spec,), _) = read("gazebo_ros_tricycle_drive", WHEELS)
    assert spec == TricycleSpec(
        "p",
        "base_footprint",
        steering="steer_j",
        wheel="front_j",
        encoders=("left_j", "right_j"),
        command_topic="/bot/cmd_vel",
        topic="/bot/odom",
    )


def test_tricycle_reads_all_of_its_parameters():
    tags = WHEELS + (
        "<actuatedWheelDiameter>0.2</actuatedWheelDiameter><encoderWheelDiameter>0.3"
        "</encoderWheelDiameter><encoderWheelSeparation>0.7</encoderWheelSeparation>"
        "<wheelTorque>9</wheelTorque><wheelAcceleration>2</wheelAcceleration>"
        "<wheelSpeedTolerance>0.1</wheelSpeedTolerance><steeringSpeed>0.4</steeringSpeed>"
        "<steeringAngleTolerance>0.02</steeringAngleTolerance><odometrySource>encoder"
        "</odometrySource><updateRate>20</updateRate><publishWheelTF>true</publishWheelTF>"
        "<publishWheelJointState>true</publishWheelJointState><commandTopic>c</commandTopic>"
        "<odometryTopic>o</odometryTopic><odometryFrame>f</odometryFrame>"
        "<robotBaseFrame>b</robotBaseFrame><robotNamespace>ns</robotNamespace>"
    )
    ((spec,), _) = read("gazebo_ros_tricycle_drive", tags)
    assert (spec.diameter, spec.encoder_diameter, spec.separation) == (0.2, 0.3, 0.7)
    assert (spec.torque, spec.acceleration, spec.deceleration) == (9.0, 2.0, 2.0)
    assert (spec.speed_tolerance, spec.steering_speed, spec.angle_tolerance) == (0.1, 0.4, 0.02)
    assert (spec.from_wheels, spec.rate) == (True, 20.0)
    assert spec.wheel_states_topic == "/ns/joint_states"
    assert spec.wheel_frames[0] == ("base_footprint", "steer_j")
    assert (spec.command_topic, spec.topic) == ("/ns/c", "/ns/o")
    assert (spec.frame_id, spec.child_frame_id) == ("f", "b")
    ((spec,), _) = read(
        "gazebo_ros_tricycle_drive", tags + "<wheelDeceleration>5</wheelDeceleration>"
    )
    assert spec.deceleration == 5.0


def test_a_tricycle_without_a_joint_or_a_size_is_left_out():
    specs, (warning,) = read("gazebo_ros_tricycle_drive", "")
    assert specs == [] and "front_steering_joint" in warning
    specs, (warning,) = read(
        "gazebo_ros_tricycle_drive", WHEELS + "<actuatedWheelDiameter>0</actuatedWheelDiameter>"
    )
    assert specs == [] and "actuatedWheelDiameter" in warning


SIX = "".join(
    f"<{place}{side}Joint>{joint}</{place}{side}Joint>"
    for side, joint in (("Left", "left_j"), ("Right", "right_j"))
    for place in ("front", "mid", "rear")
)


def test_hectors_bases_of_many_wheels():
    ((spec,), _) = read("diffdrive_plugin_6w", SIX + "<topicName>go</topicName>")
    assert (spec.left, spec.right) == (("left_j",) * 3, ("right_j",) * 3)
    assert (spec.separation, spec.diameter, spec.rate) == (0.34, 0.15, 0.0)
    assert (spec.command_topic, spec.topic) == ("/go", "/odom")
    assert (spec.publish_odometry, spec.publish_tf, spec.resets) == (False, False, True)
    tags = (
        "<leftJoints>left_j front_j</leftJoints><rightJoints>right_j</rightJoints><wheelSeparation>"
        "0.5</wheelSeparation><wheelDiameter>0.2</wheelDiameter><updateRate>50</updateRate>"
        "<publishOdometryTf>false</publishOdometryTf><commandTopic>c</commandTopic>"
    )
    ((spec,), _) = read("diffdrive_plugin_multi_wheel", tags)
    assert spec == ManyWheelsSpec(
        "p",
        "base_footprint",
        left=("left_j", "front_j"),
        right=("right_j",),
        separation=0.5,
        diameter=0.2,
        publish_odometry=True,
        rate=50.0,
        command_topic="/c",
    )
    specs, warnings = read("diffdrive_plugin_multi_wheel", "")
    assert specs == [] and "names joints (none)" in warnings[0]


@pytest.mark.parametrize(
    "x, y, rate, seconds, wanted",
    [
        (1.0, 0.5, 0.0, 2.0, (2.0, 1.0, 0.0)),
        (0.0, 0.0, 0.5, 2.0, (0.0, 0.0, 1.0)),
        (1.0, 0.0, math.pi / 2, 1.0, (2 / math.pi, 2 / math.pi, math.pi / 2)),
        (0.0, 1.0, math.pi / 2, 1.0, (-2 / math.pi, 2 / math.pi, math.pi / 2)),
        (-1.0, 0.0, math.pi, 1.0, (0.0, -2 / math.pi, math.pi)),
    ],
)
def test_ways_on_arcs(x, y, rate, seconds, wanted):
    assert after_arc((0.0, 0.0, 0.0), x, y, rate, seconds) == pytest.approx(wanted, abs=1e-12)
    px, py, _ = after_arc((5.0, 6.0, math.pi / 2), x, y, rate, seconds)
    assert (px, py) == pytest.approx((5.0 - wanted[1], 6.0 + wanted[0]), abs=1e-12)


def test_a_full_circle_in_parts_ends_where_it_began():
    pose = (1.0, 2.0, 0.3)
    for _ in range(100):
        pose = after_arc(pose, 0.7, 0.2, 2 * math.pi / 10.0, 0.1)
    assert pose == pytest.approx((1.0, 2.0, 0.3 + 2 * math.pi), abs=1e-9)


def tricycle(**values):
    wheels = {"steering": "s", "wheel": "w", "encoders": ("l", "r")}
    return TricycleMotion(TricycleSpec("t", "base", **wheels, **values))


def test_encoders_turn_to_the_side_of_the_slower_wheel_as_upstream():
    motion = tricycle(encoder_diameter=0.2, separation=0.5)
    for step in range(1, 101):
        motion.measure(0.01 * step, 2.0, 1.0)  # rims at 0.2 and 0.1 m/s for 1 s
    assert motion.pose[2] == pytest.approx(0.1 / 0.5)  # counter-clockwise, though left is faster
    radius, turned = 0.15 / 0.2, 0.2
    assert motion.pose[:2] == pytest.approx(
        (radius * math.sin(turned), radius * (1 - math.cos(turned))), abs=1e-5
    )
    assert math.hypot(*motion.twist[:2]) == pytest.approx(0.15)
    assert motion.twist[2] == pytest.approx(0.2)


@pytest.mark.parametrize(
    "values, target, speed, wanted",
    [
        ({}, 5.0, 1.0, 5.0),
        (dict(acceleration=2.0, deceleration=4.0), 5.0, 1.0, 1.4),
        (dict(acceleration=2.0, deceleration=4.0), 0.0, 1.0, 0.8),
        (dict(acceleration=2.0, deceleration=4.0), 1.1, 1.0, 1.1),
        (dict(acceleration=2.0, deceleration=4.0), 1.005, 1.0, 1.0),
    ],
    ids=["at once", "faster, by the deceleration", "slower", "near", "within the tolerance"],
)
def test_the_speed_of_a_tricycles_wheel(values, target, speed, wanted):
    assert tricycle(**values).wheel_speed(target, speed, 0.1) == pytest.approx(wanted)


@pytest.mark.parametrize(
    "target, angle, speed, wanted",
    [(0.5, 0.0, 0.0, 0.4), (0.0, 0.5, 0.0, -0.4), (0.005, 0.0, 9.0, 0.0), (0.0, 0.5, 2.0, 0.4)],
)
def test_the_speed_of_a_tricycles_steering(target, angle, speed, wanted):
    assert tricycle(steering_speed=0.4).steering_speed(target, angle, speed) == wanted


def test_what_a_tricycle_has_measured_is_saved():
    motion = tricycle()
    motion.measure(0.1, 1.0, 1.0)
    other = tricycle()
    other.set_state(motion.get_state())
    assert SimpleNamespace(**vars(other)).pose == motion.pose


SHAPE = '<collision><geometry><cylinder radius="0.2" length="0.1"/></geometry></collision>'
SLIP = (
    '<robot name="r"><link name="base"/><link name="w">{shape}</link><joint name="j" '
    'type="continuous"><parent link="base"/><child link="w"/></joint><gazebo><plugin name="p" '
    'filename="lib{library}.so">{tags}</plugin></gazebo></robot>'
)
WHEEL = (
    '<wheel link_name="w"><slip_compliance_lateral>1</slip_compliance_lateral>'
    "<slip_compliance_longitudinal>2</slip_compliance_longitudinal>{}</wheel>"
)
FORCE = "<wheel_normal_force>30</wheel_normal_force>"


def slipping(tags, library="gazebo_ros_wheel_slip", shape=SHAPE):
    return parse_urdf(SLIP.format(shape=shape, library=library, tags=tags), str, "bot")


def test_wheels_that_slip():
    (spec,) = slipping(WHEEL.format(FORCE)).sensors
    assert spec.wheels == (SlippingWheel("w", "j", 0.2, 30.0, 1.0, 2.0),)
    assert spec.namespace == "/bot/wheel_slip"
    tags = WHEEL.format(FORCE + "<wheel_radius>0.5</wheel_radius>")
    (spec,) = slipping(tags + "<robotNamespace>/ns/</robotNamespace>").sensors
    assert (spec.wheels[0].radius, spec.namespace) == (0.5, "/bot/ns")
    (spec,) = slipping(tags, "WheelSlipPlugin").sensors
    assert spec.namespace == "", "Gazebo's own has no ROS"


@pytest.mark.parametrize(
    "tags, shape, word",
    [
        ("", SHAPE, "no <wheel>"),
        (WHEEL.format(""), SHAPE, "normal force 0 N"),
        (WHEEL.format(FORCE), "", "0 collisions"),
        (WHEEL.format(FORCE), SHAPE.replace("cylinder", "box").replace("radius", "size"), "radius"),
        (WHEEL.format(FORCE).replace('"w"', '"x"'), SHAPE, "0 joints"),
    ],
)
def test_wheels_that_cannot_slip_are_left_out(tags, shape, word):
    model = slipping(tags, shape=shape)
    assert model.sensors == [] and any(word in warning for warning in model.warnings)

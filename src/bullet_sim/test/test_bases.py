"""Bases moved by forces, a tricycle's wheel or many wheels: what is read, and the arithmetic."""

import math
from types import SimpleNamespace

import pytest
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.bases import (
    UNLIMITED,
    ManyWheelsSpec,
    TricycleMotion,
    TricycleSpec,
    after_arc,
)
from bullet_sim.plugins.forces import SlippingWheel

pytestmark = pytest.mark.usefixtures("sketches")

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


@pytest.mark.parametrize(
    "name, timeout, maxima, sideways, holds",
    [
        ("ridgeback_ros", 0.25, UNLIMITED, False, False),
        ("nexus_ros", 0.25, (0.6, 0.6, 0.5), True, False),
        ("robotnik", 2.0, UNLIMITED, True, True),
        ("r550", -1.0, UNLIMITED, True, False),
    ],
)
def test_packages_variants_of_force_based_move(name, timeout, maxima, sideways, holds):
    ((spec,), _) = read(f"{name}_force_based_move", "")
    assert (spec.timeout, spec.maxima) == (timeout, maxima)
    assert (spec.sideways, spec.holds) == (sideways, holds)


WHEELS = (
    "<steeringJoint>steer_j</steeringJoint><actuatedWheelJoint>front_j</actuatedWheelJoint>"
    "<encoderWheelLeftJoint>left_j</encoderWheelLeftJoint>"
    "<encoderWheelRightJoint>right_j</encoderWheelRightJoint>"
)


@pytest.mark.parametrize(
    "tags, wanted", [("", 2.0), ("<wheelDeceleration>5</wheelDeceleration>", 5.0)]
)
def test_a_tricycle_brakes_as_it_accelerates_unless_it_is_told(tags, wanted):
    tags = WHEELS + "<wheelAcceleration>2</wheelAcceleration>" + tags
    ((spec,), _) = read("gazebo_ros_tricycle_drive", tags)
    assert (spec.acceleration, spec.deceleration) == (2.0, wanted)


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
    ((spec,), _) = read("diffdrive_plugin_6w", SIX)
    assert (spec.left, spec.right, spec.rate) == (("left_j",) * 3, ("right_j",) * 3, 0.0)
    assert (spec.publish_odometry, spec.publish_tf, spec.resets) == (False, False, True)
    tags = "<leftJoints>left_j front_j</leftJoints><rightJoints>right_j</rightJoints>"
    ((spec,), _) = read("diffdrive_plugin_multi_wheel", tags)
    wheels = {"left": ("left_j", "front_j"), "right": ("right_j",)}
    both = {"publish_odometry": True, "publish_tf": True}
    assert spec == ManyWheelsSpec("p", "base_footprint", **wheels, **both, rate=100.0)
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

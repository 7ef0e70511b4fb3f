"""Gazebo's own plugins that act without a command of its transport, without a ROS master."""

import math

import numpy as np
import pytest
from bullet_bridge.plugins import joints
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.gazebo import (
    InitialVelocitySpec,
    LiftDragSpec,
    RandomVelocitySpec,
    StandingWheelsSpec,
)
from bullet_sim.pose import Pose
from fake_impl import FakeServer, fake_publishers, in_thread, plugin_of
from urdf_texts import link

GRAVITY = (0.0, 0.0, 0.0)

LINK = link("{}")
JOINT = (
    '<joint name="{0}" type="continuous"><parent link="base"/><child link="{0}_link"/>'
    '<axis xyz="0 1 0"/></joint>'
)
PLUGIN = '<gazebo><plugin name="p" filename="lib{}.so">{}</plugin></gazebo>'
NAMED = "<robotNamespace>bot</robotNamespace>"
WHEELS = "<left_joint>left</left_joint><right_joint>{}</right_joint>"


def robot(library, tags):
    links = "".join(map(LINK.format, ("base", "left_link", "right_link")))
    joints = "".join(map(JOINT.format, ("left", "right")))
    return f'<robot name="r">{links}{joints}{PLUGIN.format(library, tags)}</robot>'


def prepared(world, text):
    model = world.spawn_urdf("r", text, Pose((0.0, 0.0, 1.0)), str)
    plugin = plugin_of(world, model, model.description.sensors[0])
    plugin.prepare()
    assert not plugin.needs_update()
    return model


def test_wheels_without_a_command_stand(world):
    found = parse_urdf(robot("DiffDrivePlugin", WHEELS.format("right")), str)
    assert found.sensors == [StandingWheelsSpec("p", "base", ("left", "right"))]
    assert "Gazebo's own transport" in found.warnings[-1]
    lacking = parse_urdf(robot("DiffDrivePlugin", WHEELS.format("nose")), str)
    assert lacking.sensors == [] and "nose" in lacking.warnings[-1]
    model = prepared(world, robot("DiffDrivePlugin", WHEELS.format("right")))
    for _ in range(100):
        model.joints.add_effort("left", 5.0)
        world.step()
    assert model.joints.state()[0] == pytest.approx({"left": 0.0, "right": 0.0}, abs=0.02)


def test_a_link_has_another_random_velocity_after_each_period(world):
    tags = (
        "<link>base</link><initial_velocity>0 0.5 0</initial_velocity><velocity_factor>2"
        "</velocity_factor><update_period>0.1</update_period><min_z>0</min_z><max_z>0</max_z>"
        "<min_x>1.5</min_x><max_x>-1.5</max_x>"
    )
    text = robot("RandomVelocityPlugin", tags)
    (spec,) = parse_urdf(text, str).sensors
    wanted = (0.0, 0.5, 0.0), 2.0, 0.1, (-1.5, 1.5), (-math.inf, math.inf), (0.0, 0.0)
    assert spec == RandomVelocitySpec("p", "base", *wanted)
    model = world.spawn_urdf("r", text, Pose((0.0, 0.0, 1.0)), str)
    plugin = plugin_of(world, model, spec)
    plugin.prepare()
    seen = []
    for _ in range(350):
        world.step()
        plugin.update(world.time, world.time_step)
        seen.append(tuple(model.body.link_motion("base")[2]))
    periods = list(dict.fromkeys(seen))
    assert periods[0] == (0.0, 0.5, 0.0) and len(periods) == 4
    assert [seen.index(velocity) for velocity in periods[1:]] == [99, 200, 301]
    for x, _, z in periods[1:]:
        assert abs(x) <= 1.5 and z == 0.0
    assert max(math.hypot(*velocity) for velocity in periods) <= 2.0
    missing = parse_urdf(robot("RandomVelocityPlugin", "<link>nose</link>"), str)
    assert missing.sensors == [] and "nose" in missing.warnings[0]


def test_a_model_begins_with_its_velocity(world):
    tags = "<linear>1 0 0.5</linear><angular>0 0 2</angular>"
    (spec,) = parse_urdf(robot("InitialVelocityPlugin", tags), str).sensors
    assert spec == InitialVelocitySpec("p", "base", (1.0, 0.0, 0.5), (0.0, 0.0, 2.0))
    model = prepared(world, robot("InitialVelocityPlugin", tags))
    world.step(500)
    assert model.pose.position == pytest.approx((0.5, 0.0, 1.25), abs=0.01)
    assert model.pose.rpy[2] == pytest.approx(1.0, abs=0.01)


WING = "<link_name>base</link_name><area>0.5</area><cla>2</cla><cda>0.4</cda><a0>0.1</a0>"


def test_a_wings_tags_and_defaults(world):
    (spec,) = parse_urdf(robot("LiftDragPlugin", "<link_name>base</link_name>"), str).sensors
    assert spec == LiftDragSpec("p", "base")
    tags = (
        "<alpha_stall>0.3</alpha_stall><cla_stall>-1</cla_stall><cda_stall>2</cda_stall>"
        "<cp>1 2 3</cp><forward>0 2 0</forward><upward>0 0 3</upward><air_density>1</air_density>"
        "<radial_symmetry>1</radial_symmetry><control_joint_name>left</control_joint_name>"
        "<control_joint_rad_to_cl>-3</control_joint_rad_to_cl>"
    )
    (spec,) = parse_urdf(robot("LiftDragPlugin", WING + tags), str).sensors
    assert spec == LiftDragSpec(
        "p", "base", 0.1, 2.0, 0.4, 0.3, -1.0, 2.0, (1.0, 2.0, 3.0), (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0), 0.5, 1.0, True, "left", -3.0,
    )  # fmt: skip
    lacking = parse_urdf(robot("LiftDragPlugin", WING + tags.replace("left", "nose")), str)
    assert lacking.sensors[0].joint == "" and "'nose'" in lacking.warnings[-1]
    assert parse_urdf(robot("LiftDragPlugin", "<link_name>x</link_name>"), str).sensors == []


@pytest.mark.parametrize("attack", [-0.3, 0.0, 0.2])
def test_lift_and_drag_of_an_angle_of_attack(attack):
    """cl = cla (a0 + a), cd = |cda (a0 + a)|; q = rho v^2 / 2."""
    spec = LiftDragSpec("w", "l", a0=0.1, cla=2.0, cda=0.4, area=0.5, density=1.2)
    velocity = 10.0 * np.array((math.cos(attack), 0.0, -math.sin(attack)))
    force = spec.force(np.eye(3), velocity)
    pressure = 0.5 * 1.2 * 100.0 * 0.5
    lift, drag = pressure * 2.0 * (0.1 + attack), pressure * 0.4 * abs(0.1 + attack)
    up = np.array((math.sin(attack), 0.0, math.cos(attack)))
    assert force == pytest.approx(lift * up - drag * velocity / 10.0, abs=1e-9)
    assert not spec.force(np.eye(3), 0.0009 * velocity).any(), "no lift below 0.01 m/s"
    stalled = LiftDragSpec("w", "l", cla=2.0, alpha_stall=0.1, cla_stall=-30.0, cda=0.0)
    assert stalled.force(np.eye(3), velocity) @ up == pytest.approx(0.0, abs=1e-9)


def test_a_wing_that_falls_flat_is_braked():
    """Its angle of attack is a right one."""
    spec = LiftDragSpec("w", "l", cla=0.0, cda=0.4, area=0.5, density=1.2)
    force = spec.force(np.eye(3), np.array((0.0, 0.0, -10.0)))
    assert force == pytest.approx((0.0, 0.0, 30.0 * 0.4 * 0.5 * math.pi), abs=1e-9)


def test_a_wing_lifts_its_model_and_its_flap_adds_to_it(world):
    tags = "<control_joint_name>left</control_joint_name><cp>0 0.2 0</cp>"
    text = robot("LiftDragPlugin", WING + tags)
    model = world.spawn_urdf("r", text, Pose((0.0, 0.0, 1.0)), str)
    plugin = plugin_of(world, model, model.description.sensors[0])
    for angle, lift in ((0.0, 0.2), (0.1, 0.6)):  # cla a0, and 4 / rad
        model.set_state(Pose((0.0, 0.0, 1.0)), (10.0, 0.0, 0.0))
        model.joints.set_positions({"left": angle})
        plugin.update(world.time, 0.0)
        before = model.link_state("base")
        world.step()
        _, linear, angular = model.link_state("base")
        rise = (linear - before[1])[2] / world.time_step
        assert rise == pytest.approx(0.5 * 1.2041 * 100.0 * 0.5 * lift / 3.0, rel=0.2)
        assert (angular - before[2])[0] > 0.0, "the center of pressure is on the left"


def following(tags):
    """A joint 'right' that follows 'left' by the mimic plugin."""
    pair = "<joint>left</joint><mimicJoint>right</mimicJoint><maxEffort>2</maxEffort>"
    return robot("roboticsgroup_upatras_gazebo_mimic_joint_plugin", pair + tags)


@pytest.mark.parametrize(
    "tags, name",
    [
        ("<hasPID/>", "/gazebo_ros_control/pid_gains/right"),
        (
            "<robotNamespace>bot</robotNamespace><hasPID/>",
            "/bot/gazebo_ros_control/pid_gains/right",
        ),
        (NAMED + "<hasPID>mine</hasPID>", "/bot/mine"),
    ],
)
def test_names_of_a_mimics_gains(tags, name):
    (spec,) = parse_urdf(following(tags), str).sensors
    assert (spec.joint, spec.topic) == ("right", name)
    assert parse_urdf(following(""), str).sensors == []


@pytest.mark.parametrize("values", [{"p": 3.0, "d": 0.4}, None, {"i": 1.0}, {"p": "x"}])
def test_a_mimic_with_a_pid_is_pushed_by_it_and_moves_freely_without_gains(
    values, world, monkeypatch
):
    fake_publishers(monkeypatch)
    monkeypatch.setattr(joints.rospy, "get_param", lambda name, default: values)
    tags = "<hasPID/><multiplier>0.5</multiplier>"
    model = world.spawn_urdf("r", following(tags), Pose((0.0, 0.0, 1.0)), str)
    plugin = in_thread(plugin_of(world, model, model.description.sensors[0]))
    plugin.prepare()
    server = FakeServer.made["/gazebo_ros_control/pid_gains/right"]
    pushed, add_effort = [], model.joints.add_effort

    def note(name, effort):
        pushed.append(effort)
        add_effort(name, effort)

    monkeypatch.setattr(model.joints, "add_effort", note)
    model.joints.set_positions({"left": 3.0, "right": 0.0})
    usable = bool(values) and values.get("p") == 3.0
    world.step()
    assert pushed == [2.0 if usable else 0.0], "1.5 rad times 3, at most 2 N m"
    world.step(4000)
    left, right = (model.joints.state()[0][name] for name in ("left", "right"))
    assert right == pytest.approx(0.5 * left if usable else 0.0, abs=1e-3)
    values = {**server.values, "p": 0.0, "d": 0.0}
    assert server.callback(values, 0) == values
    bad = server.callback({**values, "p": math.nan}, 0)
    assert bad == values, "what is no number is refused"
    pushed.clear()
    model.joints.set_positions({"left": 1.0, "right": 0.0})
    world.step()
    assert pushed == [0.0]

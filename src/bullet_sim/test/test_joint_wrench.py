"""Force and torque in joints: weights, pushes, contacts, motors; net force on a link."""

import math

import numpy as np
import pytest
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.sensors.inertial import joint_wrench, net_wrench
from bullet_sim.world import World

WEIGHT, ARM = 2.0 * 9.81, 0.3  # [N], [m]
LINK = (
    '<link name="{0}"><inertial><origin xyz="{1}"/><mass value="{2}"/><inertia ixx="0.01" '
    'iyy="0.02" izz="0.03" ixy="0.002" ixz="0" iyz="0"/></inertial>{3}</link>'
)
FOOT = '<collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>'
PLUGIN = (
    '<gazebo><plugin filename="libgazebo_ros_ft_sensor.so"><jointName>j</jointName>'
    "<topicName>load</topicName>{}</plugin></gazebo>"
    '<gazebo reference="j"><preserveFixedJoint>true</preserveFixedJoint></gazebo>'
)


def _arm(joint, rpy="0 0 0", extra=""):
    return (
        '<robot name="r"><link name="world"/>'
        + LINK.format("a", "0 0 0", 1, "")
        + LINK.format("b", f"{ARM} 0 0", 2, "")
        + f'<joint name="f" type="fixed"><origin xyz="0 0 2" rpy="{rpy}"/><parent link="world"/>'
        '<child link="a"/></joint>'
        f'<joint name="j" {joint}<parent link="a"/><child link="b"/></joint>'
        + PLUGIN.format("")
        + extra
        + "</robot>"
    )


STIFF = (
    'type="fixed">',
    'type="revolute"><axis xyz="0 1 0"/><limit lower="0" upper="0" effort="9" velocity="9"/>',
)


@pytest.mark.parametrize("solver", ["ode", "bullet"])
@pytest.mark.parametrize("joint", STIFF)
@pytest.mark.parametrize("rpy", ["0 0 0", "1.2 0 0", "0 0.7 0", "0.3 -0.4 2.0"])
def test_a_stiff_joint_bears_the_weight_beyond_it(joint, rpy, solver):
    """As Gazebo: what the child does to the parent, in the child's axes, about the joint."""
    world = World(solver=solver)
    model = world.spawn_urdf("r", _arm(joint, rpy), Pose(), str)
    assert model.joints.names == ()
    world.step(300)
    force, torque = joint_wrench(model, "j")
    axes = Pose.from_xyz_rpy((0, 0, 0), tuple(map(float, rpy.split()))).matrix
    pull = axes.T @ np.array((0.0, 0.0, -WEIGHT))
    assert force == pytest.approx(pull, abs=1e-4)
    assert torque == pytest.approx(np.cross((ARM, 0.0, 0.0), pull), abs=1e-4)
    world.close()


@pytest.mark.parametrize("solver", ["ode", "bullet"])
def test_each_of_two_robots_bears_its_own_weight(solver):
    world = World(solver=solver)
    heavy = _arm(STIFF[0]).replace('<mass value="2"/>', '<mass value="6"/>')
    one = world.spawn_urdf("one", _arm(STIFF[0]), Pose(), str)
    other = world.spawn_urdf("other", heavy, Pose((0.0, 3.0, 0.0)), str)
    world.step(300)
    assert joint_wrench(one, "j")[0][2] == pytest.approx(-WEIGHT, abs=1e-4)
    assert joint_wrench(other, "j")[0][2] == pytest.approx(-3.0 * WEIGHT, abs=1e-4)
    world.close()


def test_a_push_on_the_child_is_felt():
    world = World()
    model = world.spawn_urdf("r", _arm(STIFF[0]), Pose(), str)
    world.forces.apply_wrench(model, "b", (5.0, 0.0, 3.0), (0.0, 0.0, 1.0), (0, math.inf))
    world.step(100)
    force, torque = joint_wrench(model, "j")
    assert force == pytest.approx((5.0, 0.0, 3.0 - WEIGHT), abs=1e-4)
    assert torque == pytest.approx((0.0, -ARM * (3.0 - WEIGHT), 1.0), abs=1e-4)
    world.close()


def test_a_foot_on_the_ground_bears_what_stands_on_it():
    """A carriage of 5 kg on a vertical rail stands on a foot of 2 kg."""
    text = (
        '<robot name="r"><link name="world"/>'
        + LINK.format("carriage", "0 0 0", 5, "")
        + LINK.format("foot", "0 0 0", 2, FOOT)
        + '<joint name="rail" type="prismatic"><origin xyz="0 0 1"/><parent link="world"/><child '
        'link="carriage"/><axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="9" velocity="9"/>'
        '</joint><joint name="j" type="fixed"><origin xyz="0 0 -0.9"/><parent link="carriage"/>'
        '<child link="foot"/></joint>' + PLUGIN.format("") + "</robot>"
    )
    world = World()
    ground = '<sdf version="1.6"><model name="g"><static>true</static><link name="l"><collision '
    ground += 'name="c"><geometry><plane/></geometry></collision></link></model></sdf>'
    world.spawn_sdf("g", ground, Pose(), str)
    model = world.spawn_urdf("r", text, Pose(), str)
    world.step(2000)
    force, _ = joint_wrench(model, "j")
    assert force[2] == pytest.approx(5.0 * 9.81, rel=0.02)
    world.close()


def test_a_motor_holds_an_arm_with_its_effort():
    joint = 'type="revolute"><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="50" '
    control = '<gazebo><plugin filename="libgazebo_ros_control.so"/></gazebo>'
    world = World()
    model = world.spawn_urdf("r", _arm(joint + 'velocity="9"/>', extra=control), Pose(), str)
    kind = "position_controllers/JointPositionController"
    model.manager.load("c", {"type": kind, "joint": "j"})
    model.manager.switch(["c"], [])
    world.step(500)
    force, torque = joint_wrench(model, "j")
    assert force == pytest.approx((0.0, 0.0, -WEIGHT), abs=0.01)
    assert torque == pytest.approx((0.0, ARM * WEIGHT, 0.0), abs=0.02)
    world.close()


def test_the_net_force_is_mass_times_acceleration():
    force, torque = net_wrench(
        2.0,
        np.diag((1.0, 2.0, 3.0)),
        (np.zeros(3), np.zeros(3)),
        (np.array((0.1, 0.0, 0.0)), np.array((0.0, 0.0, 0.2))),
        0.1,
    )
    assert force == pytest.approx((2.0, 0.0, 0.0)) and torque == pytest.approx((0.0, 0.0, 6.0))


def test_a_joint_that_does_not_exist_is_a_warning():
    model = parse_urdf(_arm(STIFF[0]).replace(">j<", ">none<"), str, "r")
    assert not model.sensors and "jointName 'none'" in str(model.warnings)


@pytest.mark.parametrize("solver", ["bullet", "ode"])
@pytest.mark.parametrize("count", [1, 20])
def test_controllers_of_joints_beyond_a_measured_one(solver, count):
    """A fixed joint that is measured is one of the engine's, and none of the controllers'."""
    pushed = (
        LINK.format("c", "0 0 0", 1, "") + '<joint name="k" type="continuous"><parent link="b"/>'
        '<child link="c"/><axis xyz="1 0 0"/><limit effort="5" velocity="90"/></joint>'
        '<gazebo><plugin name="g" filename="libgazebo_ros_control.so"/></gazebo>'
    )
    world = World(solver=solver)
    model = world.spawn_urdf("r", _arm('type="fixed">', extra=pushed), Pose(), str)
    manager = model.manager
    gains = {"p": 0.2, "i": 0.0, "d": 0.0}
    kind = "effort_controllers/JointVelocityController"
    manager.load("c", {"type": kind, "joint": "k", "pid": gains})
    manager.switch(["c"], [])
    manager.command("c", [3.0])
    for _ in range(400 // count):
        world.step(count)
    assert model.joints.names == ("k",)
    assert model.joints.state()[1]["k"] == pytest.approx(3.0, abs=0.05)
    manager.hardware.read()
    (joint,) = manager.hardware.handles(("k",))
    assert (joint.position, joint.velocity) == tuple(values["k"] for values in model.joints.state())
    world.close()


def test_a_fixed_joint_that_merges_its_links_has_no_sensor_as_in_gazebo():
    text = _arm('type="fixed">')
    kept = parse_urdf(text, str)
    assert [spec.joint for spec in kept.sensors] == ["j"]
    merged = parse_urdf(text.replace("<preserveFixedJoint>true", "<preserveFixedJoint>false"), str)
    assert merged.sensors == []
    (warning,) = [text for text in merged.warnings if "jointName 'j'" in text]
    assert "<preserveFixedJoint>" in warning

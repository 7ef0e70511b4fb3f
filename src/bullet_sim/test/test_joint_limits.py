"""Limits of joints: once for each way on which a command comes, the same with both solvers."""

import math
from unittest.mock import Mock

import pytest
from bullet_sim.controllers.handle import JointHandle
from bullet_sim.controllers.limits import UNLIMITED_EFFORT, UNLIMITED_SPEED, JointLimits
from bullet_sim.controllers.pid import Pid, PidGains
from bullet_sim.description.model import Joint
from bullet_sim.pose import Pose
from bullet_sim.world import World
from fake_joints import limited_effort

STEP, INERTIA = 0.001, 0.02  # [s], [kg m^2]
BOUNDED = dict(lower=-1.0, upper=2.0, effort=5.0, velocity=3.0)
URDF = (
    '<robot name="bot"><link name="world"/><link name="base"><inertial><mass value="1"/><inertia '
    'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="held" '
    'type="fixed"><parent link="world"/><child link="base"/></joint><link name="disc"><inertial>'
    f'<mass value="1"/><inertia ixx="{INERTIA}" iyy="{INERTIA}" izz="{INERTIA}" ixy="0" ixz="0" '
    'iyz="0"/></inertial></link><joint name="axle" type="revolute"><parent link="base"/><child '
    'link="disc"/><axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="5" velocity="3"/></joint>'
    '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo></robot>'
)


def joint(kind="revolute", **limits):
    """A Joint of the description."""
    return Joint("axle", kind, "base", "disc", **limits)


@pytest.mark.parametrize(
    "method, arguments, limits, expected",
    [
        ("velocity", (7.0,), BOUNDED, 3.0),
        ("velocity", (-7.0,), BOUNDED, -3.0),
        ("velocity", (-2.5,), BOUNDED, -2.5),
        ("velocity", (1e9,), {}, UNLIMITED_SPEED),
        ("position", (7.0,), BOUNDED, 2.0),
        ("position", (-7.0,), BOUNDED, -1.0),
        ("position", (1e9,), {}, 1e9),
        ("effort", (7.0,), BOUNDED, 5.0),
        ("effort", (-1e9,), {}, -UNLIMITED_EFFORT),
        ("set_point", ("velocity", -7.0), BOUNDED, -3.0),
        ("set_point", ("velocity", 1e9), {}, 1e9),
        ("set_point", ("position", 7.0), BOUNDED, 7.0),
    ],
)
def test_a_command_is_held_within_the_limits(method, arguments, limits, expected):
    assert getattr(JointLimits(joint(**limits)), method)(*arguments) == expected


def test_limits_that_change_count_at_once():
    described = joint(**BOUNDED)
    limits = JointLimits(described)
    described.upper = 1.5
    assert limits.position(7.0) == 1.5
    assert limits.effort_bounds() == (5.0, -1.0, 1.5, 3.0)


@pytest.mark.parametrize(
    "position, velocity, effort, within, acts",
    [
        (0.0, 0.0, 3.0, 3.0, 3.0),
        (0.0, 0.0, 9.0, 5.0, 5.0),
        (0.0, 0.0, math.nan, 0.0, 0.0),
        (2.1, 0.0, 3.0, 0.0, 0.0),  # no further beyond a stop
        (2.1, 0.0, -3.0, -3.0, -3.0),
        (0.0, 3.1, 3.0, 0.0, 0.0),  # no faster than the limit of speed
        (0.0, 3.1, -3.0, -3.0, -3.0),
    ],
)
def test_the_effort_of_a_handle(position, velocity, effort, within, acts):
    handle = JointHandle("axle", joint(**BOUNDED), Mock(), Mock(is_stopped=False))
    handle.position, handle.velocity, handle.effort = position, velocity, effort
    assert limited_effort(handle) == (within, acts)


def test_gains_of_gazebo_ros_control_are_bounded_by_the_effort_and_by_gazebo():
    """The hardware interface bounds their output by the effort alone, Joint::SetForce by speed."""
    handle = JointHandle("axle", joint(**BOUNDED), Mock(), Mock(is_stopped=False))
    handle.gains_pid = Pid(PidGains(100.0))
    handle.set_velocity(50.0)
    assert handle.is_regulated and handle.gains_pid.target == 3.0
    handle.regulate(STEP)
    assert (handle.effort, limited_effort(handle)) == (300.0, (5.0, 5.0))
    handle.position = 2.1
    assert limited_effort(handle) == (5.0, 5.0)
    handle.velocity = 3.1
    assert limited_effort(handle) == (5.0, 0.0)


def test_a_continuous_joint_has_no_limits_in_gazebo():
    """sdformat leaves them out; those of ros_control hold."""
    limits = JointLimits(joint("continuous", effort=5.0, velocity=3.0))
    assert limits.of_force() == (0.0, 0.0)
    assert limits.effort_bounds()[::3] == (5.0, 3.0)
    assert JointLimits(joint(effort=5.0, velocity=3.0)).of_force() == (3.0, 5.0)


def by_controller(world, model):
    """A user's controller."""
    model.manager.hardware.handles(("axle",))[0].set_effort(100.0)


def by_service(world, model):
    """/gazebo/apply_joint_effort."""
    world.forces.apply_effort(model, "axle", 100.0, (0, math.inf))


@pytest.mark.parametrize("push", [by_controller, by_service])
@pytest.mark.parametrize("solver", ["ode", "bullet"])
def test_an_effort_is_bounded_and_ends_where_the_limit_of_speed_is(solver, push):
    """5 N m on 0.02 kg m^2: 0.25 rad/s a step, and no more beyond 3 rad/s."""
    world = World(STEP, solver=solver)
    model = world.spawn_urdf("bot", URDF, Pose(), str)
    push(world, model)
    world.step(8)
    assert model.joints.state()[1]["axle"] == pytest.approx(8 * 0.25, rel=1e-3)
    world.step(40)
    assert model.joints.state()[1]["axle"] == pytest.approx(3.25, rel=0.05)
    world.close()


@pytest.mark.parametrize("solver", ["ode", "bullet"])
def test_a_drive_plugin_sets_a_motor_whatever_the_limits(solver):
    world = World(STEP, solver=solver)
    model = world.spawn_urdf("bot", URDF, Pose(), str)
    model.joints.set_motor("axle", 6.0, 100.0)
    world.step(20)
    assert model.joints.state()[1]["axle"] == pytest.approx(6.0, rel=0.01)
    model.joints.drive_velocities(("axle",), (6.0,))
    world.step(200)
    assert model.joints.state()[1]["axle"] == pytest.approx(3.0, rel=0.01)
    world.close()

"""Limits of joints: once for each way on which a command comes, the same with both solvers."""

import math
from unittest.mock import Mock

import pytest
from bullet_sim.controllers.handle import JointHandle
from bullet_sim.controllers.interfaces import Registered
from bullet_sim.controllers.limits import (
    UNLIMITED_SPEED,
    CommandLimits,
    JointLimits,
    Limiter,
    command_limits,
)
from bullet_sim.controllers.pid import Pid, PidGains
from bullet_sim.description.model import Joint, SoftLimits
from bullet_sim.engine.quickstep import law
from bullet_sim.pose import Pose
from bullet_sim.world import World
from driving import drive_velocities
from fake_joints import limited_effort
from urdf_texts import CONTROL, link, robot
from urdf_texts import joint as hinge

STEP, INERTIA = 0.001, 0.02  # [s], [kg m^2]
BOUNDED = dict(lower=-1.0, upper=2.0, effort=5.0, velocity=3.0)
URDF = robot(
    '<link name="world"/>', link("base", 1, 1), hinge("held", "fixed", "world", "base"),
    link("disc", 1, INERTIA),
    hinge("axle", "revolute", "base", "disc", axis="0 0 1",
          more='<limit lower="-9" upper="9" effort="5" velocity="3"/>'),
    CONTROL,
)  # fmt: skip


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
    ],
)
def test_a_command_is_held_within_the_limits(method, arguments, limits, expected):
    assert getattr(JointLimits(joint(**limits)), method)(*arguments) == expected


def test_limits_that_change_count_at_once():
    described = joint(**BOUNDED)
    limits = JointLimits(described)
    described.upper = 1.5
    assert limits.position(7.0) == 1.5


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
    assert limited_effort(handle) == (0.0, 0.0)  # and is told so


def test_a_continuous_joint_has_no_limits_in_gazebo():
    """sdformat leaves them out; those of ros_control hold."""
    turning = joint("continuous", effort=5.0, velocity=3.0)
    assert JointLimits(turning).of_force() == (0.0, 0.0)
    assert command_limits(turning).effort_bounds()[:4:3] == (5.0, 3.0)
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
    drive_velocities(model.joints, ("axle",), (6.0,))
    world.step(200)
    assert model.joints.state()[1]["axle"] == pytest.approx(3.0, rel=0.01)
    world.close()


# joint_limits_interface: parameters, soft limits, and each handle by its source's formula

SOFT = SoftLimits(lower=-0.5, upper=1.5, k_position=4.0, k_velocity=10.0)
ALL = dict(
    has_position_limits=True,
    min_position=-0.25,
    max_position=0.75,
    has_velocity_limits=True,
    max_velocity=2.0,
    has_acceleration_limits=True,
    max_acceleration=8,
    has_jerk_limits=True,
    max_jerk=1.0,
    has_effort_limits=True,
    max_effort=4.0,
)


@pytest.mark.parametrize(
    "parameters, expected",
    [
        (None, CommandLimits(-1.0, 2.0, 3.0, None, 5.0, None, True)),
        (ALL, CommandLimits(-0.25, 0.75, 2.0, 8, 4.0, None, True)),
        ({k: v for k, v in ALL.items() if not k.startswith("has")},
         CommandLimits(-1.0, 2.0, 3.0, None, 5.0, None, True)),
        ({"has_position_limits": False, "has_velocity_limits": False, "has_effort_limits": False},
         CommandLimits(is_given=True)),
        ({"has_position_limits": True, "min_position": 0.0},
         CommandLimits(-1.0, 2.0, 3.0, None, 5.0, None, True)),
        ({"has_velocity_limits": 1, "max_velocity": 1.0},
         CommandLimits(-1.0, 2.0, 3.0, None, 5.0, None, True)),
        ({"has_velocity_limits": True, "max_velocity": "1.0"},
         CommandLimits(-1.0, 2.0, 3.0, None, 5.0, None, True)),
    ],
)  # fmt: skip
def test_parameters_override_the_limits_of_the_description(parameters, expected):
    """joint_limits_rosparam.h; jerk is read there and bounds nothing."""
    assert command_limits(joint(**BOUNDED, limit=(5.0, 3.0)), parameters) == expected


def test_what_an_urdf_gives_is_a_limit_also_where_it_is_zero():
    """joint_limits_urdf.h; a wheel with velocity="0" does not turn in Gazebo."""
    limits = command_limits(joint("continuous", limit=(0.0, 0.0)))
    assert (limits.max_effort, limits.max_speed, limits.lower) == (0.0, 0.0, -math.inf)
    assert not command_limits(joint("continuous")).is_given
    assert command_limits(joint("continuous"), {}).refusal("axle", "effort") != ""


def stepped(limits, goal, value, count, position=0.0, velocity=0.0, start=None):
    """What a Limiter makes of a command in each of some steps of 0.1 s."""
    limiter = Limiter(limits)
    if start is not None:
        limiter._last = start
    return [limiter.step(goal, value, position, velocity, 0.1)[0] for _ in range(count)]


def test_position_saturation():
    """PositionJointSaturationHandle: by at most max_velocity, from where the joint is at first."""
    limits = CommandLimits(-1.0, 1.0, speed=2.0)
    assert stepped(limits, "position", 9.0, 4, position=0.5) == pytest.approx([0.7, 0.9, 1.0, 1.0])
    assert Limiter(limits).bounds["position"] == (-1.0, 1.0)
    assert not Limiter(limits).gradual["position", False], "its motor keeps to the speed"
    assert Limiter(limits).gradual["position", True]
    assert not Limiter(CommandLimits(-1.0, 1.0)).gradual["position", True]


def test_position_soft_limits():
    """PositionJointSoftLimitsHandle: the speed falls with the way to the soft limit."""
    limits = CommandLimits(-1.0, 1.6, speed=2.0, soft=SOFT)
    expected, last = [], 1.0
    for _ in range(5):
        last = min(last + min(4.0 * (1.5 - last), 2.0) * 0.1, 1.6)
        expected.append(last)
    assert stepped(limits, "position", 9.0, 5, start=1.0) == pytest.approx(expected)
    beyond = stepped(limits, "position", 9.0, 1, start=1.6)
    assert beyond == pytest.approx([1.6 - 4.0 * 0.1 * 0.1]), "it is led back"
    free = CommandLimits(speed=2.0, soft=SOFT)  # a continuous joint
    assert stepped(free, "position", 9.0, 2, start=7.0) == pytest.approx([7.2, 7.4])


def test_velocity_saturation():
    """VelocityJointSaturationHandle: by at most max_acceleration, from 0 at first."""
    limits = CommandLimits(speed=2.0, acceleration=8.0)
    assert stepped(limits, "velocity", 9.0, 4) == pytest.approx([0.8, 1.6, 2.0, 2.0])
    assert stepped(limits, "velocity", -9.0, 2, start=0.5) == pytest.approx([-0.3, -1.1])
    assert not Limiter(CommandLimits(speed=2.0)).gradual["velocity", True]
    assert Limiter(CommandLimits(speed=2.0)).bounds["velocity"] == (-2.0, 2.0)


def test_velocity_soft_limits():
    """VelocityJointSoftLimitsHandle: by the joint's own position and velocity."""
    limits = CommandLimits(-1.0, 1.6, speed=3.0, soft=SOFT)
    assert stepped(limits, "velocity", 9.0, 1, position=1.25) == pytest.approx([1.0])
    assert stepped(limits, "velocity", 9.0, 1, position=1.75) == pytest.approx([-1.0])
    assert stepped(limits, "velocity", -9.0, 1, position=0.1) == pytest.approx([-2.4])
    quick = CommandLimits(-1.0, 1.6, speed=3.0, acceleration=5.0, soft=SOFT)
    assert stepped(quick, "velocity", 9.0, 1, velocity=0.2) == pytest.approx([0.7])
    assert stepped(CommandLimits(soft=SOFT), "velocity", 9.0, 1) == pytest.approx([9.0])


@pytest.mark.parametrize(
    "position, velocity, low, high",
    [
        (0.5, 0.0, -4.0, 4.0),
        (1.25, 0.5, -4.0, 4.0),  # 10 * (1 - 0.5) = 5
        (1.25, 0.9, -4.0, 1.0),  # no more than 1 rad/s there: 10 * (1 - 0.9)
        (1.25, 1.2, -4.0, -2.0),
        (-0.4, -0.5, 1.0, 4.0),  # -0.4 rad/s there: -10 * (-0.5 + 0.4)
    ],
)
def test_effort_soft_limits(position, velocity, low, high):
    """EffortJointSoftLimitsHandle."""
    limits = CommandLimits(-1.0, 1.6, speed=3.0, effort=4.0, soft=SOFT)
    bounds = law.effort_bounds(position, velocity, *limits.effort_bounds())
    assert bounds == pytest.approx((low, high))


def controlled(interface, limit, extra="", gains=None, **parameters):
    """World and Manager of a robot whose joint has a running controller of single joints."""
    kind = "continuous" if "lower" not in limit else "revolute"
    text = URDF.replace('"revolute"', f'"{kind}"').replace(
        '<limit lower="-9" upper="9" effort="5" velocity="3"/>', f"<limit {limit}/>{extra}"
    )
    world = World(gravity=(0.0, 0.0, 0.0))
    model = world.spawn_urdf("bot", text, Pose(), str)
    hardware = model.manager.hardware
    own = {"axle": command_limits(model.joints.limits["axle"], parameters or None)}
    hardware.set_registered(Registered({"axle": (interface,)}, limits=own))
    if gains is not None:
        hardware.set_gains("axle", gains)
    hardware.restart()
    goal = "Velocity" if interface == "velocity" else "Position"
    values = {"type": f"{interface}_controllers/Joint{goal}Controller", "joint": "axle"}
    model.manager.load("c", values)
    model.manager.switch(["c"], [])
    return world, model.manager


def turned(world, count=1):
    """Position and velocity of the joint after some steps."""
    world.step(count)
    return tuple(values["axle"] for values in world.model("bot").joints.state())


def test_a_wheel_keeps_to_the_parameters_and_to_its_last_speed():
    """A wheel told 15 with max_velocity 5 turns at 5; stopped it goes on; a stop brakes it."""
    world, manager = controlled("velocity", 'effort="5" velocity="30"', **{
        "has_velocity_limits": True, "max_velocity": 5.0,
        "has_acceleration_limits": True, "max_acceleration": 10.0,
    })  # fmt: skip
    manager.command("c", [15.0])
    assert turned(world, 200)[1] == pytest.approx(2.0, abs=0.02)
    assert turned(world, 500)[1] == pytest.approx(5.0, abs=1e-6)
    assert not manager.hardware.limited, "many steps in one call again"
    manager.switch([], ["c"])
    assert turned(world, 1000)[1] == pytest.approx(5.0, abs=1e-6)
    manager.set_emergency_stop(True)
    assert turned(world, 100)[1] == pytest.approx(0.0, abs=1e-6)
    manager.set_emergency_stop(False)
    assert turned(world, 600)[1] == pytest.approx(5.0, abs=1e-6)
    world.close()


def test_a_position_slows_down_before_its_soft_limit():
    safety = (
        '<safety_controller soft_lower_limit="-1" soft_upper_limit="1" k_position="5" '
        'k_velocity="20"/>'
    )
    limit = 'lower="-2" upper="2" effort="50" velocity="2"'
    world, manager = controlled("position", limit, safety)
    manager.command("c", [1.8])
    assert turned(world, 300)[0] == pytest.approx(0.6, abs=0.01), "2 rad/s"
    end = 1.0 - 0.4 * math.exp(-5.0 * 0.2)
    assert turned(world, 200)[0] == pytest.approx(end, abs=0.01)
    assert turned(world, 3000)[0] == pytest.approx(1.0, abs=1e-3)
    world.close()


def test_a_position_that_a_pid_follows_moves_at_the_limit_of_speed():
    """The handles of positions bound the set point of DefaultRobotHWSim's PID, too."""
    limit = 'lower="-2" upper="2" effort="50" velocity="0.5"'
    gains = PidGains(50.0, d=2.0)
    world, manager = controlled("position", limit, gains=gains)
    manager.command("c", [1.0])
    world.step(1000)
    assert manager.hardware.handles(["axle"])[0].gains_pid.target == pytest.approx(0.5, abs=1e-6)
    assert turned(world, 3000)[0] == pytest.approx(1.0, abs=1e-2)
    assert not manager.hardware.limited
    world.close()


def test_a_stop_leaves_the_command_that_the_limits_have_held():
    """enforceLimits() overwrites the command of its handle; so in Gazebo 11.1: told 4 rad at 0.5
    rad/s, stopped at 2.18 rad, it stays there."""
    limit = 'lower="-6.2" upper="6.2" effort="50" velocity="0.5"'
    world, manager = controlled("position", limit, gains=PidGains(50.0, d=2.0))
    manager.command("c", [4.0])
    world.step(1000)
    manager.switch([], ["c"])
    assert turned(world, 2000)[0] == pytest.approx(0.5, abs=1e-2)
    world.close()


@pytest.mark.parametrize(
    "start, end, lower, upper, expected",
    [
        (0.0, 1.0, -2.0, 2.0, 1.0),
        (3.0, -3.0, -3.1, 3.1, -6.0),  # not across half a rotation
        (0.0, 4.0, -6.0, 6.0, 4.0 - 2.0 * math.pi),  # wrong: the other way
        (0.0, 3.0, -6.28, 6.28, 3.0 - 2.0 * math.pi),  # wrong again
        (3.5, 4.0, -5.0, 5.0, 0.5),
    ],
)
def test_the_way_of_a_revolute_joint_that_a_pid_leads(start, end, lower, upper, expected):
    """angles::shortest_angular_distance_with_limits; limits beyond pi are those modulo a turn."""
    error = law.position_error(start, end, lower, upper, law.WAY_WITHIN)
    assert error == pytest.approx(expected)

"""Finite numbers beyond all bounds: refused where they come in, harmless where they come from."""

import math

import pytest
from bullet_sim.controllers.drive import Odometry
from bullet_sim.controllers.limits import UNLIMITED_SPEED
from bullet_sim.controllers.manager import Manager
from bullet_sim.controllers.pid import Pid, PidGains
from bullet_sim.description.model import ModelDescription
from bullet_sim.errors import CommandError, ModelError, WorldError
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from test_controllers import EFFORT_VELOCITY, VELOCITY, Recorded
from test_drive_controllers import ackermann, diff
from test_world import box
from urdf_texts import joint, link, robot

pytestmark = pytest.mark.usefixtures("sketches")

CRANK = robot(link("base"), link("arm"), joint("j", "continuous", "base", "arm", axis="1 0 0"))
WORLD = {"gravity": (0.0, 0.0, 0.0)}


# poses and velocities -----------------------------------------------------------------------------
@pytest.mark.parametrize(
    "pose, value",
    [
        (Pose((1e40, 0.0, 0.0)), "1e.40"),
        (Pose((math.nan, 0.0, 0.0)), "nan"),
        (Pose((0.0, math.inf, 0.0)), "inf"),
        (Pose(orientation=(0.0, 0.0, 0.0, 0.0)), "0.0, 0.0, 0.0, 0.0"),
        (Pose(orientation=(math.nan, 0, 0, 1)), "nan"),
        (Pose((0.0, -1.1e9, 0.0)), "-1100000000"),
        (Pose(orientation=(0.0, 0.0, 0.0, 1e200)), "1e.200"),
        (Pose(orientation=(0.0, 0.0, 2e6, 0.0)), "2000000"),
        (Pose(orientation=(0.0, 9e-7, 0.0, 0.0)), "9e-07"),
    ],
)
def test_poses_out_of_bounds_are_refused(world, pose, value):
    model = world.spawn(box())
    model.set_state(Pose((1.0, 2.0, 3.0)))
    for call in (lambda: world.spawn(box("other"), pose), lambda: model.set_state(pose)):
        with pytest.raises(ModelError, match=f"{value}.*must be finite.*1e.09 m.*1e-06 to 1e.06"):
            call()
    assert list(world.models) == ["box"] and model.pose.position == pytest.approx((1, 2, 3))


@pytest.mark.parametrize(
    "pose, turn",
    [
        (Pose((1e9, -1e9, 1e9)), (0, 0, 0, 1)),
        (Pose(orientation=(0.0, 0.0, 9e5, 0.0)), (0, 0, 1, 0)),
        (Pose(orientation=(0.0, 2e-6, 0.0, 0.0)), (0, 1, 0, 0)),
    ],
)
def test_poses_at_the_bounds_are_taken(world, pose, turn):
    model = world.spawn(box(), pose)
    for _ in range(2):
        assert model.pose.position == pytest.approx(pose.position)
        assert model.pose.orientation == pytest.approx(turn)
        model.set_state(pose)


@pytest.mark.parametrize(
    "linear, angular",
    [((1e300, 0, 0), (0, 0, 0)), ((0, 0, 0), (0, -1.1e6, 0)), ((0, math.nan, 0), (0, 0, 0))],
)
def test_velocities_out_of_bounds_are_refused(world, linear, angular):
    model = world.spawn(box())
    model.set_state(Pose(), (1, 0, 0))
    with pytest.raises(ModelError, match="velocity for model 'box' is .*must be finite.*1e.06"):
        model.set_state(Pose((5.0, 0.0, 0.0)), linear, angular)
    assert model.pose.position == (0, 0, 0)
    assert model.link_state("link")[1] == pytest.approx((1, 0, 0))


def test_joint_positions_out_of_bounds_are_refused(world):
    model = world.spawn_urdf("r", CRANK, Pose(), str)
    model.joints.set_positions({"j": 0.5})
    for value in (1e300, -1.1e9, math.inf):
        with pytest.raises(ModelError, match="joint 'j' is .*must be finite.*1e.09"):
            model.joints.set_positions({"j": value})
    assert model.joints.positions_of(["j"]) == (0.5,)


# commands -----------------------------------------------------------------------------------------
@pytest.mark.parametrize("value", [1.1e9, -1e308, math.nan, math.inf])
def test_commands_out_of_bounds_are_refused_and_the_last_stays(value):
    joints = Recorded()
    manager = Manager(joints)
    manager.load("speed", {"type": VELOCITY, "joint": "left"})
    manager.switch(["speed"], [])
    manager.command("speed", [3.0])
    with pytest.raises(CommandError, match="'speed' is .*must be a finite number.*1e.09"):
        manager.command("speed", [value])
    assert joints.calls[-1] == ("velocity", ("left",), (3.0,))
    manager.command("speed", [1e9])
    assert joints.calls[-1] == ("velocity", ("left",), (UNLIMITED_SPEED,))


@pytest.mark.parametrize(
    "make, command",
    [(ackermann, (1e308, 1.57)), (diff, (0.0, 1.7e308)), (diff, (-1.7e308, 1.7e308))],
)
def test_a_base_in_open_loop_goes_on_after_an_impossible_command(make, command):
    base = make(open_loop=True)
    before = base.run(0.05, (0.5, 0.0))
    with pytest.raises(CommandError):
        base.manager.command("base", command)
    assert base.run(0.05).linear == pytest.approx(0.5) and before.heading == 0.0


@pytest.mark.parametrize("command", [(1e9, 1.57), (1e9, math.pi / 2), (1e9, 1e9), (-1e9, 1e9)])
@pytest.mark.parametrize("make", [ackermann, diff])
def test_the_greatest_commands_stop_no_loop(make, command):
    odometry = make(open_loop=True).run(0.3, command)
    assert all(
        map(
            math.isfinite,
            (odometry.x, odometry.y, odometry.heading, odometry.linear, odometry.angular),
        )
    )


@pytest.mark.parametrize(
    "arc", [(math.inf, 0.0), (0.0, -math.inf), (math.nan, 0.0), (1e308, 1e308), (0.0, 1.7e308)]
)
def test_arcs_that_nothing_can_travel_do_not_count(arc):
    odometry = Odometry(window=2)
    odometry.move(0.5, 0.0, 1.0)
    odometry.move(*arc, 2.0)
    assert (odometry.x, odometry.y, odometry.heading, odometry.linear) == (0.5, 0.0, 0.0, 0.5)
    odometry.move(0.5, 0.0, 3.0)
    assert (odometry.x, odometry.linear) == (1.0, 0.5)


# efforts ------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "gains",
    [PidGains(math.nan), PidGains(1.0, d=math.nan), PidGains(1.0, math.nan, 0.0, -1.0, 1.0)],
)
def test_gains_that_are_no_numbers_give_nothing(gains):
    pid = Pid(gains)
    assert pid.update(1.0, 0.001) == 0.0 and pid.output == 0.0
    pid.gains = PidGains(2.0)
    assert pid.update(1.0, 0.001) == 2.0


def test_opposite_infinite_parts_give_nothing():
    pid = Pid(PidGains(1e308, d=-1e308))
    assert pid.update(10.0, 0.001, 10.0) == 0.0


@pytest.mark.parametrize("effort", [math.nan, math.inf, -math.inf])
def test_an_effort_that_is_no_number_does_not_reach_the_joint(effort):
    joints = Recorded()
    manager = Manager(joints)
    for handle, value in zip(manager.hardware.handles(("left", "right")), (effort, 3.0)):
        handle.set_effort(value)
    manager.update(0.001)
    assert joints.calls[-1] == ("effort", {"left": 0.0, "right": 3.0})


# time ---------------------------------------------------------------------------------------------
def test_steps_out_of_bounds_are_refused(world):
    for step in (1e-12, 9.9e-7, 0.0, -1.0, 1.0, math.nan):
        with pytest.raises(WorldError, match="time_step is .*from 1e-06 to below 1"):
            world.set_time_step(step)
    assert world.time_step == 0.001
    world.set_time_step(1e-6)
    assert world.time_step == 1e-6


@pytest.mark.parametrize("step", ["1e-12", "9.9e-7"])
def test_a_world_file_with_too_short_a_step_gets_the_usual_one(step):
    text = (
        '<sdf version="1.6"><world name="w"><physics><max_step_size>{}</max_step_size>'
        "</physics></world></sdf>"
    )
    described = sdf.parse_world(text.format(step), str, "my.world")
    assert described.step == 0.001 and len(described.warnings) == 1
    assert f"max_step_size> is {float(step)}" in described.warnings[0]
    assert sdf.parse_world(text.format("1e-6"), str, "my.world").step == 1e-6


@pytest.mark.parametrize(
    "wanted, step, period",
    [
        (0.0, 0.001, 0.001),
        (0.0002, 0.001, 0.001),
        (0.001, 0.001, 0.001),
        (0.004, 0.001, 0.004),
        (0.0024, 0.001, 0.003),
        (0.0026, 0.001, 0.003),
        (0.01, 0.004, 0.012),
        (0.009, 0.003, 0.009),
    ],
)
def test_the_control_period_is_as_announced(wanted, step, period):
    manager = Manager(Recorded(), ModelDescription("bot", control_period=wanted))
    manager.load("arm", {"type": EFFORT_VELOCITY, "joint": "left", "pid": {"p": 1.0}})
    manager.switch(["arm"], [])
    times = set()
    for _ in range(round(12 * period / step)):
        manager.update(step)
        times.add(round(manager.get("arm").sample.time, 9))
    assert manager.control_period(step) == pytest.approx(period)
    assert sorted(times) == pytest.approx([k * period for k in range(12)])

"""Controllers whose work the solver does in each of several steps: the same bits as from Python."""

import math

import pytest
from bullet_sim.controllers.manager import Manager
from bullet_sim.controllers.pid import PidGains
from bullet_sim.pose import Pose
from bullet_sim.world import World
from fake_joints import COVARIANCES
from urdf_texts import link

LINK = link("{0}", 1, (0.02, 0.03, 0.01))
JOINT = (
    '<joint name="{0}" type="{1}"><origin xyz="0 {4} 0"/><parent link="world"/><child link="l{0}"/>'
    '<axis xyz="{2}"/><limit {3}/></joint>'
)
JOINTS = {
    "wheel": ("continuous", "0 1 0", 'effort="3" velocity="9"'),
    "turret": ("continuous", "0 0 1", 'effort="2" velocity="5"'),
    "hinge": ("revolute", "1 0 0", 'lower="-2.8" upper="3" effort="0.8" velocity="4"'),
    "slider": ("prismatic", "1 0 0", 'lower="-0.2" upper="0.4" effort="9" velocity="2"'),
    "pusher": ("prismatic", "0 0 1", 'lower="-9" upper="9" effort="20" velocity="0.5"'),
    "geared": ("continuous", "0 1 0", 'effort="1" velocity="6"'),
    "lift": ("prismatic", "0 0 1", 'lower="0" upper="1" effort="15" velocity="3"'),
}
TRANSMISSION = (
    '<transmission name="t{0}"><type>transmission_interface/SimpleTransmission</type>'
    '<joint name="{0}"><hardwareInterface>hardware_interface/{1}JointInterface'
    '</hardwareInterface></joint><actuator name="m{0}"/></transmission>'
)
KINDS = {"geared": "Velocity", "lift": "Position"}
CONTROLLERS = {
    "wheel": ("effort_controllers/JointVelocityController", dict(p=0.4, i=2.0, i_clamp=0.3)),
    "turret": ("effort_controllers/JointPositionController", dict(p=3.0, d=0.05)),
    "hinge": (
        "effort_controllers/JointPositionController",
        dict(p=4.0, i=9.0, d=0.1, i_clamp_max=0.1, i_clamp_min=-0.2, antiwindup=True),
    ),
    "slider": ("effort_controllers/JointPositionController", dict(p=90.0, d=9.0)),
    "pusher": ("effort_controllers/JointEffortController", None),
    "geared": ("velocity_controllers/JointVelocityController", None),
    "lift": ("position_controllers/JointPositionController", None),
}
COMMANDS = (
    dict(wheel=6.0, turret=2.0, hinge=-2.7, slider=0.3, pusher=12.0, geared=4.0, lift=0.5),
    dict(wheel=-40.0, turret=math.pi, hinge=2.9, slider=-5.0, pusher=-19.0, geared=-50.0, lift=2.0),
    dict(wheel=1.0, turret=-9.0, hinge=0.0, slider=0.1, pusher=9.8, geared=0.0, lift=0.1),
)


def robot():
    parts = ['<robot name="bot"><link name="world"/>']
    for place, (name, facts) in enumerate(JOINTS.items()):
        kind, axis, limits = facts
        parts += [LINK.format("l" + name), JOINT.format(name, kind, axis, limits, place)]
        parts.append(TRANSMISSION.format(name, KINDS.get(name, "Effort")))
    parts.append('<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo></robot>')
    return "".join(parts)


def world_with_controllers():
    world = World(solver="ode")
    manager = world.spawn_urdf("bot", robot(), Pose((0.0, 0.0, 2.0)), str).manager
    manager.hardware.set_gains("geared", PidGains(0.3, 0.5, 0.001, -0.2, 0.2))
    manager.hardware.set_gains("lift", PidGains(200.0, 0.0, 20.0))
    manager.hardware.restart()
    for name, (kind, gains) in CONTROLLERS.items():
        config = {"type": kind, "joint": name, **({} if gains is None else {"pid": gains})}
        manager.load(name, config)
    manager.switch(list(CONTROLLERS), [])
    return world, manager


def everything(world, manager):
    """All that tells one run from another, as text, which has the bits of floats."""
    engine, hardware = world.engine, manager.hardware
    pids = [pid for name in CONTROLLERS for pid in getattr(manager.get(name), "pids", ())]
    pids += [hardware.handles(["geared"])[0].gains_pid, hardware.handles(["lift"])[0].gains_pid]
    states = [
        (pid.error, pid.error_rate, pid.integral, pid.terms, pid.output, pid.last_error)
        for pid in pids
    ]
    samples = [getattr(manager.get(name), "sample", None) for name in CONTROLLERS]
    handles = [(joint.position, joint.velocity) for joint in hardware.handles(JOINTS)]
    columns = hardware.joints.columns(range(len(JOINTS)))
    return [
        *map(repr, (world.time, manager.time, states, samples, handles, columns)),
        repr([(joint.name, joint.effort) for joint in hardware.acting]),
        repr((engine.rows.tolist(), engine.joint_rows.tolist())),
    ]


def drive(world, manager, batches):
    """States after each of the commands, which are made in batches."""
    found = []
    for number, command in enumerate(COMMANDS):
        for name, value in command.items():
            manager.command(name, [value])
        for batch in batches[number % len(batches)]:
            world.step(batch)
        found.append(everything(world, manager))
    return found


def never(self, period):
    """In place of Manager._steps_until_update: Python updates the controllers before each step."""
    return 0


def ways(monkeypatch):
    """Whether Python updates the controllers before each step: once it does, once batches do."""
    with monkeypatch.context() as patch:
        patch.setattr(Manager, "_steps_until_update", never)
        yield True
    yield False


def note_batches(monkeypatch):
    """List that gets the number of steps of each call in which the engine computes PIDs."""
    batches, finish = [], Manager.finish_steps

    def noted(self, count, period, recorded):
        batches.extend([count] * self.computes)
        finish(self, count, period, recorded)

    monkeypatch.setattr(Manager, "finish_steps", noted)
    return batches


def test_pids_in_the_solver_are_those_of_python(monkeypatch):
    """Limits, saturation, antiwindup, half rotations, gains of gazebo_ros_control, efforts."""
    with monkeypatch.context() as patch:
        patch.setattr(Manager, "_steps_until_update", never)
        expected = drive(*world_with_controllers(), [[700]])
    world, manager = world_with_controllers()
    batches = note_batches(monkeypatch)
    assert drive(world, manager, [[1, 699], [13, 1, 686], [350, 350]]) == expected
    # the first step is Python's, and those in which the lift's set point moves at 3 m/s: by 0.5 m,
    # by 0.5 m, by 0.9 m, and one more for each until it stays
    whole = 2 * ([64] * 8 + [20]) + [49] + [64] * 5 + [30]
    assert batches == whole


def test_a_saved_state_goes_on_with_the_same_bits():
    world, manager = world_with_controllers()
    drive(world, manager, [[300]])
    state = world.save_state()
    first = drive(world, manager, [[200]])
    world.restore_state(state)
    assert drive(world, manager, [[20] * 10]) == first


def stop(manager):
    """An emergency stop."""
    manager.set_emergency_stop(True)


def regulate_by_velocities(manager):
    """A controller that computes velocities by a PID."""
    kind = "velocity_controllers/JointPositionController"
    manager.load("more", {"type": kind, "joint": "geared", "pid": {"p": 1.0}})
    manager.switch(["more"], ["geared"])


@pytest.mark.parametrize("change", [stop, regulate_by_velocities])
def test_python_computes_what_is_more_than_pids(monkeypatch, change):
    world, manager = world_with_controllers()
    world.step(10)
    change(manager)
    batches = note_batches(monkeypatch)
    world.step(10)
    assert world.step_count == 20 and not batches


@pytest.mark.parametrize("target", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_gives_no_effort(monkeypatch, target):
    """In the solver as in Pid.update(); what was before is not forgotten."""
    found = []
    for _ in ways(monkeypatch):
        world, manager = world_with_controllers()
        drive(world, manager, [[50]])
        for name in ("wheel", "turret", "slider"):
            manager.get(name).pids[0].target = target
        world.step(20)
        assert (manager.get("wheel").pids[0].output, world.step_count) == (0.0, 170)
        found += [everything(world, manager), drive(world, manager, [[50]])]
    assert found[:2] == found[2:]


BASES = {
    "diff_drive_controller/DiffDriveController": dict(
        left_wheel="wheel",
        right_wheel="geared",
        wheel_separation=0.5,
        wheel_radius=0.1,
        **COVARIANCES,
    ),
    "ackermann_steering_controller/AckermannSteeringController": dict(
        rear_wheel="wheel",
        front_steer="lift",
        wheel_separation_h=0.5,
        wheel_radius=0.1,
        **COVARIANCES,
    ),
}
LIMITS = {"x": dict(has_velocity_limits=True, max_velocity=0.6, has_acceleration_limits=True,
                    max_acceleration=4.0, has_jerk_limits=True, max_jerk=400.0)}  # fmt: skip


@pytest.mark.parametrize("kind", BASES)
@pytest.mark.parametrize("more", [{}, {"linear": LIMITS}, {"open_loop": True}], ids=str)
def test_bases_have_the_same_odometry(monkeypatch, kind, more):
    """Also across the time-out of a command, in limits, and where its topic asks in between."""
    config = dict(BASES[kind], type=kind, cmd_vel_timeout=0.25, **more)
    robots = robot().replace("hardware_interface/Effort", "hardware_interface/Velocity")
    found = []
    for python in ways(monkeypatch):
        batches = note_batches(monkeypatch)
        world = World(solver="ode")
        manager = world.spawn_urdf("bot", robots, Pose((0.0, 0.0, 2.0)), str).manager
        manager.hardware.set_gains("geared", PidGains(0.3, 0.5, 0.001, -0.2, 0.2))
        manager.hardware.restart()
        manager.load("base", config)
        manager.switch(["base"], [])
        base, seen = manager.get("base"), []
        for command in ((0.4, 0.3), (0.4, 0.3), (-0.9, 0.1), (0.0, 0.0)):
            manager.command("base", command)
            for count in (20, 180, 300):
                world.step(count)
                manager.observe()
                state = {name: getattr(base, name) for name in base.STATE if name != "odometry"}
                state.update({name: getattr(base.odometry, name) for name in base.odometry.STATE})
                bits = world.engine.rows.tolist(), world.engine.joint_rows.tolist()
                seen.append(repr((sorted(state.items(), key=str), manager.time, bits)))
        found.append(seen)
        assert bool(batches) != python
    assert sum(batches) > 0.5 * world.step_count  # where limits act, Python does
    assert found[0] == found[1]

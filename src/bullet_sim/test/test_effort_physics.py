"""Effort controllers on known inertias in PyBullet: Newton's laws in closed form."""

import pytest
from bullet_sim.controllers.pid import parse_pid
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import link

LINK = link("{}", "{}", ("{}", "{}", "{}"))
INERTIA = 0.2  # [kg m^2] of the arm about its axis
MASS = 2.0  # [kg] of the slider
URDF = (
    '<robot name="bot"><link name="world"/><joint name="held" type="fixed"><parent link='
    '"world"/><child link="stand"/></joint>'
    + LINK.format("stand", 1e6, 1e6, 1e6, 1e6)
    + LINK.format("arm", 1, INERTIA, INERTIA, INERTIA)
    + LINK.format("box", MASS, 0.1, 0.1, 0.1)
    + '<joint name="arm" type="continuous"><parent link="stand"/><child link="arm"/>'
    '<axis xyz="0 0 1"/><limit effort="5" velocity="30"/></joint>'
    '<joint name="slider" type="prismatic"><parent link="stand"/><child link="box"/>'
    '<axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="4" velocity="1"/></joint>'
    '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo></robot>'
)


@pytest.fixture(name="world")
def _world():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.spawn_urdf("bot", URDF, Pose(), str)
    yield world
    world.close()


def run(world, steps):
    """Positions and velocities by joint name after some steps."""
    world.step(steps)
    return world.model("bot").joints.state()


def start(world, joint, kind, **config):
    """Manager with one running controller 'c' of a kind on a joint."""
    manager = world.model("bot").manager
    manager.load("c", {"type": f"effort_controllers/{kind}", "joint": joint, **config})
    manager.switch(["c"], [])
    return manager


@pytest.mark.parametrize("joint, inertia, effort", [("arm", INERTIA, 0.3), ("slider", MASS, -1.5)])
def test_effort_gives_acceleration(world, joint, inertia, effort):
    start(world, joint, "JointEffortController").command("c", [effort])
    positions, velocities = run(world, 400)
    assert velocities[joint] == pytest.approx(effort / inertia * 0.4, rel=1e-3)
    assert positions[joint] == pytest.approx(effort / inertia * 0.4**2 / 2, rel=5e-3)
    names, efforts = world.model("bot").joints.names, world.model("bot").joints.arrays()[2]
    assert efforts[names.index(joint)] == pytest.approx(effort)


def test_a_group_pushes_all_its_joints_at_once(world):
    manager = world.model("bot").manager
    manager.load(
        "g", {"type": "effort_controllers/JointGroupEffortController", "joints": ["slider", "arm"]}
    )
    manager.switch(["g"], [])
    manager.command("g", [1.0, -0.5])
    _, velocities = run(world, 300)
    assert velocities["slider"] == pytest.approx(1.0 / MASS * 0.3, rel=1e-3)
    assert velocities["arm"] == pytest.approx(-0.5 / INERTIA * 0.3, rel=1e-3)


def test_the_effort_stays_after_a_stop(world):
    """JointEffortController has no stopping(), and DefaultRobotHWSim writes in every step."""
    manager = start(world, "arm", "JointEffortController")
    manager.command("c", [1.0])
    speed = run(world, 100)[1]["arm"]
    manager.switch([], ["c"])
    assert run(world, 100)[1]["arm"] == pytest.approx(2.0 * speed, rel=1e-3)
    manager.switch(["c"], [])  # it starts with 0
    assert run(world, 100)[1]["arm"] == pytest.approx(2.0 * speed, rel=1e-3)


def test_position_beyond_the_stop_ends_at_the_stop(world):
    manager = start(world, "slider", "JointPositionController", pid={"p": 40.0, "d": 18.0})
    manager.command("c", [7.0])
    assert run(world, 4000)[0]["slider"] == pytest.approx(1.0, abs=2e-3)
    assert manager.get("c").sample.set_point == 1.0


def hanging(solver, interface):
    """World in which the slider is pulled along its axis; its <transmission> has an interface."""
    world = World(gravity=(-5.0, 0.0, 0.0), solver=solver)
    transmission = (
        '<transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint '
        'name="slider"><hardwareInterface>hardware_interface/'
        f'{interface}JointInterface</hardwareInterface></joint><actuator name="m"/></transmission>'
        "</robot>"
    )
    stronger = URDF.replace('effort="4"', 'effort="400"').replace("</robot>", transmission)
    world.spawn_urdf("bot", stronger, Pose(), str)
    return world


@pytest.mark.parametrize("solver", ["bullet", "ode"])
@pytest.mark.parametrize(
    "interface, kind, command, ends",
    [("Position", "position_controllers/JointPositionController", 0.3, 0.3),
     ("Velocity", "velocity_controllers/JointVelocityController", 0.5, 0.5)],
)  # fmt: skip
def test_a_joint_is_held_before_a_controller_and_keeps_its_command_after_it(
    solver, interface, kind, command, ends
):
    world = hanging(solver, interface)
    for _ in range(2):
        assert run(world, 500)[0]["slider"] == pytest.approx(0.0, abs=2e-3)
        manager = world.model("bot").manager
        if not manager.list():
            manager.load("c", {"type": kind, "joint": "slider"})
        manager.switch(["c"], [])
        manager.command("c", [command])
        world.step(500)
        manager.switch([], ["c"])
        positions, velocities = run(world, 500)
        assert positions["slider"] == pytest.approx(ends, abs=5e-3)
        expected = command if interface == "Velocity" else 0.0
        assert velocities["slider"] == pytest.approx(expected, abs=5e-3)
        world.reset()  # then the last command is forgotten
    world.close()


@pytest.mark.parametrize("solver", ["bullet", "ode"])
def test_without_a_controller_a_joint_with_an_effort_interface_moves_freely(solver):
    world = hanging(solver, "Effort")
    assert run(world, 200)[0]["slider"] == pytest.approx(-5.0 * 0.2**2 / 2, rel=0.02)
    world.close()


@pytest.mark.parametrize("solver", ["bullet", "ode"])
def test_without_a_controller_gains_hold_a_joint_as_well_as_they_can(solver):
    world = hanging(solver, "Position")
    hardware = world.model("bot").manager.hardware
    hardware.set_gains("slider", parse_pid({"p": 100.0, "d": 40.0}, "gains"))
    hardware.restart()
    assert run(world, 3000)[0]["slider"] == pytest.approx(-5.0 * MASS / 100.0, abs=2e-3)
    world.close()


@pytest.mark.parametrize("solver", ["bullet", "ode"])
@pytest.mark.parametrize(
    "interface, controller, command",
    [
        ("Position", {"type": "position_controllers/JointPositionController"}, 0.3),
        ("Velocity", {"type": "velocity_controllers/JointVelocityController"}, 0.5),
        ("Effort", {"type": "effort_controllers/JointPositionController",
                    "pid": {"p": 200.0, "d": 60.0}}, 0.3),
    ],
)  # fmt: skip
def test_an_emergency_stop_stops_what_is_commanded_until_it_is_over(
    solver, interface, controller, command
):
    world = hanging(solver, interface)
    manager = world.model("bot").manager
    manager.load("c", {"joint": "slider", **controller})
    manager.switch(["c"], [])
    manager.command("c", [command])
    positions, velocities = run(world, 500)
    before, speed = positions["slider"], velocities["slider"]
    manager.set_emergency_stop(True)
    state = world.save_state()
    for _ in range(2):
        manager.command("c", [-command])
        after = run(world, 100)[0]["slider"]
        if interface == "Effort":  # falls
            assert after == pytest.approx(before + speed * 0.1 - 5.0 * 0.1**2 / 2, abs=2e-3)
        else:
            assert after == pytest.approx(before, abs=5e-3)
        world.restore_state(state)
    assert manager.is_running("c")
    here = run(world, 1)[0]["slider"]
    manager.set_emergency_stop(False)  # the controller starts anew: it holds the joint or brakes
    held = run(world, 200)[0]["slider"]
    assert held == pytest.approx(here, abs=0.06 if interface == "Effort" else 5e-3)
    manager.command("c", [command])
    assert run(world, 1500)[0]["slider"] == pytest.approx(
        {"Position": 0.3, "Velocity": 1.0, "Effort": 0.3 - 5.0 * MASS / 200.0}[interface], abs=0.02
    )
    world.close()

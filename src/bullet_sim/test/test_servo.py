"""Efforts of PIDs: the closed form of spring and damper, joints that are held, loads."""

import math

import numpy as np
import pytest
from bullet_sim.pose import Pose
from bullet_sim.world import World
from contact_scenes import nowhere
from scipy.linalg import expm
from urdf_texts import CONTROL, joint, link, robot

STEP = 0.3  # of the set point [rad, rad/s]


def rotor(inertia, kind="revolute", friction=0.0, effort=1e6):
    """URDF of a disc on a body that the world holds."""
    limit = f'<limit lower="-3" upper="3" effort="{effort}" velocity="1000"/>'
    more = f'{limit}<dynamics friction="{friction}"/>'
    return robot(
        '<link name="world"/>', link("base", 1, 1), joint("held", "fixed", "world", "base"),
        link("disc", 1, inertia), joint("axle", kind, "base", "disc", axis="0 0 1", more=more),
        CONTROL,
    )  # fmt: skip


@pytest.fixture(name="solver", params=["ode", "bullet"])
def _solver(request):
    return request.param


def controlled(urdf, gains, goal="Position", joint="axle", step=0.001, solver="ode"):
    """A World with a robot whose joint has a running effort controller, and its Manager."""
    world = World(step, solver=solver)
    manager = world.spawn_urdf("bot", urdf, Pose(), nowhere).manager
    config = {"type": f"effort_controllers/Joint{goal}Controller", "joint": joint, "pid": gains}
    manager.load("c", config)
    manager.switch(["c"], [])
    return world, manager


def closed_form(p, d, inertia, times):
    """Positions of a joint at rest at 0 under tau = p (STEP - q) - d v from time 0."""
    matrix = np.array([[0.0, 1.0], [-p / inertia, -d / inertia]])
    step = expm(matrix * (times[1] - times[0]))
    state, found = np.array([-STEP, 0.0]), []
    for _ in times:
        found.append(state[0] + STEP)
        state = step @ state
    return np.array(found)


@pytest.mark.parametrize(
    "inertia, p, d",
    [(1e-4, 0.01, 1e-3), (1e-2, 1.0, 0.2), (1.0, 100.0, 10.0), (1.0, 1000.0, 20.0)],
)
def test_step_response(solver, inertia, p, d, step=0.001):
    world, manager = controlled(rotor(inertia), {"p": p, "d": d}, step=step, solver=solver)
    manager.command("c", [STEP])
    slowest = max(d / p, 2.0 * inertia / d, math.sqrt(inertia / p))
    count = min(4000, max(20, round(5 * slowest / step)))
    times, found = np.arange(count + 1) * step, [0.0]
    for _ in range(count):
        world.step(1)
        found.append(world.model("bot").joints.state()[0]["axle"])
    world.close()
    expected = closed_form(p, d, inertia, times)
    assert np.abs(np.array(found) - expected).max() < 0.05 * STEP


@pytest.mark.parametrize("inertia, p", [(1e-4, 0.003), (1e-3, 0.04), (1.0, 10.0)])
def test_step_response_of_a_velocity(solver, inertia, p, step=0.001):
    urdf = rotor(inertia, "continuous")
    world, manager = controlled(urdf, {"p": p}, "Velocity", step=step, solver=solver)
    manager.command("c", [STEP])
    count = min(2000, max(10, round(5 * inertia / p / step)))
    found = []
    for _ in range(count):
        world.step(1)
        found.append(world.model("bot").joints.state()[1]["axle"])
    world.close()
    times = np.arange(1, count + 1) * step
    assert np.abs(np.array(found) - STEP * -np.expm1(-p / inertia * times)).max() < 0.05 * STEP


def test_a_joint_that_is_held_is_pushed_with_the_whole_spring(solver):
    """Friction of the joint holds it up to p e = 0.2 N m; beyond, it creeps to that distance."""
    for p, rest in ((0.5, 0.0), (1.0, STEP - 0.2)):
        urdf, gains = rotor(1e-3, friction=0.2), {"p": p, "d": 0.08}
        world, manager = controlled(urdf, gains, solver=solver)
        manager.command("c", [STEP])
        world.step(1500)
        position = world.model("bot").joints.state()[0]["axle"]
        world.close()
        assert position == pytest.approx(rest, abs=0.01)


def test_the_effort_limit_of_the_urdf_holds(solver):
    """0.001 N m on 1e-3 kg m^2 from rest: 0.5 rad/s^2 t^2 at first."""
    world, manager = controlled(rotor(1e-3, effort=0.001), {"p": 100.0, "d": 1.0}, solver=solver)
    manager.command("c", [STEP])
    world.step(400)
    position = world.model("bot").joints.state()[0]["axle"]
    world.close()
    assert position == pytest.approx(0.5 * 1.0 * 0.4**2, rel=0.02)


def test_a_weight_hangs_where_the_spring_carries_it(solver):
    """A slider of 1 kg under gravity: it rests g / p below its set point, without chatter."""
    urdf = rotor(1.0, "prismatic").replace("axle", "lift")
    world, manager = controlled(urdf, {"p": 10000.0, "d": 500.0}, joint="lift", solver=solver)
    manager.command("c", [STEP])
    world.step(1500)
    found = []
    for _ in range(100):
        world.step(1)
        found.append(world.model("bot").joints.state()[0]["lift"])
    world.close()
    assert np.mean(found) == pytest.approx(STEP - 9.81 / 10000.0, abs=5e-5)
    assert np.ptp(found) < 1e-4


@pytest.mark.parametrize("i", [0.0, 20000.0])
def test_the_integral_term_takes_the_rest(solver, i):
    urdf = rotor(1.0, "prismatic").replace("axle", "lift")
    gains = {"p": 3000.0, "d": 500.0, "i": i, "i_clamp": 20.0, "antiwindup": True}
    world, manager = controlled(urdf, gains, joint="lift", solver=solver)
    manager.command("c", [STEP])
    world.step(4000)
    position = world.model("bot").joints.state()[0]["lift"]
    world.close()
    assert position == pytest.approx(STEP - (0.0 if i else 9.81 / 3000.0), abs=1e-4)

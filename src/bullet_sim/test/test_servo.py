"""PID efforts at any gain: the closed form of spring and damper, joints that are held, loads."""

import math

import numpy as np
import pytest
from bullet_sim.controllers.pid import PidGains, is_stiff, oscillator
from bullet_sim.pose import Pose
from bullet_sim.world import World
from contact_scenes import ground, nowhere
from scipy.linalg import expm

STEP = 0.3  # of the set point [rad, rad/s]


def rotor(inertia, kind="revolute", friction=0.0, effort=0.0):
    """URDF of a disc on a body that the world holds."""
    return (
        '<robot name="bot"><link name="world"/><link name="base"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint '
        'name="held" type="fixed"><parent link="world"/><child link="base"/></joint><link '
        'name="disc"><inertial><mass value="1"/><inertia '
        f'ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial>'
        f'</link><joint name="axle" type="{kind}"><parent link="base"/><child link="disc"/>'
        f'<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="{effort}" velocity="0"/>'
        f'<dynamics friction="{friction}"/></joint>'
        '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo></robot>'
    )


def controlled(urdf, gains, goal="Position", joint="axle", step=0.001, pose=None):
    """A World with a robot whose joint has a running effort controller, and its Manager."""
    world = World(step, solver="bullet")
    manager = world.spawn_urdf("bot", urdf, pose or Pose(), nowhere).manager
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


@pytest.mark.parametrize("step", [0.001, 0.004])
@pytest.mark.parametrize(
    "inertia, p, d",
    [
        (1e-6, 1.0, 0.01),  # the hinge of the most copied car
        (1e-6, 1.0, 1e-4),
        (1e-6, 0.01, 1e-4),
        (1e-5, 10.0, 0.05),
        (1e-4, 1.0, 0.01),
        (1e-4, 100.0, 1.0),
        (1e-4, 0.05, 1e-3),
        (1e-3, 10.0, 0.2),
        (1e-2, 100.0, 1.0),
        (1e-2, 1.0, 0.2),
        (1.0, 100.0, 10.0),
        (1.0, 1000.0, 20.0),
        (1.0, 20000.0, 2000.0),
    ],
)
def test_step_response(inertia, p, d, step):
    world, manager = controlled(rotor(inertia), {"p": p, "d": d}, step=step)
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


@pytest.mark.parametrize("step", [0.001, 0.004])
@pytest.mark.parametrize("inertia, p", [(1e-6, 0.01), (1e-5, 5.0), (1e-3, 0.1), (1.0, 10.0)])
def test_step_response_of_a_velocity(inertia, p, step):
    world, manager = controlled(rotor(inertia, "continuous"), {"p": p}, "Velocity", step=step)
    manager.command("c", [STEP])
    count = min(2000, max(10, round(5 * inertia / p / step)))
    found = []
    for _ in range(count):
        world.step(1)
        found.append(world.model("bot").joints.state()[1]["axle"])
    world.close()
    times = np.arange(1, count + 1) * step
    assert np.abs(np.array(found) - STEP * -np.expm1(-p / inertia * times)).max() < 0.05 * STEP


@pytest.mark.parametrize(
    "goal, gains, inertia, stiff",
    [
        ("position", PidGains(1.0, d=0.01), 1e-6, True),
        ("position", PidGains(1.0, d=0.01), 1.0, False),
        ("position", PidGains(4000.0), 1.0, True),
        ("position", PidGains(-1.0, d=0.1), 1e-6, False),
        ("velocity", PidGains(1.0), 1e-3, True),
        ("velocity", PidGains(0.01), 1e-3, False),
        ("velocity", PidGains(-1.0), 1e-3, False),
    ],
)
def test_what_a_constant_torque_bears_stays_one(goal, gains, inertia, stiff):
    assert is_stiff(gains, goal, inertia, 0.001) == stiff


@pytest.mark.parametrize(
    "p, d, inertia, period",
    [
        (1.0, 0.01, 1e-6, 0.004),
        (100.0, 1.0, 1e-2, 0.004),
        (1.0, 0.0, 1e-2, 0.001),
        (0.0, 0.3, 1e-2, 0.001),
        (25.0, 10.0, 1.0, 0.01),  # critically damped
        (1e-9, 1e-9, 1.0, 0.001),
        (1e6, 1e5, 1e-6, 0.004),
    ],
)
def test_oscillator_is_the_matrix_exponential(p, d, inertia, period):
    phi, psi, phi_rate, psi_rate = oscillator(p, d, inertia, period)
    if d * period / inertia > 500:  # where the matrix exponential itself overflows
        assert phi == pytest.approx(inertia / d * math.exp(-p / d * period), rel=1e-3)
        return
    matrix = expm(period * np.array([[0, 1, 0], [-p / inertia, -d / inertia, 1], [0, 0, 0]]))
    expected = (matrix[0, 1], matrix[0, 2], matrix[1, 1], matrix[1, 2])
    assert (phi, psi, phi_rate, psi_rate) == pytest.approx(expected, rel=1e-6, abs=1e-15)


def test_a_joint_that_is_held_is_pushed_with_the_whole_spring():
    """Friction of the joint holds it up to p e = 0.2 N m; beyond, it creeps to that distance."""
    for p, rest in ((0.5, 0.0), (1.0, STEP - 0.2)):
        world, manager = controlled(rotor(1e-5, friction=0.2), {"p": p, "d": 0.01})
        manager.command("c", [STEP])
        world.step(1500)
        position = world.model("bot").joints.state()[0]["axle"]
        world.close()
        assert position == pytest.approx(rest, abs=0.01)


def test_the_effort_limit_of_the_urdf_holds():
    """0.001 N m on 1e-3 kg m^2 from rest: 0.5 rad/s^2 t^2 at first."""
    world, manager = controlled(rotor(1e-3, effort=0.001), {"p": 100.0, "d": 1.0})
    manager.command("c", [STEP])
    world.step(400)
    position = world.model("bot").joints.state()[0]["axle"]
    world.close()
    assert position == pytest.approx(0.5 * 1.0 * 0.4**2, rel=0.02)


def test_a_weight_hangs_where_the_spring_carries_it():
    """A slider of 1 kg under gravity: it rests g / p below its set point, without chatter."""
    urdf = rotor(1.0, "prismatic").replace("axle", "lift")
    world, manager = controlled(urdf, {"p": 10000.0, "d": 500.0}, joint="lift")
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
def test_the_integral_term_takes_the_rest(i):
    urdf = rotor(1.0, "prismatic").replace("axle", "lift")
    gains = {"p": 3000.0, "d": 500.0, "i": i, "i_clamp": 20.0, "antiwindup": True}
    world, manager = controlled(urdf, gains, joint="lift")
    manager.command("c", [STEP])
    world.step(4000)
    position = world.model("bot").joints.state()[0]["lift"]
    world.close()
    assert position == pytest.approx(STEP - (0.0 if i else 9.81 / 3000.0), abs=1e-4)


CAR_MASS, WHEEL_RADIUS = 4.0, 0.05  # [kg], [m]


def steered_car():
    """A car on four balls; the front ones hang on light steering hinges with a scrub radius."""
    text = (
        '<robot name="bot"><link name="base"><inertial>'
        f'<mass value="{CAR_MASS}"/><inertia ixx="0.05" iyy="0.05" izz="0.05" ixy="0" ixz="0" '
        'iyz="0"/></inertial></link><gazebo><plugin name="c" filename="libgazebo_ros_control.so"/>'
        "</gazebo>"
    )
    for name, x, y in (
        ("fl", 0.16, 0.1),
        ("fr", 0.16, -0.1),
        ("rl", -0.16, 0.1),
        ("rr", -0.16, -0.1),
    ):
        parent, at = "base", f"{x} {y} 0"
        if name[0] == "f":
            text += (
                f'<link name="{name}_hinge"><inertial><mass value="0.05"/><inertia ixx="1e-6" '
                'iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link><joint '
                f'name="{name}_steer" type="revolute"><parent link="base"/><child '
                f'link="{name}_hinge"/><origin xyz="{at}"/><axis xyz="0 0 1"/><limit lower="-1" '
                'upper="1" effort="10" velocity="100"/></joint>'
            )
            parent, at = f"{name}_hinge", "0 0.02 0" if y > 0 else "0 -0.02 0"
        text += (
            f'<link name="{name}"><inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" '
            'izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry><sphere '
            f'radius="{WHEEL_RADIUS}"/></geometry></collision></link><joint name="{name}_axle" '
            f'type="continuous"><parent link="{parent}"/><child link="{name}"/><origin xyz="{at}"/>'
            '<axis xyz="0 1 0"/></joint>'
        )
    return text + "</robot>"


def test_the_hinges_of_a_standing_car_get_where_they_are_sent():
    """p = 1, d = 0.01 on a hinge of 1e-6 kg m^2, cut to 0.41 of that once: 0.13 of 0.3 rad."""
    world = World(solver="bullet")
    world.spawn(ground(), Pose())
    manager = world.spawn_urdf("bot", steered_car(), Pose((0, 0, WHEEL_RADIUS)), nowhere).manager
    for side in ("fl", "fr"):
        manager.load(
            side,
            {
                "type": "effort_controllers/JointPositionController",
                "joint": f"{side}_steer",
                "pid": {"p": 1.0, "d": 0.01},
            },
        )
    manager.switch(["fl", "fr"], [])
    for side in ("fl", "fr"):
        manager.command(side, [STEP])
    world.step(1500)
    positions = world.model("bot").joints.state()[0]
    world.close()
    # balls have no scrub torque but what rolls them round the hinge: next to none
    for side in ("fl", "fr"):
        assert positions[f"{side}_steer"] == pytest.approx(STEP, abs=0.02)


@pytest.mark.parametrize("p", [0.02, 1.0, 50.0])
def test_a_driven_wheel_that_carries_a_car_accelerates_as_its_torque_says(p):
    """tau = p (v_d - v) on m + I / r^2, however light the wheel itself is."""
    world = World(solver="bullet")
    world.spawn(ground(), Pose())
    manager = world.spawn_urdf("bot", steered_car(), Pose((0, 0, WHEEL_RADIUS)), nowhere).manager
    for side in ("fl", "fr"):  # straight ahead
        manager.load(
            side,
            {
                "type": "effort_controllers/JointPositionController",
                "joint": f"{side}_steer",
                "pid": {"p": 10.0, "d": 0.1},
            },
        )
    for side in ("rl", "rr"):
        manager.load(
            side,
            {
                "type": "effort_controllers/JointVelocityController",
                "joint": f"{side}_axle",
                "pid": {"p": p},
            },
        )
    manager.switch(["fl", "fr", "rl", "rr"], [])
    world.step(200)
    goal = 10.0  # [rad/s]
    for side in ("rl", "rr"):
        manager.command(side, [goal])
    mass = CAR_MASS + 2 * 0.05 + 4 * 0.1
    inertia = (mass * WHEEL_RADIUS**2 + 4 * 1e-4) / 2  # as each driven axle feels it
    rate = min(p / inertia, 1e9)
    for _ in range(10):
        before = world.model("bot").joints.state()[1]["rl_axle"]
        world.step(10)
        now = world.model("bot").joints.state()[1]["rl_axle"]
        # between the exact exponential and the grip of the tyres
        most = 0.01 * 9.81 / WHEEL_RADIUS * 0.5  # mu m g / 2 on the driven axle
        wanted = (goal - before) * -math.expm1(-rate * 0.01)
        if wanted < 0.8 * most:
            assert now - before == pytest.approx(wanted, rel=0.1, abs=0.05)
    world.step(1500)
    speed = world.model("bot").joints.state()[1]["rl_axle"]
    world.close()
    assert speed == pytest.approx(goal, rel=0.02 if p > 0.1 else 0.2)

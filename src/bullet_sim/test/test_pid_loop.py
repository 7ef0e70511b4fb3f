"""Effort controllers in one piece: the bits of their parts, and two calls of the engine a step."""

import math
import random

import pytest
from bullet_sim.controllers.manager import Manager
from bullet_sim.controllers.pid import Pid, is_stiff, oscillator, parse_pid, position_error
from bullet_sim.description.model import Joint
from bullet_sim.engine import Engine
from bullet_sim.pose import Pose
from bullet_sim.world import World
from contact_scenes import nowhere
from fake_joints import FakeJoints

STEP = 0.001  # [s]
INERTIA = 1e-5  # [kg m^2, kg]
JOINTS = {
    "hinge": Joint("hinge", "revolute", "a", "b", lower=-2.0, upper=2.0),
    "wheel": Joint("wheel", "continuous", "a", "c"),
    "slide": Joint("slide", "prismatic", "a", "d", lower=-1.0, upper=1.0),
}
STIFF = {"p": 5.0, "d": 0.03}
SOFT = {"p": 1e-4, "d": 1e-5, "i": 1e-3, "i_clamp": 1e-3}
GAINS = [
    STIFF,
    {**STIFF, "i": 40.0, "i_clamp": 0.3},
    {**STIFF, "i": -40.0, "i_clamp_max": 0.3, "i_clamp_min": -0.1},
    {**STIFF, "i": 40.0, "i_clamp": 0.3, "antiwindup": True},
    SOFT,
    {"p": -5.0, "d": 0.03},
]


class OneJoint(FakeJoints):
    """One joint whose state the test sets; records what drives it."""

    def __init__(self, name):
        self.names, self.limits = (name,), {name: JOINTS[name]}
        super().__init__()
        self.position = self.velocity = 0.0
        self.driven = None

    def state(self):
        """Its position and velocity."""
        (name,) = self.names
        return {name: self.position}, {name: self.velocity}

    def effort_bounds(self, *_):
        """Any."""
        return -math.inf, math.inf

    def apply_efforts(self, efforts):
        """Record."""
        (self.driven,) = efforts.values()

    def track(self, targets, _handles):
        """Record."""
        (self.driven,) = targets.values()


class Parts:
    """What a controller commands: the terms of a PID without a joint, and the closed forms."""

    def __init__(self, joint, goal, gains):
        self.joint, self.goal, self.pid = joint, goal, Pid(gains, None, goal)
        self.mean, self.end = None, 0.0

    def update(self, target, position, velocity):
        """What drives the joint: an effort, or (velocity, effort)."""
        joint, pid, goal = self.joint, self.pid, self.goal
        if goal == "position":
            error = position_error(joint, position, target)
        else:
            error = target - velocity
        gains = pid.gains
        if not is_stiff(gains, goal, INERTIA, STEP):
            self.mean = None
            return pid.update(error, velocity, STEP)
        # a set point that rests, or moves as the joint does
        pid.update(error, velocity, STEP, 0.0 if goal == "position" else velocity)
        if not math.isfinite(error):
            self.mean = None
            return 0.0
        push = gains.p * error + pid.terms[1]
        if goal == "velocity":
            share = -math.expm1(-gains.p * STEP / (INERTIA + gains.d))
            return velocity + share * (error + pid.terms[1] / gains.p), abs(push)
        phi, psi, phi_rate, psi_rate = oscillator(gains.p, gains.d, INERTIA, STEP)
        now = velocity if self.mean is None else self.end + velocity - self.mean
        self.mean = (phi * now + psi * (push / INERTIA)) / STEP
        self.end = phi_rate * now + psi_rate * (push / INERTIA)
        return self.mean, abs(gains.p * error - gains.d * velocity + pid.terms[1])


@pytest.mark.parametrize("gains", GAINS, ids=str)
@pytest.mark.parametrize(
    "name, goal",
    [("hinge", "position"), ("wheel", "position"), ("slide", "position"), ("wheel", "velocity")],
)
def test_an_update_gives_the_bits_of_its_parts(name, goal, gains):
    """Over set points and states of all sizes, at rest, beyond stops, and a change of gains."""
    fake = OneJoint(name)
    manager = Manager(fake, inertias={name: INERTIA})
    kind = f"effort_controllers/Joint{goal.capitalize()}Controller"
    manager.load("c", {"type": kind, "joint": name, "pid": gains})
    manager.switch(["c"], [])
    parts = Parts(JOINTS[name], goal, parse_pid(gains, "c"))
    pid, rng = manager.get("c").pids[0], random.Random(7)
    for step in range(600):
        size = rng.choice((0.0, 1e-9, 0.3, 4.0, 50.0))
        fake.position, fake.velocity = (rng.uniform(-size, size) for _ in range(2))
        target = rng.choice((0.0, fake.position, rng.uniform(-9.0, 9.0)))
        if step in (200, 400):
            pid.gains = parts.pid.gains = parse_pid(STIFF if step == 200 else SOFT, "c")
        if step in (398, 399, 450):
            fake.velocity = math.nan
        manager.command("c", [target])
        manager.update(STEP)
        expected = parts.update(target, fake.position, fake.velocity)
        if math.isnan(fake.velocity) and goal == "position":
            continue  # the rate is not finite: the joint is not pushed, see below
        assert fake.driven == expected
        for attribute in ("error", "error_rate", "integral", "terms", "output", "last_error"):
            assert getattr(pid, attribute) == getattr(parts.pid, attribute)


@pytest.mark.parametrize("gains", [STIFF, SOFT], ids=["stiff", "soft"])
def test_a_state_that_is_no_number_pushes_nothing_and_leaves_no_trace(gains):
    fake = OneJoint("wheel")
    manager = Manager(fake, inertias={"wheel": INERTIA})
    kind = "effort_controllers/JointPositionController"
    manager.load("c", {"type": kind, "joint": "wheel", "pid": {**gains, "i": 1.0, "i_clamp": 1.0}})
    manager.switch(["c"], [])
    manager.command("c", [0.5])
    manager.update(STEP)
    fake.position = fake.velocity = math.nan
    manager.update(STEP)
    assert fake.driven == 0.0
    fake.position = fake.velocity = 0.0
    manager.update(STEP)
    assert manager.get("c").pids[0].integral == 2 * 0.5 * STEP
    driven = fake.driven if isinstance(fake.driven, tuple) else (fake.driven,)
    assert all(math.isfinite(value) and value > 0.0 for value in driven)


WHEELS = 4
CALLS = (
    "joint_states",
    "drive_velocity",
    "drive_velocities",
    "drive_position",
    "drive_efforts",
    "release",
)


def cart(effort=5.0):
    """URDF of a body with wheels that nothing touches."""
    inertial = (
        '<inertial><mass value="{0}"/><inertia ixx="{1}" iyy="{1}" izz="{1}" ixy="0" ixz="0" '
        'iyz="0"/></inertial>'
    )
    text = f'<robot name="bot"><link name="base">{inertial.format(1, 1)}</link>'
    for number in range(WHEELS):
        text += (
            f'<link name="l{number}">{inertial.format(0.1, INERTIA)}</link><joint name="w{number}" '
            f'type="continuous"><parent link="base"/><child link="l{number}"/><axis xyz="0 0 1"/>'
            f'<limit effort="{effort}" velocity="100"/></joint>'
        )
    plugin = '<plugin name="c" filename="libgazebo_ros_control.so"/>'
    return f"{text}<gazebo>{plugin}</gazebo></robot>"


@pytest.fixture(name="world")
def _world():
    world = World(STEP, gravity=(0.0, 0.0, 0.0), solver="bullet")
    yield world
    world.close()


def controlled(world, gains, goal="Velocity"):
    """The Manager of a cart with a controller each wheel."""
    manager = world.spawn_urdf("bot", cart(), Pose(), nowhere).manager
    names = [f"w{number}" for number in range(WHEELS)]
    for name in names:
        kind = f"effort_controllers/Joint{goal}Controller"
        manager.load(name, {"type": kind, "joint": name, "pid": gains})
    manager.switch(names, [])
    for name in names:
        manager.command(name, [0.5])
    return manager


@pytest.mark.parametrize("gains, command", [(STIFF, "drive_velocities"), (SOFT, "drive_efforts")])
def test_a_robot_takes_one_reading_and_one_command_a_step(world, gains, command, monkeypatch):
    controlled(world, gains)
    world.step(2)
    calls = []
    for name in CALLS:
        work = getattr(world.engine, name)
        monkeypatch.setattr(
            world.engine,
            name,
            lambda *args, _name=name, _work=work: calls.append(_name) or _work(*args),
        )
    world.step(5)
    assert calls == ["joint_states", command] * 5


def test_the_limit_of_effort_holds_for_a_stiff_joint(world):
    """5 N m on 1e-5 kg m^2 a millisecond long is 500 rad/s; the speed's limit is 100 rad/s."""
    manager = controlled(world, {"p": 1e4})
    manager.command("w0", [1e4])
    joints = world.model("bot").joints
    world.step(1)
    reached = joints.state()[1]["w0"]
    assert 0.9 * 500.0 < reached < 1.1 * 500.0
    world.step(5)  # beyond the limit of speed there is no push
    assert joints.state()[1]["w0"] == pytest.approx(reached, rel=1e-3)


def test_motors_are_known_after_commands_to_several_and_to_one(tmp_path):
    engine = Engine(STEP)
    path = tmp_path / "cart.urdf"
    path.write_text(cart())
    body = engine.load(str(path))
    joints = [0, 1, 2]
    engine.drive_velocities(body, joints, [1.0, 2.0, 3.0], [0.1, 0.2, 0.3])
    engine.drive_velocities(body, joints, [4.0, 5.0, 6.0], [0.4, 0.5, 0.6])
    engine.drive_velocity(body, 1, 7.0, 0.7)
    engine.drive_velocities(body, [2, 3], [8.0, 9.0], [0.8, 0.9])
    expected = [
        ("drive_velocity", (0, 4.0, 0.4)),
        ("drive_velocity", (1, 7.0, 0.7)),
        ("drive_velocity", (2, 8.0, 0.8)),
        ("drive_velocity", (3, 9.0, 0.9)),
    ]
    assert [engine.motors()[body, number] for number in range(WHEELS)] == expected
    engine.release(body, 2)
    assert engine.motors()[body, 2] == ("release", (2,))
    engine.close()


def test_a_restored_state_goes_on_to_the_bit(world):
    """Also the motors of joints whose controllers were stopped or exchanged in between."""
    manager = controlled(world, {**STIFF, "i": 40.0, "i_clamp": 0.3}, "Position")
    world.step(30)
    state = world.save_state()
    world.step(50)
    expected = world.snapshot()
    manager.switch([], ["w0", "w1"])
    manager.command("w2", [-0.4])
    manager.get("w3").pids[0].gains = parse_pid(STIFF, "w3")
    world.step(40)
    assert world.restore_state(state) == ""
    manager.get("w3").pids[0].gains = parse_pid({**STIFF, "i": 40.0, "i_clamp": 0.3}, "w3")
    world.step(50)
    assert world.snapshot() == expected

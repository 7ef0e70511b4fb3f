"""Effort controllers: the bits of their parts, and two calls of the engine a step."""

import math
import random
from functools import partial

import pytest
from bullet_sim.controllers.manager import Manager
from bullet_sim.controllers.pid import Pid, PidGains, parse_pid, position_error
from bullet_sim.description.model import Joint, ModelDescription
from bullet_sim.pose import Pose
from contact_scenes import nowhere
from fake_joints import FakeJoints
from urdf_texts import CONTROL, joint, link, robot

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

    def apply_efforts(self, handles, computes=False):
        """Record."""
        (joint,) = handles
        self.driven = joint.effort


def test_gains_follow_in_each_step_by_the_state_of_the_last_update():
    """As DefaultRobotHWSim::writeSim with a controlPeriod: the error stays in between, the integral
    grows by steps, and the error's change counts as that of one step."""
    fake, gains = OneJoint("wheel"), PidGains(2.0, 10.0, 0.01, -5.0, 5.0)
    manager = Manager(fake, ModelDescription("r", control_period=4 * STEP))
    manager.hardware.set_gains("wheel", gains)
    kind = "velocity_controllers/JointVelocityController"
    manager.load("c", {"type": kind, "joint": "wheel"})
    manager.switch(["c"], [])
    manager.command("c", (3.0,))
    pid, seen, driven, expected = Pid(gains, "velocity"), 0.0, [], []
    for step in range(12):
        fake.velocity = 0.1 * step
        seen = fake.velocity if step % 4 == 0 else seen
        assert manager.prepare_steps(STEP) == 1
        driven.append(fake.driven)
        expected.append(pid.update(3.0 - seen, STEP))
    assert driven == expected and len(set(driven)) == 12


@pytest.mark.parametrize("gains", GAINS, ids=str)
@pytest.mark.parametrize(
    "name, goal",
    [("hinge", "position"), ("wheel", "position"), ("slide", "position"), ("wheel", "velocity")],
)
def test_an_update_gives_the_bits_of_its_parts(name, goal, gains):
    """Over set points and states of all sizes, at rest, beyond stops, and a change of gains."""
    fake, joint = OneJoint(name), JOINTS[name]
    manager = Manager(fake)
    kind = f"effort_controllers/Joint{goal.capitalize()}Controller"
    manager.load("c", {"type": kind, "joint": name, "pid": gains})
    manager.switch(["c"], [])
    part = Pid(parse_pid(gains, "c"), goal)
    pid, rng = manager.get("c").pids[0], random.Random(7)
    for step in range(600):
        size = rng.choice((0.0, 1e-9, 0.3, 4.0, 50.0))
        fake.position, fake.velocity = (rng.uniform(-size, size) for _ in range(2))
        target = rng.choice((0.0, fake.position, rng.uniform(-9.0, 9.0)))
        if step in (200, 400):
            pid.gains = part.gains = parse_pid(STIFF if step == 200 else SOFT, "c")
        if step in (398, 399, 450):
            fake.position = fake.velocity = math.nan
        manager.command("c", [target])
        manager.update(STEP)
        if goal == "position":
            error = position_error(joint, fake.position, target)
        else:
            error = target - fake.velocity
        assert fake.driven == part.update(error, STEP)
        for attribute in ("error", "error_rate", "integral", "terms", "output", "last_error"):
            assert getattr(pid, attribute) == getattr(part, attribute)


@pytest.mark.parametrize("gains", [STIFF, SOFT], ids=["stiff", "soft"])
def test_a_state_that_is_no_number_pushes_nothing_and_leaves_no_trace(gains):
    fake = OneJoint("wheel")
    manager = Manager(fake)
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
    assert math.isfinite(fake.driven) and fake.driven > 0.0


WHEELS = 4
CALLS = (
    "getJointStates",
    "getJointState",
    "setJointMotorControl2",
    "setJointMotorControlArray",
)


def cart(effort=5.0):
    """URDF of a body with wheels that nothing touches."""
    limit = f'<limit effort="{effort}" velocity="100"/>'
    return robot(
        link("base", 1, 1),
        *(
            link(f"l{n}", 0.1, INERTIA)
            + joint(f"w{n}", "continuous", "base", f"l{n}", axis="0 0 1", more=limit)
            for n in range(WHEELS)
        ),
        CONTROL,
    )


WORLD = {"time_step": STEP, "gravity": (0.0, 0.0, 0.0), "solver": "bullet"}


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


@pytest.mark.parametrize("gains", [STIFF, SOFT], ids=["stiff", "soft"])
def test_a_robot_takes_one_reading_and_one_command_a_step(world, gains, monkeypatch):
    controlled(world, gains)
    world.step(2)
    calls, api = [], world.engine.client.api

    def count(name, function, *arguments, **options):
        calls.append(name)
        return function(*arguments, **options)

    for name in CALLS:
        monkeypatch.setattr(api, name, partial(count, name, getattr(api, name)))
    world.step(5)
    assert calls == ["getJointStates", "setJointMotorControlArray"] * 5


def test_the_limit_of_effort_holds_for_a_light_joint(world):
    """5 N m on 1e-5 kg m^2 a millisecond long is 500 rad/s; the speed's limit is 100 rad/s."""
    manager = controlled(world, {"p": 1e4})
    manager.command("w0", [1e4])
    joints = world.model("bot").joints
    world.step(1)
    reached = joints.state()[1]["w0"]
    assert 0.9 * 500.0 < reached < 1.1 * 500.0
    world.step(5)  # beyond the limit of speed there is no push
    assert joints.state()[1]["w0"] == pytest.approx(reached, rel=1e-3)


def test_the_last_command_of_each_motor_is_known(world):
    body = world.spawn_urdf("bot", cart(), Pose(), nowhere).body
    motors = [body.motor(f"w{number}") for number in range(WHEELS)]
    for number, motor in enumerate(motors):
        motor.track_velocity(1.0 + number, 0.1)
    motors[1].track_velocity(7.0, 0.7)
    motors[2].track_position(0.5, 0.2, 3.0)
    motors[3].release()
    assert [motor.command for motor in motors] == [
        ("track_velocity", (1.0, 0.1)),
        ("track_velocity", (7.0, 0.7)),
        ("track_position", (0.5, 0.2, 3.0)),
        ("release", ()),
    ]

"""steer_bot_hardware_gazebo: parameters, and commands of two joints on a car's six."""

import math

import pytest
from bullet_sim.controllers.interfaces import Registered
from bullet_sim.controllers.manager import Manager
from bullet_sim.controllers.steer_bot import SteerBotJoints, parse_steer_bot
from bullet_sim.errors import ControllerError
from bullet_sim.formats.urdf import parse_urdf
from fake_joints import COVARIANCES, FakeJoints
from urdf_texts import joint

pytestmark = pytest.mark.usefixtures("sketches")

LENGTH, WIDTH = 0.79, 0.5  # [m]
CAR = ("rr", "rl", "fr", "fl", "sr", "sl")
PARAMETERS = {
    "rear_wheel": "rear_wheel_joint",
    "front_steer": "front_steer_joint",
    "virtual_rear_wheels": ["rr", "rl"],
    "virtual_front_wheels": ["fr", "fl"],
    "virtual_front_steers": ["sr", "sl"],
    "enable_ackermann_link": True,
    "wheel_separation_w": WIDTH,
    "wheel_separation_h": LENGTH,
}


LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="9"/>'
DESCRIPTION = parse_urdf(
    '<robot name="bot"><link name="base"/>'
    + "".join(
        f'<link name="{name}_l"/>'
        + joint(
            name,
            "continuous",
            "base",
            f"{name}_l",
            f"{0.4 if name[0] in 'fs' else -0.3} {0.2 if name[1] == 'l' else -0.2} 0",
            more=LIMIT,
        )
        for name in (*CAR, "spare")
    )
    + '<gazebo><plugin filename="libgazebo_ros_control.so"><robotSimType>'
    "steer_bot_hardware_gazebo/SteerBotHardwareGazebo</robotSimType></plugin></gazebo></robot>",
    str,
    "bot",
    "keep",
)


class Joints(FakeJoints):
    """A car's joints, which record what they are told."""

    names = (*CAR, "spare")
    limits = DESCRIPTION.joints

    def __init__(self):
        self.speeds, self.angles, self.released = {}, {}, []
        self.positions = {"rr": 1.0, "rl": 3.0, "sr": 0.1, "sl": 0.3, "fr": 0, "fl": 0, "spare": 7}

    def state(self):
        """As set."""
        return dict(self.positions), dict.fromkeys(self.names, 1.0)

    def columns(self, numbers):
        """As set."""
        values = [self.positions[self.names[number]] for number in numbers]
        return values, [1.0 for _ in values], [0.5 for _ in values]

    def impose_velocities(self, names, values):
        """Record."""
        self.speeds.update(zip(names, values))

    def impose_positions(self, names, values):
        """Record."""
        self.angles.update(zip(names, values))

    def release(self, names):
        """Record."""
        self.released += names


def _manager(**changes):
    joints = Joints()
    config = parse_steer_bot({**PARAMETERS, **changes}, "bot", joints.names, DESCRIPTION)
    manager = Manager(joints, DESCRIPTION)
    manager.hardware.put_before(SteerBotJoints(joints, config), Registered(config.interfaces()))
    return joints, manager


def _drive(manager, speed, angle):
    manager.load(
        "base",
        {
            "type": "ackermann_steering_controller/AckermannSteeringController",
            **COVARIANCES,
            "wheel_radius": 0.1,
            "wheel_separation_h": LENGTH,
        },
    )
    manager.switch(["base"], [])
    manager.command("base", (speed, angle))
    manager.update(0.001)


def test_a_command_turns_four_wheels_and_two_hinges():
    joints, manager = _manager()
    _drive(manager, 0.5, 0.3)
    assert joints.speeds == dict.fromkeys(("rr", "rl", "fr", "fl"), 5.0)
    tangent = math.tan(0.3)  # upstream's hinges: cot = cot(middle) +- track / (4 length)
    for name, side in (("sr", 1.0), ("sl", -1.0)):
        wanted = math.atan(1.0 / (1.0 / tangent + side * WIDTH / 4.0 / LENGTH))
        assert joints.angles[name] == pytest.approx(wanted)
    manager.switch([], ["base"])
    assert joints.speeds == dict.fromkeys(("rr", "rl", "fr", "fl"), 0.0)
    assert joints.angles == {"sr": 0.0, "sl": 0.0}, "AckermannSteeringController::brake()"


def test_without_the_ackermann_link_both_hinges_turn_alike():
    joints, manager = _manager(enable_ackermann_link=False)
    _drive(manager, 0.0, -0.2)
    assert joints.angles == {"sr": -0.2, "sl": -0.2}


def test_the_commanded_joints_report_the_mean_of_their_pair():
    _, manager = _manager()
    hardware = manager.hardware
    assert hardware.names == tuple(sorted((*CAR, "rear_wheel_joint", "front_steer_joint")))
    hardware.read()
    both = hardware.handles(("rear_wheel_joint", "front_steer_joint"))
    assert [joint.position for joint in both] == [2.0, 0.2]
    columns = hardware.joints.columns([hardware.names.index("rear_wheel_joint"), 0])
    assert columns[0][0] == 2.0 and columns[2] == [0.5, 0.5]


def test_only_its_joints_can_be_controlled_by_their_interfaces():
    _, manager = _manager()
    for name, words in (("spare", "does not exist"), ("fl", "offers state"), ("sl", "position")):
        with pytest.raises(ControllerError, match=words):
            kind = "velocity_controllers/JointVelocityController"
            manager.load(name, {"type": kind, "joint": name})


def test_sizes_that_are_not_given_come_from_the_description():
    values = {key: value for key, value in PARAMETERS.items() if "separation" not in key}
    config = parse_steer_bot(values, "bot", CAR, DESCRIPTION)
    assert (config.track, config.wheel_base) == pytest.approx((0.4, 0.7))


@pytest.mark.parametrize(
    "change, words",
    [
        ({"rear_wheel": None}, "bot has rear_wheel None, must be a name"),
        ({"virtual_front_steers": ["sr"]}, "must be two joints, right and left"),
        ({"virtual_rear_wheels": ["rr", "none"]}, "joints are rr, rl, fr"),
        ({"wheel_separation_h": -1}, "wheel_separation_h -1, must be a number above 0"),
    ],
)
def test_errors_name_the_parameter(change, words):
    with pytest.raises(ControllerError, match=words):
        parse_steer_bot({**PARAMETERS, **change}, "bot", CAR, DESCRIPTION)


def test_robot_sim_types_are_read_and_unknown_ones_are_a_warning():
    assert DESCRIPTION.robot_sim_type == "steer_bot_hardware_gazebo/SteerBotHardwareGazebo"
    text = (
        '<robot name="r"><link name="a"/><gazebo><plugin filename="libgazebo_ros_control.so">'
        "<robotSimType>{}</robotSimType></plugin></gazebo></robot>"
    )
    other = parse_urdf(text.format("my_robot/Sim"), str, "r")
    assert other.robot_sim_type == "gazebo_ros_control/DefaultRobotHWSim"
    assert "robotSimType 'my_robot/Sim', known are" in str(other.warnings)
    assert not parse_urdf(text.format("gazebo_ros_control/DefaultRobotHWSim"), str, "r").warnings

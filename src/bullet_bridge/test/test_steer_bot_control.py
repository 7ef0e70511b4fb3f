"""A car of robotSimType SteerBotHardwareGazebo: parameters, commands and joint states."""

import pytest
from bot_rig import CONTROL, LINK, Bot, held_robot
from geometry_msgs.msg import Twist

JOINT = (
    '<joint name="{0}" type="continuous"><origin xyz="{1} {2} 0"/><parent link="base"/>'
    '<child link="{0}_link"/><axis xyz="0 1 0"/><limit effort="10" velocity="50"/></joint>'
)
NAMES = ("rr", "rl", "fr", "fl", "sr", "sl")
HARDWARE = "<robotSimType>steer_bot_hardware_gazebo/SteerBotHardwareGazebo</robotSimType>"
URDF = held_robot(
    (
        LINK.format(f"{n}_link") + JOINT.format(n, 1.0 if n[0] in "fs" else 0.0, len(n))
        for n in NAMES
    ),
    control=CONTROL.replace("/></gazebo>", f">{HARDWARE}</plugin></gazebo>"),
)
PARAMS = {
    "/bot/steer_bot_hardware_gazebo": {
        "rear_wheel": "rear_wheel_joint",
        "front_steer": "front_steer_joint",
        "virtual_rear_wheels": ["rr", "rl"],
        "virtual_front_wheels": ["fr", "fl"],
        "virtual_front_steers": ["sr", "sl"],
        "wheel_separation_w": 0.5,
        "wheel_separation_h": 1.0,
    },
    "/bot/states": {"type": "joint_state_controller/JointStateController", "publish_rate": 50},
    "/bot/car": {
        "type": "steer_drive_controller/SteerDriveController",
        "wheel_radius": 0.1,
        "wheel_separation_h": 1.0,
        "pose_covariance_diagonal": [0.1] * 6,
        "twist_covariance_diagonal": [0.1] * 6,
    },
}


def _bot(monkeypatch, params):
    return Bot(monkeypatch, URDF, params)


def test_the_car_drives_and_reports_the_joints_of_its_hardware_layer(monkeypatch):
    bot = _bot(monkeypatch, PARAMS)
    bot.start("states")
    bot.start("car")
    command = Twist()
    command.linear.x, command.angular.z = 0.5, 0.2
    bot.endpoints["/bot/car/cmd_vel"].call(command)
    bot.run(200)
    assert [bot.velocity(n) for n in NAMES[:4]] == pytest.approx([5.0] * 4, rel=0.01)
    spec = bot.control.manager.hardware
    state = dict(zip(spec.names, spec.joints.columns(range(len(spec.names)))[0]))
    assert state["sl"] > state["front_steer_joint"] > state["sr"] > 0.15
    assert len(state) == 8 and "rear_wheel_joint" in state
    bot.world.close()


def test_without_its_parameters_the_joints_are_the_urdfs_and_one_error_says_so(monkeypatch):
    params = {name: value for name, value in PARAMS.items() if "hardware" not in name}
    bot = _bot(monkeypatch, params)
    assert bot.control.manager.hardware.names == NAMES
    errors = [line for line in bot.log if "steer_bot_hardware_gazebo" in line]
    assert len(errors) == 1 and "the joints are those of the URDF" in errors[0]
    bot.world.close()

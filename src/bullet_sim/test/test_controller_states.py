"""Every type of controller goes on from a saved state as if it had never stopped, to the bit."""

import math

import pytest
from bullet_sim.controllers import CONTROLLERS
from bullet_sim.controllers.gripper import GripperControl, GripperGoal
from bullet_sim.controllers.segments import Command, Goal, Point
from bullet_sim.controllers.trajectory import TrajectoryControl
from bullet_sim.pose import Pose
from bullet_sim.world import World
from fake_joints import COVARIANCES
from urdf_texts import inertial

INERTIAL = inertial("{0}", "{1}")
JOINTS = {  # name -> type and limits
    "a": ("continuous", 'effort="5" velocity="30"'),
    "b": ("revolute", 'lower="-1" upper="1.5" effort="8" velocity="6"'),
    "c": ("prismatic", 'lower="-1" upper="1" effort="40" velocity="2"'),
    "d": ("continuous", 'effort="3" velocity="20"'),
    "e": ("revolute", 'lower="-2" upper="2" effort="9" velocity="9"'),
    "f": ("revolute", 'lower="-2" upper="2" effort="9" velocity="9"'),
    "g": ("continuous", 'effort="3" velocity="20"'),
    "h": ("continuous", 'effort="3" velocity="20"'),
}
PID = {"p": 30.0, "i": 4.0, "d": 2.0, "i_clamp": 1.0}
URDF = (
    '<robot name="bot"><link name="world"/><joint name="held" type="fixed"><parent link="world"/>'
    f'<child link="base"/></joint><link name="base">{INERTIAL.format(50, 5)}</link>'
    + "".join(
        f'<link name="l_{name}">{INERTIAL.format(1.0, 0.02)}<collision><geometry><cylinder '
        f'radius="0.1" length="0.05"/></geometry></collision></link><joint name="{name}" '
        f'type="{kind}"><parent link="base"/><child link="l_{name}"/><origin xyz="{number % 2} '
        f'{number // 2} 1"/><axis xyz="0 0 1"/><limit {limits}/></joint>'
        for number, (name, (kind, limits)) in enumerate(JOINTS.items())
    )
    + '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/><plugin name="f" '
    'filename="libgazebo_ros_ft_sensor.so"><jointName>c</jointName><topicName>t</topicName>'
    "</plugin></gazebo>"
    '<gazebo reference="base"><sensor name="imu" type="imu"><plugin name="i" '
    'filename="libgazebo_ros_imu_sensor.so"><frameName>base</frameName></plugin></sensor></gazebo>'
    "</robot>"
)
SETTINGS = {
    "diff_drive_controller/DiffDriveController": {
        **COVARIANCES,
        "left_wheel": "a",
        "right_wheel": "d",
        "linear": {"x": {"has_acceleration_limits": True, "max_acceleration": 1.0}},
    },
    "four_wheel_steering_controller/FourWheelSteeringController": {
        **COVARIANCES,
        "front_wheel": ["a", "d"],
        "rear_wheel": ["g", "h"],
        "front_steering": ["b", "e"],
        "rear_steering": ["f", "c"],
        "track": 1.0,
        "wheel_base": 1.0,
    },
}
STEERED = {**COVARIANCES, "rear_wheel": "a", "front_steer": "b"}


def settings(name):
    """An entry of the YAML file for a type."""
    kind = CONTROLLERS.find(name)
    pid = {"pid": PID}
    several = {"joints": ["b", "c"], "b": pid, "c": pid, "gains": {"b": PID, "c": PID}}
    values = {**STEERED} if "teer" in name else {**several} if kind.group else {"joint": "b", **pid}
    if issubclass(kind, GripperControl):
        values = {"joint": "b", "gains": {"b": PID}, "max_effort": 5.0}
    if kind.interface in ("state", "imu", "force_torque"):
        values = {"publish_rate": 50}
    return {"type": name, **SETTINGS.get(name, values)}


def command(manager, number):
    """Drive the controller in the period of a number."""
    control, angle = manager.get("c"), math.sin(0.1 * number)
    if isinstance(control, TrajectoryControl):
        if number % 20 == 0:
            points = Point(0.05, (angle, 0.3)), Point(0.4, (-angle, 0.1), (0.1, 0.2))
            control.execute(Command(("b", "c"), points), Goal(lambda *_: None))
    elif isinstance(control, GripperControl):
        if number % 20 == 0:
            control.execute(GripperGoal(angle, 3.0, lambda *_: None))
    elif control.config.claims:
        sizes = getattr(control, "command_sizes", (len(control.joints),))
        manager.command("c", [angle, 0.4, 0.2][: sizes[-1]])


def trace(world, start, end):
    """All that the joints do in some periods, and the controller's odometry."""
    manager, found = world.model("bot").manager, []
    for number in range(start, end):
        command(manager, number)
        world.step(5)
        manager.observe()
        odometry = getattr(manager.get("c"), "odometry", None)
        motion = None if odometry is None else (odometry.x, odometry.heading, odometry.linear)
        found.append((world.model("bot").joints.columns(range(len(JOINTS))), motion))
    return found


@pytest.mark.parametrize("name", CONTROLLERS.names())
def test_it_goes_on_as_without_a_pause(name):
    def started():
        world = World(0.002)
        world.spawn_urdf("bot", URDF, Pose(), str)
        manager = world.model("bot").manager
        manager.load("c", settings(name))
        manager.switch(["c"], [])
        trace(world, 0, 30)
        return world

    straight, paused = started(), started()
    expected = trace(straight, 30, 70)
    state = paused.save_state()
    for _ in range(2):  # a state can be restored more than once
        trace(paused, 55, 85)  # somewhere else, with other commands and goals
        paused.model("bot").manager.switch([], ["c"])
        paused.step(10)
        assert paused.restore_state(state) == ""
        assert trace(paused, 30, 70) == expected
    straight.close()
    paused.close()

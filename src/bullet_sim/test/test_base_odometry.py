"""Odometry of bases that drive, compared with where they are."""

import math

import pytest
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from fake_joints import COVARIANCES
from urdf_texts import CONTROL, inertial, link, robot

RADIUS, WHEELBASE, TRACK = 0.1, 0.5, 0.4  # [m]
BODY = link("base", 4, (0.05, 0.05, 0.1), center="{}")
INERTIAL = inertial(0.5, (0.002, 0.003, 0.002))


def wheel(name, parent, xyz):
    """A wheel about y that slips as little as the solver ode lets it: see docs/physics.md."""
    return (
        f'<link name="{name}_link">{INERTIAL}<collision><origin rpy="1.5707963 0 0"/><geometry>'
        f'<cylinder radius="{RADIUS}" length="0.004"/></geometry></collision></link>'
        f'<joint name="{name}" type="continuous"><origin xyz="{xyz}"/><parent link="{parent}"/>'
        f'<child link="{name}_link"/><axis xyz="0 1 0"/><limit effort="20" velocity="50"/>'
        f'</joint><gazebo reference="{name}_link"><mu1>1</mu1><mu2>1</mu2>'
        "<kp>1e6</kp><kd>100</kd><fdir1>0 0 1</fdir1></gazebo>"
    )


def ball(name, xyz):
    """A ball that slides without friction."""
    return (
        f'<link name="{name}"><collision><geometry><sphere radius="0.05"/></geometry>'
        f'</collision></link><joint name="{name}_joint" type="fixed"><origin xyz="{xyz}"/>'
        f'<parent link="base"/><child link="{name}"/></joint>'
        f'<gazebo reference="{name}"><mu1>0</mu1><mu2>0</mu2></gazebo>'
    )


DIFF = robot(
    BODY.format("0.05 0 0"),
    wheel("left", "base", f"0 {TRACK / 2} 0"),
    wheel("right", "base", f"0 {-TRACK / 2} 0"),
    ball("nose", "0.2 0 -0.05"),
    CONTROL,
)
TRICYCLE = robot(
    BODY.format("0.2 0 0"),
    wheel("rear", "base", "0 0 0"),
    ball("port", "0.2 0.2 -0.049"),
    ball("starboard", "0.2 -0.2 -0.049"),
    f'<link name="fork">{INERTIAL}</link><joint name="steer" type="revolute"><origin xyz='
    f'"{WHEELBASE} 0 0"/><parent link="base"/><child link="fork"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" effort="20" velocity="10"/></joint>',
    wheel("front", "fork", "0 0 0"),
    CONTROL,
)
DIFF_DRIVE = {
    "type": "diff_drive_controller/DiffDriveController",
    "left_wheel": "left",
    "right_wheel": "right",
}
ACKERMANN = {
    "type": "ackermann_steering_controller/AckermannSteeringController",
    "rear_wheel": "rear",
    "front_steer": "steer",
}


@pytest.mark.parametrize(
    "urdf, config, command, turn",
    [
        (DIFF, DIFF_DRIVE, (0.4, 0.8), 0.8),
        (DIFF, DIFF_DRIVE, (-0.4, 0.3), 0.3),
        (TRICYCLE, ACKERMANN, (0.4, 0.5), 0.4 * math.tan(0.5) / WHEELBASE),
    ],
    ids=["diff", "diff backwards", "ackermann"],
)
def test_odometry_stays_with_the_truth_on_a_circle(urdf, config, command, turn):
    world = World()
    world.spawn(sdf.ground_plane())
    bot = world.spawn_urdf("bot", urdf, Pose((0.0, 0.0, RADIUS)), str)
    world.step(200)
    bot.manager.load("base", {**config, **COVARIANCES})
    bot.manager.switch(["base"], [])
    start = bot.pose
    seconds, heading = 0.0, 0.0
    for _ in range(60):
        bot.manager.command("base", command)
        world.step(100)
        seconds += 0.1
        now = bot.pose.rpy[2] - start.rpy[2]
        heading += math.remainder(now - heading, 2 * math.pi)
    bot.manager.observe()
    odometry = bot.manager.get("base").odometry
    x, y = (b - a for a, b in zip(start.position[:2], bot.pose.position[:2]))
    travelled = abs(command[0]) * seconds
    assert heading == pytest.approx(turn * seconds, rel=0.03)
    assert odometry.heading == pytest.approx(heading, rel=0.02)
    assert math.hypot(odometry.x - x, odometry.y - y) < 0.02 * travelled
    world.close()

"""diff_drive and ackermann_steering: configuration, limits, time-out, odometry in closed form."""

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest
from bullet_sim.controllers import configure
from bullet_sim.controllers.drive import Odometry
from bullet_sim.controllers.drive_settings import SpeedLimiter
from bullet_sim.description.model import Geometry
from bullet_sim.errors import ControllerError
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.drives import WheelDrive
from bullet_sim.pose import Pose
from fake_joints import COVARIANCES, Base, FakeJoints

pytestmark = pytest.mark.usefixtures("sketches")

DIFF = "diff_drive_controller/DiffDriveController"
ACKERMANN = "ackermann_steering_controller/AckermannSteeringController"
STEP = 0.001  # [s]
RADIUS, SEPARATION, WHEELBASE = 0.1, 0.4, 0.5  # [m]


def _joint(name, kind, xyz, parent="axle"):
    shape = (
        '<collision><geometry><cylinder radius="0.1" length="0.05"/></geometry></collision>'
        if kind == "continuous"
        else ""
    )
    return (
        f'<link name="{name}_link">{shape}</link><joint name="{name}" type="{kind}">'
        f'<origin xyz="{xyz}"/><parent link="{parent}"/><child link="{name}_link"/>'
        '<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="50"/></joint>'
    )


def _description(axle, wheels):
    """A robot whose wheels are at `wheels` on an axle that is at `axle`: x [m]."""
    return parse_urdf(
        '<robot name="bot"><link name="base"/><link name="axle"/><joint name="f" type="fixed">'
        f'<origin xyz="{axle} 0 0"/><parent link="base"/><child link="axle"/></joint>'
        + _joint("left", "continuous", f"{wheels} 0.2 0")
        + _joint("right", "continuous", f"{wheels} -0.2 0")
        + _joint("bare", "revolute", "0 0 0")
        + _joint("steer", "revolute", "0.3 0 0", "base")
        + "</robot>",
        str,
        "bot",
        "keep",
    )


DESCRIPTION = _description(0.0, -0.2)
NAMES = ("left", "right", "bare", "steer")


class Wheels(FakeJoints):
    """Joints that turn exactly as commanded."""

    names = NAMES
    limits = DESCRIPTION.joints


def make(**config):
    """A base with a controller."""
    return Base(Wheels(), DESCRIPTION, config)


def diff(**config):
    """A diff drive base, its sizes from the description."""
    return make(type=DIFF, left_wheel="left", right_wheel=["right"], **config)


def ackermann(**config):
    """An Ackermann base."""
    return make(type=ACKERMANN, rear_wheel="left", front_steer="steer", **config)


# arcs ---------------------------------------------------------------------------------------------
@pytest.mark.parametrize("speed, rate", [(0.5, 0.0), (0.5, 0.8), (-0.3, 1.1), (0.0, -1.0)])
def test_diff_drive_odometry_of_arcs(speed, rate):
    odometry = diff().run(2.0, (speed, rate))
    turn = rate * 2.0
    x = speed / rate * math.sin(turn) if rate else speed * 2.0
    y = speed / rate * (1 - math.cos(turn)) if rate else 0.0
    assert (odometry.x, odometry.y, odometry.heading) == pytest.approx((x, y, turn), abs=1e-9)
    assert (odometry.linear, odometry.angular) == pytest.approx((speed, rate), abs=1e-9)


def test_diff_drive_wheel_speeds():
    base = diff()
    base.run(0.01, (0.6, 0.5))
    assert base.joints.speeds["left"] == pytest.approx((0.6 - 0.5 * SEPARATION / 2) / RADIUS)
    assert base.joints.speeds["right"] == pytest.approx((0.6 + 0.5 * SEPARATION / 2) / RADIUS)


@pytest.mark.parametrize("angle", [0.0, 0.3, -0.6])
def test_ackermann_odometry_of_arcs(angle):
    base = ackermann()
    odometry = base.run(2.0, (0.4, angle))
    rate = 0.4 * math.tan(angle) / WHEELBASE
    assert base.joints.speeds["left"] == pytest.approx(0.4 / RADIUS)
    assert base.joints.positions["steer"] == pytest.approx(angle)
    assert odometry.heading == pytest.approx(2.0 * rate, abs=1e-3)
    if angle:
        radius = WHEELBASE / math.tan(angle)
        assert math.hypot(odometry.x, odometry.y - radius) == pytest.approx(abs(radius), rel=1e-3)


@pytest.mark.parametrize("make", [diff, ackermann])
def test_open_loop_trusts_the_command(make):
    """Its second number is the yaw rate in ackermann_steering_controller, too, where it steers by
    it as an angle: Odometry::updateOpenLoop. The velocity is the command's, without a window."""
    base = make(open_loop=True)
    base.joints.drive_velocities = lambda names, values: None  # the wheels are stuck
    assert base.run(1.0, (0.5, 0.7)).heading == pytest.approx(0.7, rel=0.01)
    odometry = base.run(0.02, (0.25, 0.1))
    assert (odometry.linear, odometry.angular) == pytest.approx((0.25, 0.1))


def test_velocity_is_averaged_over_the_window():
    odometry = Odometry(window=4)
    for step in range(1, 6):
        odometry.move(0.001 * step, 0.0, 0.01 * step)
    assert odometry.linear == pytest.approx(0.1 * (2 + 3 + 4 + 5) / 4)


def test_observing_twice_at_one_time_changes_nothing():
    base = diff()
    odometry = base.run(0.5, (0.5, 0.5))
    before = (odometry.x, odometry.heading, odometry.linear)
    base.manager.observe()
    assert (odometry.x, odometry.heading, odometry.linear) == before


def test_starting_where_the_wheels_stand_is_no_jump():
    base = diff()
    base.manager.switch([], ["base"])
    base.joints.positions.update(left=50.0, right=70.0)
    base.manager.switch(["base"], [])
    odometry = base.run(0.1)
    assert (odometry.x, odometry.y, odometry.heading) == (0.0, 0.0, 0.0)


def test_restart_is_at_the_origin():
    base = diff()
    base.run(1.0, (0.5, 0.5))
    base.manager.restart()
    odometry = base.run(0.05)
    assert (odometry.x, odometry.heading, base.joints.speeds["left"]) == (0.0, 0.0, 0.0)


# commands -----------------------------------------------------------------------------------------
@pytest.mark.parametrize("timeout", [0.25, 0.5])
def test_a_command_counts_until_the_time_out(timeout):
    base = diff(cmd_vel_timeout=timeout)
    base.manager.command("base", (0.5, 0.0))
    base.run(timeout - 0.01)
    assert base.joints.speeds["left"] == pytest.approx(5.0)
    base.run(0.02)
    assert base.joints.speeds["left"] == 0.0


def test_stopping_releases_the_wheels():
    base = diff()
    base.run(0.1, (0.5, 0.0))
    base.manager.switch([], ["base"])
    assert base.joints.speeds["left"] == 0.0 and not base.manager.periodic


LIMITS = {
    "has_velocity_limits": True,
    "max_velocity": 1.0,
    "min_velocity": -0.5,
    "has_acceleration_limits": True,
    "max_acceleration": 2.0,
}


@pytest.mark.parametrize(
    "wanted, seconds, speed",
    [(9.0, 0.25, 0.5), (9.0, 1.0, 1.0), (-9.0, 0.1, -0.2), (-9.0, 1.0, -0.5)],
)
def test_velocity_and_acceleration_limits(wanted, seconds, speed):
    base = diff(linear={"x": LIMITS})
    base.run(seconds, (wanted, 0.0))
    assert base.joints.speeds["left"] * RADIUS == pytest.approx(speed, abs=2e-3)


def test_jerk_limit_makes_a_parabola():
    """With jerk limit j as upstream applies it (2 j dt^2 a period), v(t) = j t^2."""
    limiter, speeds = SpeedLimiter(jerk=(-3.0, 3.0)), [0.0, 0.0]
    for _ in range(500):
        speeds.append(limiter.limit(9.0, speeds[-1], speeds[-2], STEP))
    assert speeds[-1] == pytest.approx(3.0 * 0.5**2, rel=0.01)


# configuration ------------------------------------------------------------------------------------
def parse(**config):
    """Checked configuration with the description's sizes."""
    return configure("base", {**COVARIANCES, **config}, NAMES, DESCRIPTION)[1]


def test_sizes_are_between_the_joints_own_origins():
    """As upstream, which asks for no more than <origin>: not where an axle in between puts them."""
    on_axle = _description(-0.15, -0.05)
    facts = {"type": ACKERMANN, "rear_wheel": "left", "front_steer": "steer", **COVARIANCES}
    assert configure("b", facts, NAMES, on_axle)[1].separation == pytest.approx(0.35)


def test_claims():
    config = parse(type=ACKERMANN, rear_wheel="left", front_steer="steer")
    assert config.claims == (("position", ("steer",)), ("velocity", ("left",)))
    assert parse(type=DIFF, left_wheel="left", right_wheel="right").claims == (
        ("velocity", ("left", "right")),
    )


def test_numbers_that_yaml_takes_for_text_and_keys_without_effect():
    config = parse(
        type=DIFF,
        left_wheel="left",
        right_wheel="right",
        publish_rate="5e1",
        use_imu=1,
        preserve_turning_radius=True,
    )
    assert config.publish_rate == 50.0
    assert len(config.notes) == 1 and "preserve_turning_radius" in config.notes[0]
    assert len(config.warnings) == 1 and "key 'use_imu'" in config.warnings[0]


def test_what_upstream_reads_of_a_short_list_and_of_limits_that_are_not_given():
    """As Gazebo 11.1 with ros_controllers: elements that are not there are 0, and so is a max."""
    sides = {"type": DIFF, "left_wheel": "left", "right_wheel": "right"}
    given = {f"has_{quantity}_limits": True for quantity in ("velocity", "acceleration", "jerk")}
    config = parse(**sides, pose_covariance_diagonal=[0.1, 0.2], linear={"x": given})
    assert config.pose_covariance == (0.1, 0.2, 0.0, 0.0, 0.0, 0.0)
    assert config.linear == SpeedLimiter((0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    odd = parse(**sides, angular={"z": {**given, "max_jerk": -1.0, "min_velocity": 0.5}})
    assert (odd.angular.jerk, odd.angular.velocity) == ((1.0, -1.0), (0.5, 0.0))


BAD = [
    ({"left_wheel": "left"}, "right_wheel None"),
    ({"left_wheel": [], "right_wheel": "right"}, r"left_wheel \[\]"),
    ({"left_wheel": ["left", "bare"], "right_wheel": "right"}, "2 left and 1 right"),
    ({"left_wheel": "nose", "right_wheel": "right"}, "joint 'nose'"),
    ({"left_wheel": "left", "right_wheel": "left", "wheel_separation": 1}, "'left' twice"),
    ({"left_wheel": "bare", "right_wheel": "right"}, "no wheel_radius, and.*bare_link"),
    ({"left_wheel": "left", "right_wheel": "right", "wheel_radius": 0}, "wheel_radius 0"),
    ({"left_wheel": "left", "right_wheel": "right", "wheel_radius": "big"}, "'big'"),
    ({"left_wheel": "left", "right_wheel": "right", "publish_rate": -1}, "publish_rate -1"),
    ({"left_wheel": "left", "right_wheel": "right", "open_loop": "no"}, "open_loop 'no'"),
    ({"left_wheel": "left", "right_wheel": "right", "linear": 3}, "linear is 3"),
    *(
        ({"left_wheel": "left", "right_wheel": "right", "twist_covariance_diagonal": value}, text)
        for value, text in ((None, "None"), ([1.0] * 5 + [2], "2]"), (["1e6"] * 6, "'1e6'"))
    ),
    ({"left_wheel": "left", "right_wheel": "right", "base_frame_id": ""}, "base_frame_id"),
]


@pytest.mark.parametrize("config, text", BAD, ids=[text for _, text in BAD])
def test_bad_configuration_is_refused_by_name(config, text):
    with pytest.raises(ControllerError, match=f"controller 'base'.*{text}"):
        parse(type=DIFF, **config)


def test_spheres_are_wheels_of_diff_drive_alone_as_upstream():
    shape = replace(
        DESCRIPTION.links["left_link"].collisions[0], geometry=Geometry("sphere", (0.2,))
    )
    links = {name: replace(link) for name, link in DESCRIPTION.links.items()}
    for name in ("left_link", "right_link"):
        links[name].collisions = [shape]
    description = replace(DESCRIPTION, links=links)
    values = {"type": DIFF, "left_wheel": "left", "right_wheel": "right", **COVARIANCES}
    _, config = configure("base", values, NAMES, description)
    assert config.sizes[1] == 0.2
    values = {"type": ACKERMANN, "rear_wheel": "left", "front_steer": "steer", **COVARIANCES}
    with pytest.raises(ControllerError, match="no wheel_radius, and link 'left_link' has no cylin"):
        configure("base", values, NAMES, description)
    configure("base", {**values, "wheel_radius": 0.2}, NAMES, description)


def test_missing_joints_of_an_ackermann_base_are_named():
    with pytest.raises(ControllerError, match="joint 'rear_wheel_joint' is not"):
        parse(type=ACKERMANN, front_steer="steer")


def test_encoders_count_from_the_first_angles_and_add_up_arcs():
    drive = WheelDrive(SimpleNamespace(diameter=0.2, separation=0.5, acceleration=0.0))
    drive.measure(5.0, 7.0, (0.0, 0.0))
    assert drive.pose == Pose()
    drive.measure(6.0, 7.5, (1.0, 0.5))  # 0.1 m and 0.05 m
    assert drive.pose.position == pytest.approx(
        (0.075 * math.cos(0.05), -0.075 * math.sin(0.05), 0.0)
    )
    assert drive.pose.rpy[2] == pytest.approx(-0.1)
    assert drive.twist[1][2] == pytest.approx(-0.1)

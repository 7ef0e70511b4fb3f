"""four_wheel_steering_controller: sizes, wheels and odometry in closed form."""

import math

import pytest
from bullet_sim.controllers.four_wheel import FourWheelOdometry
from bullet_sim.errors import CommandError, ControllerError
from bullet_sim.formats.urdf import parse_urdf
from fake_joints import Base, FakeJoints

pytestmark = pytest.mark.usefixtures("sketches")

TYPE = "four_wheel_steering_controller/FourWheelSteeringController"
STEP = 0.001  # [s]
LENGTH, WIDTH, OFFSET, RADIUS = 1.2, 0.7, 0.1, 0.25  # [m]; WIDTH between the wheels
CORNERS = {"fl": (1, 1), "fr": (1, -1), "rl": (-1, 1), "rr": (-1, -1)}
WHEELS = tuple(f"{corner}_wheel" for corner in CORNERS)
STEERS = tuple(f"{corner}_steer" for corner in CORNERS)


def _corner(name, ahead, left):
    x, y = ahead * LENGTH / 2, left * (WIDTH / 2 - OFFSET)
    return (
        f'<link name="{name}_k"/><joint name="{name}_steer" type="revolute"><origin xyz="{x} {y} '
        f'0"/><parent link="base"/><child link="{name}_k"/><axis xyz="0 0 1"/><limit lower="-1.6" '
        f'upper="1.6" effort="1" velocity="9"/></joint><link name="{name}_w"><collision><geometry>'
        f'<cylinder radius="{RADIUS}" length="0.1"/></geometry></collision></link><joint '
        f'name="{name}_wheel" type="continuous"><origin xyz="0 {left * OFFSET} -0.3"/><parent '
        f'link="{name}_k"/><child link="{name}_w"/><axis xyz="0 1 0"/></joint>'
    )


DESCRIPTION = parse_urdf(
    '<robot name="bot"><link name="base"/>'
    + "".join(_corner(name, *place) for name, place in CORNERS.items())
    + "</robot>",
    str,
    "bot",
    "keep",
)
CONFIG = {
    "type": TYPE,
    "front_wheel": list(WHEELS[:2]),
    "rear_wheel": list(WHEELS[2:]),
    "front_steering": list(STEERS[:2]),
    "rear_steering": list(STEERS[2:]),
}


class Joints(FakeJoints):
    """The base's."""

    names = (*WHEELS, *STEERS)
    limits = DESCRIPTION.joints


def base_of(**changes):
    """A base with the running controller."""
    return Base(Joints(), DESCRIPTION, {**CONFIG, **changes})


def wheel_motion(joints, corner):
    """Velocity (x, y) [m/s] of a wheel's contact along the ground, by its rim."""
    angle, rim = joints.positions[f"{corner}_steer"], joints.speeds[f"{corner}_wheel"]
    return RADIUS * rim * math.cos(angle), RADIUS * rim * math.sin(angle)


def contact(corner, angle):
    """Where a wheel touches the ground, in the body's frame [m]."""
    ahead, left = CORNERS[corner]
    return (
        ahead * LENGTH / 2 - left * OFFSET * math.sin(angle),
        left * (WIDTH / 2 - OFFSET) + left * OFFSET * math.cos(angle),
    )


def test_sizes_come_from_the_description_seen_from_above():
    drive = base_of().config
    sizes = (drive.track, drive.offset, drive.radius, drive.wheel_base)
    assert sizes == pytest.approx((WIDTH - 2 * OFFSET, OFFSET, RADIUS, LENGTH))
    assert base_of(track=1.0, wheel_base=2.0, wheel_radius=0.5).config.track == 1.0 - 2 * OFFSET


# Every wheel rolls as the rigid body moves where it touches: v + w x r.
@pytest.mark.parametrize(
    "command, motion",
    [
        ((1.0, 0.0), (1.0, 0.0, 0.0)),
        ((1.0, 0.8), (1.0, 0.0, 0.8)),
        ((-0.6, 0.5), (-0.6, 0.0, 0.5)),
        # angles a, b: turn v (tan a - tan b) / length, sideways v (tan a + tan b) / 2
        ((0.8, 0.3, -0.2), (0.8, 0.4 * (math.tan(0.3) - math.tan(0.2)), 0.0)),
        ((0.8, 0.4, 0.0), (0.8, 0.4 * math.tan(0.4), 0.0)),
    ],
)
def test_wheels_roll_as_the_body_moves_and_the_odometry_knows_it(command, motion):
    base = base_of()
    odometry = base.run(0.5, command)
    forward, lateral, turn = motion
    if len(command) == 3:
        turn = forward * (math.tan(command[1]) - math.tan(command[2])) / LENGTH
    for corner in CORNERS:
        x, y = contact(corner, base.joints.positions[f"{corner}_steer"])
        wanted = forward - turn * y, lateral + turn * x
        assert wheel_motion(base.joints, corner) == pytest.approx(wanted, abs=1e-9), corner
    found = odometry.linear, odometry.lateral, odometry.angular
    assert found == pytest.approx((forward, lateral, turn), abs=1e-9)
    assert odometry.heading == pytest.approx(0.5 * turn, abs=1e-9)


def test_odometry_of_a_circle_returns():
    odometry = base_of().run(2.0 * math.pi / 0.8, (1.0, 0.8))
    assert (odometry.x, odometry.y) == pytest.approx((0.0, 0.0), abs=2e-3)


def test_equal_angles_move_it_sideways_at_the_rims_speed():
    """Parallel wheels: the speed is along them, as upstream has it."""
    odometry = base_of().run(1.0, (0.5, 0.6, 0.6))
    assert odometry.heading == 0.0
    assert (odometry.x, odometry.y) == pytest.approx(
        (0.5 * math.cos(0.6), 0.5 * math.sin(0.6)), abs=1e-9
    )


def test_a_twist_that_turns_more_than_it_moves_sets_the_wheels_across():
    base = base_of()
    base.run(0.01, (0.01, 2.0))
    assert base.joints.positions["fl_steer"] == math.pi / 2 == -base.joints.positions["rl_steer"]
    base.run(0.01, (0.0, 2.0))
    assert set(base.joints.speeds.values()) == {0.0}


def test_limits_and_timeout():
    config = {"linear": {"x": {"has_acceleration_limits": True, "max_acceleration": 2.0}}}
    base = base_of(**config)
    assert base.run(0.2, (1.0, 0.0, 0.0)).speed == pytest.approx(0.4, rel=0.01)
    assert base.run(0.2, (1.0, 0.0, 0.0)).acceleration == pytest.approx(2.0, rel=0.01)
    base.run(0.5)
    assert base.run(1.0).linear == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    "change, words",
    [
        ({"front_wheel": "fl_wheel"}, "1 joints in front_wheel, must be two"),
        ({"rear_steering": ["a", "b", "c"]}, "3 joints in rear_steering, must be two"),
        ({"front_steering": ["none", "fr_steer"]}, "joint 'none' is not in the robot's"),
        ({"wheel_base": 0}, "wheel_base 0, must be a number above 0"),
    ],
)
def test_configuration_errors_name_the_key(change, words):
    with pytest.raises(ControllerError, match=words):
        base_of(**change)


def test_commands_have_two_or_three_numbers():
    base = base_of()
    with pytest.raises(CommandError, match="1 values, must have 2 or 3"):
        base.manager.command("base", (1.0,))


def test_rates_are_means_over_the_window_of_one_period_at_least():
    for window, rate in ((0, 30.0), (1, 30.0), (2, 20.0)):
        odometry = FourWheelOdometry(window)
        for angle in (0.1, 0.4):
            odometry.move((0.0, 0.0, 0.0), (angle, 0.0), 0.01)
        assert odometry.rates[0] == pytest.approx(rate), window

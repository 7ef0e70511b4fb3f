"""Closed-form checks of the steering geometry."""

import math

import pytest
from deepracer_control.ackermann import Geometry, bicycle_steering, wheel_commands

L, HF, HR, R = 0.164, 0.079601, 0.08105, 0.03


@pytest.mark.parametrize("degrees", [-30, -20, -5, 5, 10, 20, 30])
@pytest.mark.parametrize("speed", [-0.5, 0.5, 2.0])
def test_all_wheels_share_one_turning_center(degrees, speed):
    radius = L / math.tan(math.radians(degrees))  # signed, left positive [m]
    wheels = wheel_commands(speed, speed / radius)
    assert wheels.left_steering == pytest.approx(math.atan(L / (radius - HF)), abs=1e-5)
    assert wheels.right_steering == pytest.approx(math.atan(L / (radius + HF)), abs=1e-5)
    yaw_rate = speed / radius
    side = math.copysign(1.0, radius)
    for name, offset, along in (
        ("left_rear", HR, 0.0),
        ("right_rear", -HR, 0.0),
        ("left_front", HF, L),
        ("right_front", -HF, L),
    ):
        distance = math.hypot(radius - offset, along)
        expected = side * yaw_rate * distance / R
        assert getattr(wheels, name) == pytest.approx(expected, rel=1e-5), name


@pytest.mark.parametrize(
    "speed, yaw_rate, steering",
    [
        (0.0, 0.0, 0.0),
        (0.0, 2.0, 0.0),
        (1.0, 0.0, 0.0),
        (0.5, 0.5, math.atan(L)),
        (-0.5, 0.5, -math.atan(L)),
        (0.5, 100.0, 0.5236),
        (0.5, -100.0, -0.5236),
        (1e-300, 1.0, 0.5236),
    ],
)
def test_bicycle_steering(speed, yaw_rate, steering):
    assert bicycle_steering(speed, yaw_rate, Geometry()) == pytest.approx(steering, abs=1e-12)


def test_straight_ahead_all_wheels_have_one_speed():
    wheels = wheel_commands(0.3, 0.0)
    assert wheels.left_steering == wheels.right_steering == 0.0
    assert [
        wheels.left_rear,
        wheels.right_rear,
        wheels.left_front,
        wheels.right_front,
    ] == pytest.approx([10.0] * 4)


def test_inner_wheel_steers_more_and_turns_slower():
    wheels = wheel_commands(0.5, 1.0)
    assert wheels.left_steering > wheels.right_steering > 0.0
    assert wheels.left_rear < wheels.right_rear
    assert wheels.left_front < wheels.right_front


@pytest.mark.parametrize(
    "key, value",
    [
        ("wheelbase", 0.0),
        ("wheel_radius", -0.03),
        ("front_half_track", math.nan),
        ("max_steering", 1.3),
        ("max_steering", 0.0),
    ],
)
def test_invalid_geometry_names_the_value(key, value):
    with pytest.raises(ValueError, match=f"{key} is {value}"):
        Geometry(**{key: value})

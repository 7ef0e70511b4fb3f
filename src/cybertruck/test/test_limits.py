"""Limits of the teleops: speed, turning, rates, the trailer's circle."""

import math

import pytest
from cybertruck.teleop.limits import Limits, RateLimiter

FREE = {"max_acceleration": 0.0, "max_steering_rate": 0.0}


@pytest.mark.parametrize(
    "target, expected",
    [
        ((0.5, 0.5), (0.5, 0.5)),
        ((5.0, 0.0), (3.0, 0.0)),
        ((-5.0, 0.0), (-3.0, 0.0)),
        ((3.0, 9.0), (3.0, 3.0)),  # max_angular
        ((0.5, 2.0), (0.5, 0.5 * math.tan(0.7854) / 0.508)),  # full lock
        ((-0.5, 2.0), (-0.5, 0.5 * math.tan(0.7854) / 0.508)),
        ((0.0, 1.0), (0.0, 0.0)),
    ],
)
def test_clip(target, expected):
    assert Limits().clip(*target) == pytest.approx(expected)


@pytest.mark.parametrize("angle", [30.0, 45.0, 60.0, 80.0])
def test_trailer_limit_keeps_the_hitch_angle(angle):
    limits = Limits(trailer=True, max_hitch_angle=math.radians(angle))
    linear, angular = limits.clip(0.5, 3.0)
    radius = linear / angular
    # steady towing: the hitch runs on sqrt(R² + L1²), the tongue is tangent to the trailer's circle
    hitch = math.atan2(0.30, radius) + math.asin(0.70 / math.hypot(radius, 0.30))
    assert hitch == pytest.approx(math.radians(angle))
    assert math.hypot(radius, 0.30) > 0.70


def test_speed_rises_at_the_acceleration_and_falls_at_once():
    limiter = RateLimiter(Limits(max_acceleration=2.0, max_steering_rate=0.0))
    assert [limiter.step(0.5, 0.0, 0.05)[0] for _ in range(6)] == pytest.approx(
        [0.1, 0.2, 0.3, 0.4, 0.5, 0.5]
    )
    assert limiter.step(0.2, 0.0, 0.05)[0] == pytest.approx(0.2)
    assert limiter.step(-0.5, 0.0, 0.05)[0] == pytest.approx(-0.1)
    assert limiter.step(0.0, 0.0, 0.05) == (0.0, 0.0)


def test_steering_moves_at_its_rate():
    limiter = RateLimiter(Limits(max_acceleration=0.0, max_steering_rate=2.0))
    for count in range(1, 5):
        linear, angular = limiter.step(1.0, 5.0, 0.05)
        assert math.atan(angular / linear * 0.508) == pytest.approx(0.1 * count)


def test_no_rates():
    assert RateLimiter(Limits(**FREE)).step(0.5, -0.4, 0.0) == pytest.approx((0.5, -0.4))


@pytest.mark.parametrize(
    "settings, words",
    [
        ({"max_speed": 0.0}, "max_speed is 0.0; it must be above 0"),
        ({"max_acceleration": -1.0}, "0 or more"),
        ({"max_steering": 1.6}, "below 1.571"),
        ({"trailer": "yes"}, "true or false"),
        ({"wheelbase": float("nan")}, "wheelbase is nan"),
        ({"max_angular": True}, "max_angular is True"),
    ],
)
def test_bad_limits(settings, words):
    with pytest.raises(ValueError, match=words):
        Limits(**settings)

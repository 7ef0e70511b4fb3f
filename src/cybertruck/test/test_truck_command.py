"""Commands: time-out, rate limits, pads."""

import math

import pytest
from cybertruck.drive.commands import Command, JoyDrive, refusal
from cybertruck.drive.model import RateLimiter, TruckGeometry
from paddock_common.settings import read

SHAPE = TruckGeometry()


def test_without_a_command_it_is_at_rest():
    assert Command(0.5).target(3.0) == (0.0, 0.0, False)


def test_a_command_holds_for_its_time_and_ends_once():
    command = Command(0.5)
    command.set(0.3, 1.0, 10.0)
    assert command.target(10.0) == (0.3, 1.0, False)
    assert command.target(10.5) == (0.3, 1.0, False)
    assert command.target(10.508) == (0.3, 0.0, True)
    assert command.target(10.516) == (0.3, 0.0, False)  # the wheels stay where they stand
    command.set(-0.1, -0.5, 11.0)
    assert command.target(11.1) == (-0.1, -0.5, False)


def test_a_command_from_before_the_clock_went_back_ends():
    command = Command(0.5)
    command.set(0.3, 1.0, 100.0)
    assert command.target(99.6) == (0.3, 1.0, False)  # joint states lag behind the clock
    assert command.target(0.1) == (0.3, 0.0, True)
    assert command.target(100.1) == (0.3, 0.0, False)


def test_stop_keeps_the_steering():
    command = Command(0.5)
    command.set(0.3, 1.0, 10.0)
    command.stop()
    assert command.target(10.1) == (0.3, 0.0, False)


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan"), float("inf"), "1", True, None])
def test_wrong_timeout(timeout):
    with pytest.raises(ValueError, match="command_timeout"):
        Command(timeout)


def test_refusal_names_the_number():
    assert refusal(speed=1.0, steering_angle=-0.2) == ""
    assert "steering_angle is nan" in refusal(steering_angle=math.nan, speed=1.0)
    assert "linear.x is inf" in refusal(**{"linear.x": math.inf})


def test_rates():
    limiter = RateLimiter(SHAPE)
    steering, speed = limiter.advance(0.5, 1.0, 0.1)
    assert (steering, speed) == pytest.approx((0.25, 0.2))
    for _ in range(10):
        steering, speed = limiter.advance(0.5, 1.0, 0.1)
    assert (steering, speed) == (0.5, 1.0)
    assert limiter.advance(-0.5, -1.0, 0.0) == (0.5, 1.0)
    assert limiter.advance(-0.5, -1.0, 0.1) == pytest.approx((0.25, 0.8))
    limiter.reset()
    assert (limiter.steering, limiter.speed) == (0.0, 0.0)


@pytest.mark.parametrize(
    "axes, steering, speed",
    [((0.0, 0.0), 0.0, 0.0), ((1.0, 0.5), 0.7854, 0.5), ((-0.5, -1.0, 0.3), -0.3927, -1.0)],
)
def test_pad(axes, steering, speed):
    assert JoyDrive().command(axes) == pytest.approx((steering, speed))


def test_pad_maps_and_signs():
    values = {"joy_speed_axis": 4, "joy_steering_axis": 3, "joy_speed": -2.0}
    pad = read(JoyDrive, values.get, prefix="joy_")
    assert pad.command((9.0, 9.0, 9.0, 1.0, 0.5)) == pytest.approx((0.7854, -1.0))


@pytest.mark.parametrize(
    "axes, word", [((0.0,), "1 axes"), ((0.0, math.nan), "nan"), ((), "0 axes")]
)
def test_pad_refuses(axes, word):
    with pytest.raises(ValueError, match=word):
        JoyDrive().command(axes)


@pytest.mark.parametrize(
    "values",
    [{"speed_axis": -1}, {"steering_axis": 1.5}, {"speed": math.inf}, {"steering": "left"}],
)
def test_wrong_pad_parameters(values):
    with pytest.raises(ValueError, match="joy_" + next(iter(values))):
        JoyDrive(**values)

"""The joystick's speed scale."""

import pytest
from velocity_mux.relay import Turbo

FOUR = {
    "linear_forward_min": 0.5,
    "linear_forward_max": 2.0,
    "linear_backward_min": 0.25,
    "linear_backward_max": 0.25,
    "angular_min": 0.6,
    "angular_max": 1.2,
    "steps": 4,
}


def test_one_to_one_without_parameters():
    assert Turbo({}).scale(1.0, -0.5, 0.25) == (1.0, -0.5, 0.25)


def test_starts_at_the_middle_step_and_takes_equal_steps():
    turbo, seen = Turbo(FOUR), []
    for _ in range(4):
        seen.append(turbo.scale(1.0, 0.0, 1.0)[::2])
        turbo.change(1)
    assert [speed for speed, _ in seen] == pytest.approx([1.0, 1.5, 2.0, 2.0])
    assert [turn for _, turn in seen] == pytest.approx([0.8, 1.0, 1.2, 1.2])
    turbo.reset()
    assert (turbo.step, turbo.angular_step) == (2, 2)


def test_backwards_has_a_range_of_its_own():
    assert Turbo(FOUR).scale(-1.0, 0.0, 0.0)[0] == -0.25
    assert Turbo({**FOUR, "linear_backward_min": 1.0, "linear_backward_max": 1.0}).scale(
        -1.0, 0.0, 0.0
    ) == (-1.0, 0.0, 0.0)


def test_turning_alone():
    turbo = Turbo(FOUR)
    for _ in range(5):
        turbo.change_angular(-1)
    assert turbo.scale(1.0, 0.0, -1.0) == pytest.approx((1.0, 0.0, -0.6))


def test_a_first_step_out_of_range_is_the_middle():
    assert Turbo({**FOUR, "init_step": 9}).step == 2
    assert Turbo({**FOUR, "init_step": 4}).step == 4


@pytest.mark.parametrize("value", [0, -1.0, "fast", True, float("nan")])
def test_wrong_speeds_are_named(value):
    with pytest.raises(ValueError, match="turbo/angular_max is"):
        Turbo({**FOUR, "angular_max": value})


def test_commands_out_of_range_are_refused():
    with pytest.raises(ValueError, match="linear.x is 1.5"):
        Turbo({}).scale(1.5, 0.0, 0.0)
    with pytest.raises(ValueError, match="angular.z is nan"):
        Turbo({}).scale(0.0, 0.0, float("nan"))

"""Axes, scales, deadman and turbo; every configuration that comes along."""

import glob
import os

import pytest
import yaml
from twist_joy.node import STILL, Deadman, read

CONFIG = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "config")
AXES = [0.3, 0.4, 0.5, -0.6, 0.7, -0.8]


def pressed(*numbers):
    return [int(index in numbers) for index in range(16)]


def test_the_defaults():
    deadman = Deadman(read({}))
    assert deadman.command(AXES, pressed(0)) == pytest.approx((0.2, 0, 0, 0, 0, 0.15))


def test_numbers():
    parameters = {
        "axis_linear": 1,
        "scale_linear": 2.0,
        "scale_linear_turbo": 5.0,
        "axis_angular": 0,
        "scale_angular": 4.0,
        "enable_button": 0,
        "enable_turbo_button": 1,
    }
    deadman = Deadman(read(parameters))
    assert deadman.command(AXES, pressed(0)) == pytest.approx((0.8, 0, 0, 0, 0, 1.2))
    assert deadman.command(AXES, pressed(1)) == pytest.approx((2.0, 0, 0, 0, 0, 1.2))
    assert deadman.command(AXES, pressed(0, 1)) == pytest.approx((2.0, 0, 0, 0, 0, 1.2))
    deadman = Deadman(read({**parameters, "scale_angular_turbo": 6.0}))
    assert deadman.command(AXES, pressed(1))[5] == pytest.approx(1.8)


def test_maps_of_six_axes():
    deadman = Deadman(
        read(
            {
                "axis_linear": {"x": 0, "y": 1, "z": 2},
                "scale_linear": {"x": 1.0, "y": 2.0, "z": 3.0},
                "scale_linear_turbo": {"x": 4.0},
                "axis_angular": {"roll": 3, "pitch": 4, "yaw": 5},
                "scale_angular": {"roll": 1, "pitch": 2, "yaw": 3},
                "enable_turbo_button": 1,
            }
        )
    )
    assert deadman.command(AXES, pressed(0)) == pytest.approx((0.3, 0.8, 1.5, -0.6, 1.4, -2.4))
    assert deadman.command(AXES, pressed(1)) == pytest.approx((1.2, 0, 0, 0, 0, 0))


def test_one_zero_when_the_button_is_let_go():
    deadman, sent = Deadman(read({"enable_button": 2})), []
    for buttons in ((), (), (2,), (2,), (), (), (2,), ()):
        sent.append(deadman.command(AXES, pressed(*buttons)))
    drives = (0.2, 0.0, 0.0, 0.0, 0.0, 0.15)
    assert sent == [STILL, None, drives, drives, STILL, None, drives, STILL]


def test_a_pad_with_fewer_axes_and_buttons_drives_nothing():
    deadman = Deadman(read({"axis_linear": 7, "enable_turbo_button": 9}))
    assert deadman.command([0.5], [1]) == pytest.approx((0, 0, 0, 0, 0, 0.25))
    assert deadman.command([], []) == STILL


def test_no_turbo_button_is_no_button():
    deadman = Deadman(read({"enable_turbo_button": -1}))
    assert deadman.command(AXES, [0, 0, 1]) == STILL


@pytest.mark.parametrize(
    "parameters, words",
    [
        ({"axis_linear": "left"}, "axis_linear is 'left'"),
        ({"axis_linear": 1.5}, "axis_linear is 1.5, must be a whole number"),
        ({"axis_angular": {"up": 1}}, "axis_angular names up, must be of roll, pitch, yaw"),
        ({"axis_linear": {"x": 1}, "scale_linear": 0.5}, "scale_linear is 0.5, must be a map"),
        ({"axis_linear": {"x": 1}, "scale_linear": {"x": "fast"}}, "scale_linear/x is 'fast'"),
        ({"scale_angular": True}, "scale_angular is True"),
        ({"enable_button": None}, "enable_button is None"),
    ],
)
def test_wrong_parameters_are_named(parameters, words):
    with pytest.raises(ValueError, match=words):
        read(parameters)


@pytest.mark.parametrize("path", sorted(glob.glob(os.path.join(CONFIG, "*.yaml"))))
def test_configurations_drive(path):
    with open(path, encoding="utf-8") as stream:
        parameters = yaml.safe_load(stream)
    mapping = read(parameters)
    assert mapping.axes["x"].scale > 0.0 and mapping.axes["yaw"].scale > 0.0
    assert mapping.turbo_button >= 0
    full = [1.0] * 8
    velocity = Deadman(mapping).command(full, pressed(mapping.enable_button))
    assert velocity[0] == mapping.axes["x"].scale and velocity[5] == mapping.axes["yaw"].scale


def test_the_usual_configurations_are_there():
    names = {os.path.basename(path) for path in glob.glob(os.path.join(CONFIG, "*"))}
    usual = ("atk3", "joy-con-r", "ps3", "ps3-holonomic", "xbox", "xd3")
    assert names == {f"{name}.config.yaml" for name in usual}

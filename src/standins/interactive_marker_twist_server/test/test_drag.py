"""How far the marker was dragged, as a velocity; every configuration that comes along."""

import glob
import os

import pytest
import yaml
from marker_twist.node import read
from paddock_common.geometry import quaternion_of

CONFIG = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "config")
AHEAD = quaternion_of(0.0)


def test_the_defaults_drive_ahead_and_turn():
    drag = read({})
    assert drag.velocity((0.4, 0.3, 0.2), quaternion_of(0.5)) == (
        (0.4, 0.0, 0.0),
        pytest.approx(1.1),
    )


@pytest.mark.parametrize(
    "displacement, speed", [(2.0, 1.0), (-2.0, -0.5), (0.1, 0.2), (-0.1, -0.2)]
)
def test_scale_and_limits(displacement, speed):
    drag = read(
        {
            "linear_scale": 2,
            "max_positive_linear_velocity": 1,
            "max_negative_linear_velocity": -0.5,
        }
    )
    assert drag.velocity((displacement, 0.0, 0.0), AHEAD)[0][0] == pytest.approx(speed)


@pytest.mark.parametrize("angle, rate", [(3.0, 1.5), (-3.0, -1.5), (0.2, 0.6)])
def test_turning(angle, rate):
    drag = read({"angular_scale": 3.0, "max_angular_velocity": 1.5})
    assert drag.velocity((0.0, 0.0, 0.0), quaternion_of(angle))[1] == pytest.approx(rate)


def test_maps():
    drag = read(
        {
            "linear_scale": {"x": 1, "z": 2},
            "max_positive_linear_velocity": {"x": 0.5, "z": 9},
            "max_negative_linear_velocity": {"x": -0.5},
        }
    )
    assert drag.velocity((1.0, 1.0, 1.0), AHEAD)[0] == (0.5, 0.0, 2.0)
    assert drag.velocity((-1.0, -1.0, -1.0), AHEAD)[0] == (-0.5, 0.0, 0.0)


@pytest.mark.parametrize(
    "parameters, words",
    [
        ({"linear_scale": "fast"}, "linear_scale is 'fast'"),
        ({"linear_scale": {"up": 1}}, "linear_scale names up"),
        (
            {"linear_scale": {"x": 1}, "max_positive_linear_velocity": 1},
            "max_positive_linear_velocity is 1, must be a map",
        ),
        ({"max_angular_velocity": True}, "max_angular_velocity is True"),
    ],
)
def test_wrong_parameters_are_named(parameters, words):
    with pytest.raises(ValueError, match=words):
        read(parameters)


@pytest.mark.parametrize("name, axes", [("linear", "x"), ("planar", "xy"), ("aerial", "xyz")])
def test_configurations(name, axes):
    with open(os.path.join(CONFIG, f"{name}.yaml"), encoding="utf-8") as stream:
        drag = read(yaml.safe_load(stream))
    assert sorted(drag.linear) == list(axes)
    assert all(scale.lowest == -1.0 and scale.highest == 1.0 for scale in drag.linear.values())


def test_the_usual_configurations_are_there():
    names = {os.path.basename(path) for path in glob.glob(os.path.join(CONFIG, "*"))}
    assert names == {"linear.yaml", "planar.yaml", "aerial.yaml"}

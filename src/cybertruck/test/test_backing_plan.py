"""Settings of the backing node and goals: valid ones, and errors of invalid ones."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from cybertruck.backing.server import make_tracker, settings_from
from cybertruck.trailer.geometry import TrailerError

SETTINGS = settings_from({})
TRAILER = (0.0, 0.0, 0.0)  # it backs towards -x


def make_goal(points=None, shape="", size=(), speed=0.0, frame="odom"):
    """What has the fields of a BackUpGoal."""
    poses = [
        SimpleNamespace(pose=SimpleNamespace(position=SimpleNamespace(x=x, y=y)))
        for x, y in points or ()
    ]
    return SimpleNamespace(
        path=SimpleNamespace(header=SimpleNamespace(frame_id=frame), poses=poses),
        shape=shape,
        size=list(size),
        speed=speed,
    )


def test_a_shape_is_laid_out_behind_the_trailer():
    tracker = make_tracker(make_goal(shape="line", size=(3.0,)), (1.0, 2.0, math.pi / 2), SETTINGS)
    np.testing.assert_allclose(tracker.path.points[[0, -1]], ((1.0, 2.0), (1.0, -1.0)), atol=1e-12)
    assert tracker.tuning.speed == SETTINGS.tuning.speed


def test_points_and_speed_are_taken():
    tracker = make_tracker(make_goal([(0.5, 0.2), (-5.0, 0.2)], speed=0.5), TRAILER, SETTINGS)
    assert tracker.tuning.speed == 0.5
    assert tracker.path.length == pytest.approx(5.5)
    assert tracker.arc == pytest.approx(0.5)


def test_hold_is_a_shape_without_a_path():
    hold = make_tracker(make_goal(shape="hold", size=(0.4, 5.0)), TRAILER, SETTINGS)
    assert hold.path is None
    assert (hold.target_curvature, hold.length) == (-0.4, 5.0)


@pytest.mark.parametrize(
    "goal, word",
    (
        (make_goal(shape="hold"), "0 numbers"),
        (make_goal(shape="hold", size=(3.0, 5.0)), "3 1/m"),
        (make_goal(), "neither"),
        (make_goal([(0.0, 0.0), (-1.0, 0.0)], shape="line"), "both"),
        (make_goal(shape="loop"), "loop"),
        (make_goal(shape="line", size=(-1.0,)), "-1"),
        (make_goal(shape="line", speed=0.7), "0.7"),
        (make_goal(shape="line", speed=-0.1), "-0.1"),
        (make_goal(shape="line", speed=math.nan), "nan"),
        (make_goal(shape="arc", size=(0.4,)), "0.40 m"),
        (make_goal([(0.0, 0.0), (-1.0, 0.0)], frame="map"), "map"),
        (make_goal([(0.0, 0.0), (math.inf, 0.0)]), "point 1"),
        (make_goal([(0.0, 0.0)]), "1 different"),
        (make_goal([(-9.0, 0.0), (-12.0, 0.0)]), "9.0 m"),
        (make_goal([(0.0, 0.0), (2.0, 0.0)]), "180 degrees"),
        (make_goal([(3.0, 0.0), (1.0, 0.0)]), "end already"),
    ),
)
def test_bad_goals_are_refused(goal, word):
    with pytest.raises(TrailerError) as caught:
        make_tracker(goal, TRAILER, SETTINGS)
    assert word in str(caught.value)


@pytest.mark.parametrize(
    "parameters, word",
    (
        ({"wheelbase": -1.0}, "wheelbase"),
        ({"tuning": {"speed": 0.9}}, "0.9"),
        ({"tuning": {"spede": 0.3}}, "spede"),
        ({"tuning": 3}, "tuning is 3"),
        ({"node": {"control_period": 0.0}}, "control_period"),
        ({"node": {"odom_frame": ""}}, "odom_frame"),
        ({"node": {"steering_map": "/nowhere.yaml"}}, "/nowhere.yaml"),
    ),
)
def test_bad_parameters_are_refused(parameters, word):
    with pytest.raises(TrailerError) as caught:
        settings_from(parameters)
    assert word in str(caught.value)


def test_the_shipped_parameters_are_good():
    from pathlib import Path

    import yaml

    config = Path(__file__).resolve().parents[1] / "config"
    parameters = {
        **yaml.safe_load((config / "truck.yaml").read_text()),
        **yaml.safe_load((config / "backing.yaml").read_text()),
    }
    settings = settings_from(parameters)
    assert settings.geometry.tongue_length == parameters["tongue_length"]
    assert set(parameters["tuning"]) == set(settings.tuning.__dataclass_fields__)
    assert set(parameters["node"]) == set(settings.node.__dataclass_fields__)

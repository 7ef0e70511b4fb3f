"""The steering map's drive: settings, and from poses to a curvature."""

import math

import numpy as np
import pytest
from cybertruck.backing.steering_map import MapSettings, measure, write_figure
from cybertruck.trailer.geometry import TrailerError
from cybertruck.trailer.steering import MeasuredSteering


def circle_poses(curvature, length, count=100, noise=0.0):
    """Poses (n, 3) on a circle through the origin, along +x at first [m, m, rad]."""
    arc = np.linspace(0.0, length, count)
    turn = curvature * arc
    points = np.column_stack((np.sin(turn) / curvature, (1.0 - np.cos(turn)) / curvature))
    points += noise * np.random.default_rng(4).standard_normal(points.shape)
    return np.column_stack((points, np.arctan2(np.sin(turn), np.cos(turn))))


@pytest.mark.parametrize("curvature", (-1.9, -0.2, 0.5))
def test_poses_on_a_circle(curvature):
    item = measure(0.3, circle_poses(curvature, 3.0, noise=0.0005))
    assert item.curvature == pytest.approx(curvature, rel=0.01)
    assert item.rms < 0.001


def test_straight_poses():
    poses = np.column_stack((np.linspace(0.0, 3.0, 50), np.zeros(50), np.linspace(0.0, 0.03, 50)))
    assert measure(0.0, poses).curvature == pytest.approx(0.01)


@pytest.mark.parametrize(
    "poses, word",
    (
        (circle_poses(0.5, 3.0, count=5), "5 points"),
        (circle_poses(0.5, 3.0, noise=0.3), "off a circle"),
        (np.zeros((0, 3)), "0 points"),
    ),
)
def test_bad_poses_are_refused(poses, word):
    with pytest.raises(TrailerError, match=word):
        measure(0.3, poses)


@pytest.mark.parametrize(
    "field, value, word",
    (
        ("angles", (0.0, 0.1), "3 or more"),
        ("angles", (0.0, 0.2, 0.1), "above the one before"),
        ("angles", (0.0, 0.2, 2.0), "2.0"),
        ("check_angles", (math.nan,), "nan"),
        ("speed", 0.7, "0.7"),
        ("longest", 0.0, "longest"),
        ("circle", -1.0, "circle"),
    ),
)
def test_bad_settings_are_refused(field, value, word):
    with pytest.raises(TrailerError, match=word):
        MapSettings(**{field: value})


def test_distance_is_a_share_of_a_circle_or_the_longest():
    settings = MapSettings()
    assert settings.distance(math.radians(45.0), 0.508) == pytest.approx(0.75 * math.tau * 0.508)
    assert settings.distance(0.0, 0.508) == settings.longest


def test_check_angles_are_not_used_for_the_map():
    settings = MapSettings()
    assert not set(settings.angles) & set(settings.check_angles)


def test_figure(tmp_path):
    angles = np.radians(np.arange(-45.0, 46.0, 15.0))
    items = [
        measure(angle, circle_poses(math.tan(angle) / 0.508, 2.0))
        if abs(angle) > 0.1
        else measure(0.0, np.column_stack((np.arange(30.0), np.zeros(30), np.zeros(30))))
        for angle in angles
    ]
    steering = MeasuredSteering(angles, [item.curvature for item in items])
    write_figure(tmp_path / "map.png", items, items[1:2], steering, 0.508)
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")

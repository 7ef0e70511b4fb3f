"""Circle fits, and the steering map: monotone, invertible, limited, written and read."""

import math

import numpy as np
import pytest
from cybertruck.backing.steering_map import fit_circle
from cybertruck.trailer.geometry import TrailerError
from cybertruck.trailer.steering import (
    IdealSteering,
    MeasuredSteering,
    parse_map,
    read_map,
    write_map,
)

ANGLES = np.radians(np.arange(-45.0, 46.0, 7.5))
CURVATURES = np.tan(ANGLES) / 0.508 * 0.95 + 0.01


def circle_points(radius, center, turn, span, noise=0.0):
    """Points of a circle in driving order, to the left for turn = 1, with seeded noise [m]."""
    angles = 0.4 + turn * np.linspace(0.0, span, 80)
    points = np.array(center) + radius * np.column_stack((np.cos(angles), np.sin(angles)))
    return points + noise * np.random.default_rng(1).standard_normal(points.shape)


@pytest.mark.parametrize("turn", (1, -1))
@pytest.mark.parametrize("radius, span", ((0.5, 6.0), (4.0, 1.0), (60.0, 0.1)))
def test_exact_circles(radius, span, turn):
    center, curvature, rms = fit_circle(circle_points(radius, (2.0, -1.0), turn, span))
    np.testing.assert_allclose(center, (2.0, -1.0), atol=1e-5 * radius)
    assert curvature == pytest.approx(turn / radius, rel=1e-5)
    assert rms < 1e-6


def test_noise_does_not_bias_a_half_circle():
    _, curvature, rms = fit_circle(circle_points(1.0, (0.0, 0.0), 1, math.pi, 0.01))
    assert curvature == pytest.approx(1.0, abs=0.01)
    assert rms == pytest.approx(0.01, rel=0.2)


@pytest.mark.parametrize(
    "points, word",
    (
        (np.zeros((2, 2)), "shape"),
        (np.zeros((5, 3)), "shape"),
        (np.column_stack((np.arange(9.0), np.arange(9.0))), "line"),
    ),
)
def test_no_circle(points, word):
    with pytest.raises(TrailerError, match=word):
        fit_circle(points)


def test_ideal_steering_and_its_inverse():
    steering = IdealSteering(0.508, 0.7854)
    angles = np.linspace(-0.78, 0.78, 21)
    np.testing.assert_allclose(steering.curvature(angles), np.tan(angles) / 0.508)
    np.testing.assert_allclose(steering.steering(steering.curvature(angles)), angles)
    assert steering.steering(99.0) == 0.7854


def test_measured_steering_is_monotone_goes_through_its_points_and_inverts():
    steering = MeasuredSteering(ANGLES, CURVATURES)
    np.testing.assert_allclose(steering.curvature(ANGLES), CURVATURES, atol=1e-12)
    fine = np.linspace(steering.lowest, steering.highest, 2001)
    curvatures = steering.curvature(fine)
    assert np.all(np.diff(curvatures) > 0.0)
    np.testing.assert_allclose(steering.steering(curvatures), fine, atol=1e-9)
    np.testing.assert_allclose(curvatures, np.tan(fine) / 0.508 * 0.95 + 0.01, atol=0.02)


def test_a_step_does_not_overshoot():
    steering = MeasuredSteering((-1.0, 0.0, 0.1, 1.0), (-1.0, -0.9, 0.9, 1.0))
    assert np.all(np.diff(steering.curvature(np.linspace(-1.0, 1.0, 999))) > 0.0)


def test_past_its_ends_the_map_is_limited():
    steering = MeasuredSteering(ANGLES, CURVATURES, extrapolation=0.02)
    edge = math.radians(45.0) + 0.02
    assert steering.max_steering == pytest.approx(edge)
    assert steering.curvature(edge) > CURVATURES[-1]
    assert steering.curvature(2.0) == steering.curvature(edge)
    assert steering.steering(50.0) == pytest.approx(edge, abs=1e-12)
    assert steering.steering(-50.0) == pytest.approx(-edge, abs=1e-12)


def test_written_map_is_read_back(tmp_path):
    file = tmp_path / "map.yaml"
    write_map(file, ANGLES, CURVATURES, ("a note",))
    assert file.read_text().startswith("# a note\n")
    steering = read_map(file)
    np.testing.assert_allclose(steering.angles, ANGLES, atol=1e-6)
    np.testing.assert_allclose(steering.curvatures, CURVATURES, atol=1e-6)


@pytest.mark.parametrize(
    "data, word",
    (
        (None, "lists"),
        ({"angles": [1.0]}, "lists"),
        ({"angles": [0, 1], "curvatures": [0, 1]}, "3 or more"),
        ({"angles": [0, 1, 1], "curvatures": [0, 1, 2]}, "1 is followed by 1"),
        ({"angles": [-1, 0, 1], "curvatures": [0, 2, 1]}, "2 is followed by 1"),
        ({"angles": [-1, 0, 1], "curvatures": [0, 1, math.nan]}, "finite"),
        ({"angles": ["a", 0, 1], "curvatures": [0, 1, 2]}, "a"),
        ({"angles": [-1, 0, 1], "curvatures": [0, 1, 2], "extra": 1}, "unknown extra"),
        ({"angles": [1, 2, 3], "curvatures": [1, 2, 3]}, "both sides"),
        ({"angles": [-1, 0, 1], "curvatures": [0, 1, 2], "extrapolation": -1}, "extrapolation"),
    ),
)
def test_bad_maps_are_refused(data, word):
    with pytest.raises(TrailerError, match=word):
        parse_map(data)


def test_missing_file_and_bad_yaml_are_refused(tmp_path):
    with pytest.raises(TrailerError, match="none.yaml"):
        read_map(tmp_path / "none.yaml")
    (tmp_path / "bad.yaml").write_text("angles: [1, 2")
    with pytest.raises(TrailerError, match="bad.yaml"):
        read_map(tmp_path / "bad.yaml")

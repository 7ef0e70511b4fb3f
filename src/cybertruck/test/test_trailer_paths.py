"""Paths against closed forms, named shapes, and the projection."""

import math

import numpy as np
import pytest
from cybertruck.trailer.geometry import TrailerError
from cybertruck.trailer.paths import from_curvature, from_points
from cybertruck.trailer.shapes import SHAPES, make_shape


def test_line():
    path = make_shape("line", (4.0,))
    x, y, heading, curvature = path.sample(np.array((-1.0, 0.0, 2.5, 6.0)))
    np.testing.assert_allclose(x, (-1.0, 0.0, 2.5, 6.0), atol=1e-12)
    assert not np.any(y) and not np.any(heading) and not np.any(curvature)


def test_circle_of_constant_curvature():
    path = from_curvature(lambda arc: np.full_like(arc, -0.5), 3.0)
    arc = np.linspace(0.0, 3.0, 97)
    x, y, heading, curvature = path.sample(arc)
    np.testing.assert_allclose(np.hypot(x, y + 2.0), 2.0, atol=1e-6)
    np.testing.assert_allclose(heading, -arc / 2.0, atol=1e-12)
    np.testing.assert_allclose(curvature, -0.5)


def test_clothoid_equals_fresnel_integrals():
    from scipy.special import fresnel

    path = from_curvature(lambda arc: math.pi * arc, 1.2)  # C(s), S(s) by definition
    sine, cosine = fresnel(path.arc)
    np.testing.assert_allclose(path.points, np.column_stack((cosine, sine)), atol=1e-9)


@pytest.mark.parametrize(
    "name, size, end, heading",
    (
        ("line", (3.0,), (3.0, 0.0), 0.0),
        ("s", (1.0, 6.0), (6.0, 1.0), 0.0),
        ("s", (-2.5, 6.0), (6.0, -2.5), 0.0),
        ("lane-change", (1.5, 5.0, 2.0), (9.0, 1.5), 0.0),
        ("park", (-1.2, 4.0, 2.0), (6.2, -1.2), 0.0),
    ),
)
def test_ends_of_shapes(name, size, end, heading):
    path = make_shape(name, size)
    np.testing.assert_allclose(path.points[-1], end, atol=1e-7)
    assert path.headings[-1] == pytest.approx(heading, abs=1e-7)


@pytest.mark.parametrize("radius", (3.0, -2.0))
def test_arc_has_its_radius_and_its_angle(radius):
    path = make_shape("arc", (radius, math.pi))
    assert path.headings[-1] == pytest.approx(math.copysign(math.pi, radius), abs=1e-7)
    assert np.max(np.abs(path.curvatures)) == pytest.approx(1.0 / abs(radius), rel=1e-9)


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_smooth(name):
    path = make_shape(name)
    steps = np.hypot(*np.diff(path.points, axis=0).T)
    np.testing.assert_allclose(steps, path.arc[1], rtol=1e-4)
    turn = np.diff(path.headings)
    np.testing.assert_allclose(
        turn, path.arc[1] * 0.5 * (path.curvatures[1:] + path.curvatures[:-1]), atol=1e-5
    )
    assert np.max(np.abs(np.diff(path.curvatures))) < 0.02  # no jump of the steering
    assert path.curvatures[0] == path.curvatures[-1] == 0.0


def test_projection_and_errors_are_inverse_to_laying_off():
    path = make_shape("s", (2.0, 6.0))
    random = np.random.default_rng(2)
    arc = random.uniform(-1.0, path.length + 1.0, 200)
    left = random.uniform(-0.8, 0.8, 200)
    x, y, heading, _ = path.sample(arc)
    x, y = x - left * np.sin(heading), y + left * np.cos(heading)
    nearest = path.nearest(x, y, arc + random.uniform(-0.2, 0.2, 200))
    np.testing.assert_allclose(nearest, arc, atol=1e-4)
    lateral, turn = path.errors(x, y, heading + 0.3, nearest)
    np.testing.assert_allclose(lateral, left, atol=1e-4)
    np.testing.assert_allclose(turn, 0.3, atol=1e-4)
    assert path.first_nearest(x[7], y[7]) == pytest.approx(arc[7], abs=1e-4)


def test_nearest_place_near_the_start_of_a_closed_path():
    path = make_shape("arc", (2.0, 2.0 * math.pi))
    assert path.first_nearest(0.3, 0.0, 3.0) == pytest.approx(0.3, abs=0.01)


def test_heading_error_is_wrapped():
    path = make_shape("line", (3.0,))
    assert path.errors(0.0, 0.0, 2.0 * math.pi + 0.1, 0.0)[1] == pytest.approx(0.1)
    assert path.errors(0.0, 0.0, -math.pi - 0.1, 0.0)[1] == pytest.approx(math.pi - 0.1)


def test_moved_keeps_shape_and_moves_poses():
    path = make_shape("s", (2.0, 6.0))
    moved = path.moved(1.0, 2.0, math.pi / 2)
    np.testing.assert_allclose(moved.points[:, 0], 1.0 - path.points[:, 1], atol=1e-12)
    np.testing.assert_allclose(moved.points[:, 1], 2.0 + path.points[:, 0], atol=1e-12)
    np.testing.assert_allclose(moved.curvatures, path.curvatures)


def test_spline_through_points_of_a_circle():
    angles = np.linspace(0.0, math.pi, 60)
    path = from_points(2.5 * np.column_stack((np.cos(angles), np.sin(angles))))
    assert path.length == pytest.approx(2.5 * math.pi, rel=1e-4)
    np.testing.assert_allclose(np.hypot(*path.points.T), 2.5, rtol=1e-4)
    np.testing.assert_allclose(path.curvatures, 0.4, rtol=5e-3)
    assert path.headings[0] == pytest.approx(math.pi / 2, abs=1e-3)


def test_two_points_make_a_line_and_repeated_points_are_taken_once():
    path = from_points([(1.0, 1.0), (1.0, 1.0), (1.0, 3.0), (1.0, 3.0)])
    assert path.length == pytest.approx(2.0)
    assert path.headings[0] == pytest.approx(math.pi / 2)
    np.testing.assert_allclose(path.points[-1], (1.0, 3.0), atol=1e-12)


@pytest.mark.parametrize(
    "points, word",
    (
        ([], "shape"),
        ([(1.0, 1.0)], "1 different"),
        ([(0.0, 0.0), (0.0, 0.0)], "1 different"),
        ([(0.0, 0.0), (math.nan, 1.0)], "point 1"),
        ([(0.0, 0.0), (2000.0, 0.0)], "at most"),
    ),
)
def test_bad_points_are_refused(points, word):
    with pytest.raises(TrailerError, match=word):
        from_points(points)


@pytest.mark.parametrize(
    "name, size, words",
    (
        ("circle", (), ("circle", "lane-change")),
        ("line", (0.0,), ("line: length", "above 0")),
        ("line", (1.0, 2.0), ("2 numbers",)),
        ("line", (math.nan,), ("nan", "finite")),
        ("line", (1e6,), ("1e+06",)),
        ("arc", (0.0, 1.0), ("radius",)),
        ("arc", (3.0, -1.0), ("angle",)),
        ("s", (9.0, 4.0), ("offset", "3.2")),
        ("park", (1.0, 4.0, -1.0), ("straight", "-1")),
    ),
)
def test_bad_shapes_are_refused(name, size, words):
    with pytest.raises(TrailerError) as caught:
        make_shape(name, size)
    for word in words:
        assert word in str(caught.value)

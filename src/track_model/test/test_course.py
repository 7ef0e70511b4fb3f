"""Course against shapely's lines: arc lengths, sides, poses, bends."""

import math

import numpy as np
import pytest
from shapely.geometry import LineString, Point
from track_model.referee.course import WINDOW, Course
from track_model.track import load_track

OPEN = """points: [[0, 0], [1, 0.1], [2, 0.8], [3, 0.9]]
closed: false
width: [0.5, 0.6, 0.8, 0.7]
"""


@pytest.fixture(scope="module", params=["default", "hard", "open"])
def course(request, tmp_path_factory):
    if request.param != "open":
        return Course(load_track(request.param).lane)
    path = tmp_path_factory.mktemp("tracks") / "open.yaml"
    path.write_text(OPEN)
    return Course(load_track(str(path)).lane)


@pytest.fixture(scope="module")
def line(course):
    curve = course.lane.curve
    return LineString([*curve, curve[0]] if course.closed else curve)


def points_around(course, count=200):
    """Points within 0.6 m of the centreline, and their arc lengths before projection."""
    rng = np.random.default_rng(7)
    s = rng.uniform(0.0, course.length, count)
    positions = np.array([course.pose(at)[:2] for at in s])
    return s, positions + rng.uniform(-0.4, 0.4, (count, 2))


@pytest.mark.parametrize("near", [False, True])
def test_arc_length_and_side(course, line, near):
    for s, point in zip(*points_around(course)):
        nearest = line.project(Point(point))
        located, left = course.locate(*point, s if near else None)
        if near and abs(course.difference(nearest, s)) > 0.95 * WINDOW:
            assert abs(course.difference(located, s)) < 1.05 * WINDOW  # no jump to another part
            continue
        x, y, yaw = course.pose(located)
        assert math.copysign(1.0, left) == math.copysign(
            1.0, (point[1] - y) * math.cos(yaw) - (point[0] - x) * math.sin(yaw)
        )
        if course.closed or 0.0 < located < course.length:
            assert course.difference(located, nearest) == pytest.approx(0.0, abs=1e-9)
            assert abs(left) == pytest.approx(line.distance(Point(point)), abs=1e-9)


def test_an_open_course_goes_straight_on_beyond_its_ends(course):
    if course.closed:
        return
    for s, ahead in ((0.0, -0.3), (course.length, 0.4)):
        x, y, yaw = course.pose(s)
        cos, sin = math.cos(yaw), math.sin(yaw)
        point = x + ahead * cos - 0.1 * sin, y + ahead * sin + 0.1 * cos
        for near in (None, s):
            assert course.locate(*point, near) == pytest.approx((s + ahead, 0.1), abs=2e-3)


def test_one_point_is_projected_as_several(course):
    for s, point in zip(*points_around(course)):
        expected = course.locate(*point, s)
        assert course.project_point(*point, s) == pytest.approx(expected, abs=1e-9)


def test_several_points_share_a_window(course):
    s, points = points_around(course, 8)
    near = float(s[0])
    cluster = points[0] + 0.05 * (points - points[0]) / (1.0 + np.abs(points - points[0]))
    result = np.array(course.project(cluster, near)).T
    expected = [course.locate(*point, near) for point in cluster]
    assert result == pytest.approx(np.array(expected), abs=1e-9)


def test_poses(course, line):
    for s in points_around(course)[0]:
        x, y, yaw = course.pose(s)
        on_line = np.array(line.interpolate(s).coords[0])
        assert (x, y) == pytest.approx(on_line, abs=1e-4)  # [m]: chords taken as equal
        before, after = (np.array(line.interpolate(s + ds).coords[0]) for ds in (-0.02, 0.02))
        if 0.02 < s < course.length - 0.02:
            chord = math.atan2(*(after - before)[::-1])
            assert math.remainder(yaw - chord, 2.0 * math.pi) == pytest.approx(0.0, abs=0.02)


def test_the_curvature_is_how_the_heading_changes(course):
    s = np.linspace(0.1, course.length - 0.1, 300)
    turns = [
        math.remainder(course.heading(at + 0.05) - course.heading(at - 0.05), 2.0 * math.pi)
        for at in s
    ]
    assert course.curvature(s) == pytest.approx(np.array(turns) / 0.1, abs=0.02)
    for at in s[::3]:
        assert course.point_curvature(at) == pytest.approx(float(course.curvature(at)), abs=0.05)


def test_sides_are_those_of_the_lane(course):
    lane = course.lane
    k = np.arange(0, len(lane.curve) - 1, 10)
    s = k * course.length / (len(lane.curve) - (not course.closed))
    left, right = course.sides(s)
    assert left == pytest.approx(lane.left[k], abs=1e-6)
    assert right == pytest.approx(lane.right[k], abs=1e-6)

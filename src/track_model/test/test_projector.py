"""The fast projection has the same results as Course."""

import numpy as np
import pytest
from track_model.referee.course import Course, Projector
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


def points_around(course, count=200):
    """Points within 0.6 m of the centreline, and their arc lengths before projection."""
    rng = np.random.default_rng(7)
    s = rng.uniform(-0.2, course.length + 0.2, count)
    positions = np.array([course.pose(at)[:2] for at in s])
    return s, positions + rng.uniform(-0.4, 0.4, (count, 2))


@pytest.mark.parametrize("near", [False, True])
def test_arc_length_and_side_are_those_of_course(course, near):
    fast = Projector(course)
    for s, point in zip(*points_around(course)):
        start = s if near else None
        expected = course.project(*point, near=start)
        result = fast.project(point[None], start)
        assert [float(value[0]) for value in result] == pytest.approx(expected, abs=1e-9)


def test_one_point_is_projected_as_several(course):
    fast = Projector(course)
    for s, point in zip(*points_around(course)):
        expected = fast.project(point[None], s)
        assert fast.project_point(*point, s) == pytest.approx(
            [float(v[0]) for v in expected], abs=1e-9
        )


def test_several_points_share_a_window(course):
    s, points = points_around(course, 8)
    near = float(s[0])
    cluster = points[0] + 0.05 * (points - points[0]) / (1.0 + np.abs(points - points[0]))
    result = np.array(Projector(course).project(cluster, near)).T
    expected = [course.project(*point, near=near) for point in cluster]
    assert result == pytest.approx(np.array(expected), abs=1e-9)


def test_poses_are_those_of_course(course):
    fast = Projector(course)
    for s in points_around(course)[0]:
        expected = course.pose(s)
        result = fast.pose(s)
        assert result[:2] == pytest.approx(expected[:2], abs=1e-4)  # [m]: chords taken as equal
        assert np.angle(np.exp(1j * (result[2] - expected[2]))) == pytest.approx(0.0, abs=1e-3)


def test_curvature_is_that_of_course(course):
    s = np.linspace(0.1, course.length - 0.1, 300)
    expected = np.array([course.curvature(at) for at in s])
    assert Projector(course).curvature(s) == pytest.approx(expected, abs=0.02)


def test_the_bend_is_the_curvature(course):
    fast = Projector(course)
    for s in np.linspace(0.1, course.length - 0.1, 100):
        assert fast.point_curvature(s) == pytest.approx(float(fast.curvature(s)), abs=0.05)


def test_sides_are_those_of_the_lane(course):
    lane = course.lane
    k = np.arange(0, len(lane.curve) - 1, 10)
    s = k * course.length / (len(lane.curve) - (not course.closed))
    left, right = Projector(course).sides(s)
    assert left == pytest.approx(lane.left[k], abs=1e-6)
    assert right == pytest.approx(lane.right[k], abs=1e-6)

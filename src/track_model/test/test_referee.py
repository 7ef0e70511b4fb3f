"""The lap referee: laps, progress and offences of driven poses."""

import numpy as np
import pytest
from shapely.geometry import Point
from shapely.prepared import prep
from track_model.files import writer as files
from track_model.referee.course import Course
from track_model.referee.referee import Car, Referee, Rules, wall_polygons

from track_model import geometry, region, source, track_file

RADIUS = 2.0  # [m]
LAP = 2.0 * np.pi * RADIUS


def circle(extra=""):
    """A track whose centreline is a circle driven counter-clockwise; its center is (0, 2)."""
    at = 2.0 * np.pi * np.arange(36) / 36 - np.pi / 2
    points = np.round(RADIUS * np.transpose([np.cos(at), np.sin(at)]), 6).tolist()
    return track_file.parse(f"points: {points}\n{extra}", "circle.yaml")


@pytest.fixture(scope="module")
def course():
    return Course(geometry.lane(circle()))


def pose_at(angle, offset=0.0):
    """Pose at an angle past the start, offset [m] to the left (towards the center)."""
    r = RADIUS - offset
    return r * np.sin(angle), RADIUS - r * np.cos(angle), angle


def drive(referee, angles, times, offset=0.0, rotation=0.0):
    """Feed poses; returns all events as (time, name)."""
    events = []
    speeds = np.gradient(np.asarray(angles) * (RADIUS - offset), times)
    for angle, time, speed in zip(angles, times, speeds):
        x, y, yaw = pose_at(angle, offset)
        _, new = referee.update(time, x, y, yaw + rotation, speed)
        events += [(time, name) for name in new]
    return events


def test_projection(course):
    for angle in np.linspace(0.01, 6.2, 40):
        for offset in (-0.3, 0.0, 0.35):
            s, left = course.locate(*pose_at(angle, offset)[:2])
            assert s == pytest.approx(RADIUS * angle, abs=2e-3)
            assert left == pytest.approx(offset, abs=2e-4)
    assert course.pose(RADIUS)[:2] == pytest.approx(pose_at(1.0)[:2], abs=1e-3)
    assert course.pose(RADIUS)[2] == pytest.approx(1.0, abs=1e-3)
    assert float(course.curvature(3.0)) == pytest.approx(1.0 / RADIUS, rel=0.01)


@pytest.mark.parametrize("rate", [10.0, 50.0, 123.0])
def test_lap_times_are_exact_between_samples(course, rate):
    """0.31 rad/s from 0.2 rad before the line: crossings at 0.2/0.31 s and one lap later each."""
    referee = Referee(course)
    times = np.arange(0.0, 45.0, 1.0 / rate)
    events = drive(referee, 0.31 * times - 0.2, times)
    assert [name for _, name in events] == ["start", "lap", "lap"]
    lap = 2.0 * np.pi / 0.31
    for (time, _), k in zip(events, range(3)):
        assert 0.0 <= time - (0.2 / 0.31 + k * lap) < 1.0 / rate
    assert referee.status.last_lap_time == pytest.approx(lap, abs=1e-4)
    assert referee.status.best_lap_time == pytest.approx(lap, abs=1e-4)
    assert referee.status.laps == 2
    expected = 100.0 * ((0.31 * times[-1] - 0.2) / (2.0 * np.pi) - 2)
    assert referee.status.progress == pytest.approx(expected, abs=0.5)
    assert referee.status.lap_time == pytest.approx(times[-1] - 0.2 / 0.31 - 2 * lap, abs=1e-4)


def test_standing_start_counts_from_the_first_motion(course):
    referee = Referee(course)
    times = np.arange(0.0, 30.0, 0.02)
    angles = 0.05 + 0.4 * np.clip(times - 3.0, 0.0, None)
    events = drive(referee, angles, times)
    assert [name for _, name in events][:2] == ["start", "lap"]
    assert referee.status.last_lap_time == pytest.approx((2.0 * np.pi - 0.05) / 0.4, abs=0.03)


def test_reversing_over_the_line_is_no_lap(course):
    referee = Referee(course)
    angles = np.concatenate(
        [np.linspace(-0.2, 0.5, 100), np.linspace(0.5, -0.5, 100), np.linspace(-0.5, 0.3, 100)]
    )
    events = drive(referee, angles, np.arange(300) * 0.02)
    assert [name for _, name in events] == ["start", "wrong_way"]
    assert referee.status.laps == 0


def test_cutting_to_a_far_part_is_no_progress(course):
    """A car that is moved elsewhere continues from there; the distance between does not count."""
    referee = Referee(course)
    drive(referee, np.linspace(-0.2, 1.0, 100), np.arange(100) * 0.02)
    distance = referee.status.distance
    drive(referee, np.linspace(5.0, 5.1, 10), 3.0 + np.arange(10) * 0.02)
    assert referee.status.distance - distance == pytest.approx(0.1 * RADIUS, abs=0.03)


def test_wheels_off_and_penalty(course):
    half = 0.38
    for offset, wheels in (
        (0.0, (False,) * 4),
        (half, (True, False, True, False)),
        (-half, (False, True, False, True)),
        (half + 0.2, (True,) * 4),
    ):
        referee = Referee(course)
        events = drive(referee, np.linspace(1.0, 1.2, 10), np.arange(10) * 0.02, offset)
        assert referee.status.wheels_off == wheels
        assert referee.status.off_track == all(wheels)
        assert [name for _, name in events] == ["off_track"] * all(wheels)
        assert referee.status.penalty == (5.0 if all(wheels) else 0.0)


def test_one_wheel_rule_and_penalty_once_per_excursion(course):
    referee = Referee(course, rules=Rules(off_track="one", off_track_penalty=2.0))
    for start in (0.0, 1.0):
        drive(referee, np.linspace(1.0, 1.2, 10), start + np.arange(10) * 0.02, 0.38)
        drive(referee, np.linspace(1.2, 1.4, 10), start + 0.5 + np.arange(10) * 0.02, 0.0)
    assert referee.status.penalty == 4.0


def test_stuck_and_free_again(course):
    referee = Referee(course, rules=Rules(stuck_time=2.0))
    events = drive(referee, np.linspace(-0.1, 0.5, 50), np.arange(50) * 0.1)
    events += drive(referee, np.full(40, 0.5), 5.0 + np.arange(40) * 0.1)
    assert [name for _, name in events] == ["start", "stuck"] and referee.status.stuck
    drive(referee, np.linspace(0.5, 0.6, 10), 9.0 + np.arange(10) * 0.1)
    assert not referee.status.stuck


def test_walls():
    parsed = circle("walls: {enabled: true}")
    lane = geometry.lane(parsed)
    walls = wall_polygons(files.wall_boxes(lane, parsed), parsed.walls.thickness)
    referee = Referee(Course(lane), walls)
    # outer wall's face: half lane 0.38 + gap 0.15; the outline is 0.0945 wide
    for offset, crashed in ((-0.40, False), (-0.45, True)):
        referee.restart()
        events = drive(referee, np.linspace(1.0, 1.3, 20), np.arange(20) * 0.02, offset)
        assert ("crash" in [name for _, name in events]) == crashed == referee.status.crashed
        assert referee.status.penalty == (5.0 if crashed else 0.0)


def test_open_course_from_start_to_finish():
    points = [[0.0, 0.0], [2.0, 0.0], [4.0, 0.5], [6.0, 0.5]]
    lane = geometry.lane(track_file.parse(f"closed: false\npoints: {points}", "open.yaml"))
    course = Course(lane)
    referee = Referee(course)
    events = []
    for k in range(700):
        x, y, yaw = course.pose(0.1 + 0.01 * k)
        if 0.1 + 0.01 * k > lane.length:
            x += 0.01 * k + 0.1 - lane.length
        events += referee.update(0.02 * k, x, y, yaw, 0.5)[1]
        if x > 6.5:  # well behind the finish, where there is no track
            break
    assert events == ["start", "lap"] and referee.status.laps == 1
    assert referee.status.penalty == 0.0 and not referee.status.off_track
    assert referee.status.last_lap_time == pytest.approx((lane.length - 0.1) / 0.5, abs=0.05)


def test_time_going_back_restarts_the_run(course):
    referee = Referee(course)
    drive(referee, np.linspace(-0.2, 1.0, 50), 10.0 + np.arange(50) * 0.1)
    assert referee.status.running
    drive(referee, [-0.2, -0.19], [0.0, 0.1])
    assert not referee.status.running and referee.status.laps == 0


def test_off_track_matches_polygon_geometry():
    """10,000 random poses on a track of the package against shapely's containment."""
    path = source.find("hard")
    lane = geometry.lane(source.load(path))
    area, referee = prep(region.lane_area(lane)), Referee(Course(lane))
    rng = np.random.default_rng(7)
    low, high = lane.curve.min(axis=0) - 0.8, lane.curve.max(axis=0) + 0.8
    wheels = np.array(Car().wheels)
    positions = []
    for x, y, yaw in zip(
        rng.uniform(low[0], high[0], 10000),
        rng.uniform(low[1], high[1], 10000),
        rng.uniform(-np.pi, np.pi, 10000),
    ):
        rotation = np.array(((np.cos(yaw), -np.sin(yaw)), (np.sin(yaw), np.cos(yaw))))
        positions.append(wheels @ rotation.T + (x, y))
    positions = np.array(positions)
    expected = np.array(
        [[area.contains(Point(position)) for position in four] for four in positions]
    )
    for start in range(0, 10000, 100):  # a hundred poses in one call
        result = referee.course.contains(positions[start : start + 100].reshape(-1, 2))
        np.testing.assert_array_equal(result.reshape(-1, 4), expected[start : start + 100])
    counts = set(np.count_nonzero(~expected, axis=1))
    assert counts == {0, 1, 2, 3, 4}


@pytest.mark.parametrize(
    "wrong, texts",
    [
        ({"off_track": "two"}, ["off_track", "two", "all, one"]),
        ({"stuck_time": -1.0}, ["stuck_time", "-1"]),
        ({"collision_penalty": float("nan")}, ["collision_penalty", "nan"]),
        ({"auto_reset": 1}, ["auto_reset", "true or false"]),
    ],
)
def test_invalid_rules(wrong, texts):
    with pytest.raises(ValueError) as caught:
        Rules(**wrong)
    assert all(text in str(caught.value) for text in texts)


def test_a_stale_pose_at_the_line_starts_no_lap(course):
    """The car was just moved before the line, but one old message still has it on the line."""
    referee = Referee(course)
    referee.update(0.0, *pose_at(0.02), 0.0)
    events = drive(referee, np.linspace(-0.2, 1.0, 100), 0.02 + 0.02 * np.arange(100))
    assert [name for _, name in events] == ["start"]
    assert referee.status.progress == pytest.approx(100.0 / (2.0 * np.pi), abs=0.5)

"""Progress, wheels beside the lane and ends of a run, worked out by hand."""

import math

import numpy as np
import pytest
from paddock_gym.course import STUCK_STEPS, Motion, RunEvaluator, motion_from
from track_model.referee.course import Course
from track_model.referee.referee import Car
from track_model.track import load_track


def at(x, y=0.0, yaw=0.0):
    return Motion(x, y, yaw, 0.0, 0.0, 0.0)


def evaluate(course, first, *motions):
    evaluator = RunEvaluator(course)
    evaluator.start(first)
    for motion in motions:
        state = evaluator.update(motion)
    return state


def test_place_and_progress_on_a_straight(straight_track):
    state = evaluate(straight_track[1], at(1.0), at(1.25, 0.1, math.radians(10.0)))
    assert state.s == pytest.approx(1.25, abs=1e-6)
    assert state.lateral == pytest.approx(0.1, abs=1e-6)
    assert math.degrees(state.heading_error) == pytest.approx(10.0, abs=1e-3)
    assert state.gain == pytest.approx(0.25, abs=1e-6)
    assert state.progress == pytest.approx(100.0 * 0.25 / 5.0, abs=1e-3)
    assert (state.left, state.right) == pytest.approx((0.4, 0.4))
    assert state.end == "" and state.steps == 1


@pytest.mark.parametrize(
    "y, off, end",
    [
        (0.0, (False, False, False, False), ""),
        # front wheels stand 0.0796 m and rear wheels 0.0811 m from the middle, the edge 0.4 m
        (0.315, (False, False, False, False), ""),
        (0.33, (True, False, True, False), ""),
        (-0.33, (False, True, False, True), ""),
        (0.47, (True, False, True, False), ""),
        (0.49, (True, True, True, True), "off_track"),
        (-0.49, (True, True, True, True), "off_track"),
    ],
)
def test_wheels_beside_the_lane(straight_track, y, off, end):
    state = evaluate(straight_track[1], at(2.0), at(2.1, y))
    assert state.wheels_off == off
    assert state.end == end
    assert state.all_wheels_on == (not any(off))


@pytest.mark.parametrize("name", ["default", "hard"])
def test_wheels_are_judged_as_the_referee_does(name):
    """Against the referee's polygons of the lane, for poses all over the track."""
    course = Course(load_track(name).lane)
    evaluator, rng = RunEvaluator(course), np.random.default_rng(3)
    differ = 0
    for _ in range(400):
        x, y, yaw = course.pose(rng.uniform(0.0, course.length))
        side, yaw = rng.uniform(-0.55, 0.55), yaw + rng.uniform(-0.6, 0.6)
        motion = at(x - side * math.sin(yaw), y + side * math.cos(yaw), yaw)
        turn = np.array(((math.cos(yaw), -math.sin(yaw)), (math.sin(yaw), math.cos(yaw))))
        wheels = np.array(Car().wheels) @ turn.T + motion[:2]
        differ += np.count_nonzero(~course.contains(wheels) != evaluator.start(motion).wheels_off)
    assert differ <= 4  # of 1600: wheels within millimeters of the edge


def test_a_whole_round_is_a_lap(circuit):
    _, course = circuit
    evaluator, start = RunEvaluator(course), 3.0
    evaluator.start(at(*course.pose(start)))
    steps = 40
    for number in range(1, steps + 1):
        state = evaluator.update(at(*course.pose(start + number * course.length / steps)))
        assert state.progress == pytest.approx(100.0 * number / steps, abs=0.1)
        assert (state.end == "lap") == (number == steps)


def test_the_end_of_an_open_course_is_its_lap(straight_track):
    assert evaluate(straight_track[1], at(5.5), at(5.7), at(5.9)).end == ""
    assert evaluate(straight_track[1], at(5.5), at(5.7), at(5.99)).end == "lap"


def test_a_car_without_progress_is_stuck(straight_track):
    moving = [at(1.0 + 0.01 * number) for number in range(1, STUCK_STEPS + 5)]
    assert evaluate(straight_track[1], at(1.0), *moving).end == ""
    assert evaluate(straight_track[1], at(1.0), *[at(1.0)] * (STUCK_STEPS - 1)).end == ""
    assert evaluate(straight_track[1], at(1.0), *[at(1.0)] * STUCK_STEPS).end == "stuck"


def test_driving_back_ends_a_run(straight_track):
    assert evaluate(straight_track[1], at(1.0), at(1.4), at(1.15)).end == ""
    assert evaluate(straight_track[1], at(1.0), at(1.4), at(1.05)).end == "reversed"


def test_a_crash_ends_a_run(straight_track):
    evaluator = RunEvaluator(straight_track[1])
    evaluator.start(at(1.0))
    assert evaluator.update(at(1.1), crashed=True).end == "crashed"


def test_velocities_are_along_the_cars_axes():
    half = math.sqrt(0.5)  # heading along +y
    motion = motion_from((1.0, 2.0, 0.0), (0, 0, half, half), (0.5, 2.0, 0.0), (0, 0, 0.3))
    assert motion.yaw == pytest.approx(math.pi / 2.0)
    assert motion.forward == pytest.approx(2.0)
    assert motion.leftward == pytest.approx(-0.5)
    assert (motion.x, motion.y, motion.yaw_rate) == (1.0, 2.0, 0.3)

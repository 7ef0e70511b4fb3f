"""Every key of a reward function's params, worked out by hand."""

import math

import numpy as np
import pytest
from paddock_gym.contract.params import Waypoints, params
from paddock_gym.course import Motion, RunEvaluator, TrackObject
from track_model.referee.course import Course
from track_model.track import load_track


def params_at(track, course, pose, before=None, objects=(), crashed=False):
    evaluator = RunEvaluator(course)
    motion = Motion(*pose, 1.0, 0.0, 0.0)
    evaluator.start(Motion(*(before or pose), 0.0, 0.0, 0.0))
    state = evaluator.update(motion, crashed)
    command = 1.5, math.radians(-20.0)
    width = state.left + state.right
    return params(state, motion, command, Waypoints(track, course), width, objects)


def test_every_key_on_a_straight(straight_track):
    params = params_at(*straight_track, (1.25, 0.1, math.radians(10.0)), before=(1.0, 0.0, 0.0))
    waypoints = params.pop("waypoints")
    # 6 m in 40 equal parts of 0.15 m: 1.25 m lies between the points number 8 and 9
    assert np.array(waypoints) == pytest.approx(
        np.stack([0.15 * np.arange(41), np.zeros(41)], axis=1), abs=1e-3
    )
    assert params == {
        "all_wheels_on_track": True,
        "x": 1.25,
        "y": 0.1,
        "heading": pytest.approx(10.0),
        "distance_from_center": pytest.approx(0.1, abs=1e-6),
        "is_left_of_center": True,
        "is_reversed": False,
        "is_crashed": False,
        "is_offtrack": False,
        "progress": pytest.approx(5.0, abs=1e-3),
        "steps": 1,
        "speed": 1.5,
        "steering_angle": pytest.approx(-20.0),
        "track_width": pytest.approx(0.8),
        "track_length": pytest.approx(6.0, abs=1e-3),
        "closest_waypoints": [8, 9],
        "projection_distance": pytest.approx(1.25, abs=1e-6),
        "closest_objects": [0, 0],
        "objects_location": [],
        "objects_left_of_center": [],
        "objects_speed": [],
        "objects_heading": [],
        "objects_distance_from_center": [],
        "objects_distance": [],
        "object_in_camera": False,
    }


@pytest.mark.parametrize(
    "pose, expected",
    [
        ((2.0, -0.2, 0.0), {"is_left_of_center": False, "distance_from_center": 0.2}),
        ((2.0, 0.33, 0.0), {"all_wheels_on_track": False, "is_offtrack": False}),
        ((2.0, 0.5, 0.0), {"all_wheels_on_track": False, "is_offtrack": True}),
        ((2.0, 0.0, math.pi - 0.1), {"is_reversed": True, "heading": math.degrees(math.pi - 0.1)}),
        ((2.0, 0.0, math.pi + 0.1), {"heading": math.degrees(0.1 - math.pi)}),
        ((0.0, 0.0, 0.0), {"closest_waypoints": [0, 1]}),
        ((6.0, 0.0, 0.0), {"closest_waypoints": [39, 40]}),
    ],
)
def test_single_keys(straight_track, pose, expected):
    params = params_at(*straight_track, pose)
    for key, value in expected.items():
        assert params[key] == (pytest.approx(value) if isinstance(value, float) else value), key


def test_a_crash_is_told(straight_track):
    assert params_at(*straight_track, (1.0, 0.0, 0.0), crashed=True)["is_crashed"] is True


def test_a_circuit_ends_with_its_first_waypoint(circuit):
    track, course = circuit
    params = params_at(track, course, course.pose(course.length - 0.01))
    waypoints = params["waypoints"]
    assert waypoints[0] == waypoints[-1] == pytest.approx((0.0, 0.0), abs=1e-6)
    assert params["closest_waypoints"] == [len(waypoints) - 2, len(waypoints) - 1]
    steps = np.linalg.norm(np.diff(waypoints, axis=0), axis=1)
    assert steps == pytest.approx(np.full(len(steps), 0.15), abs=0.01)


def test_a_route_keeps_the_points_of_its_file(tmp_path):
    """A circle of 2 m driven counter-clockwise, as DeepRacer's routes: numbers stay numbers."""
    angle = np.linspace(0.0, 2.0 * np.pi, 41)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    path = tmp_path / "ring.npy"
    np.save(path, np.hstack([2.0 * ring, 1.6 * ring, 2.4 * ring]))
    track = load_track(str(path))
    waypoints = Waypoints(track, Course(track.lane))
    assert len(waypoints.points) == 41
    # the start frame: origin at the first point, x along the way; the center is 2 m to the left
    for number, (x, y) in enumerate(waypoints.points):
        turn = 2.0 * np.pi * number / 40
        assert (x, y) == pytest.approx((2.0 * np.sin(turn), 2.0 - 2.0 * np.cos(turn)), abs=0.01)
    assert waypoints.around(2.0 * np.pi * 2.0 * 10.5 / 40) == [10, 11]


def test_objects(straight_track):
    objects = (
        TrackObject(3.0, 0.2, 0.0, 3.0, 0.2, 0.0),
        TrackObject(1.0, -0.1, math.radians(5.0), 1.0, -0.1, 0.7),
    )
    params = params_at(*straight_track, (2.0, 0.0, 0.0), objects=objects)
    assert params["closest_objects"] == [1, 0]  # behind, ahead
    assert params["objects_location"] == [(3.0, 0.2), (1.0, -0.1)]
    assert params["objects_left_of_center"] == [True, False]
    assert params["objects_speed"] == [0.0, 0.7]
    assert params["objects_heading"] == pytest.approx([0.0, 5.0])
    assert params["objects_distance_from_center"] == [0.2, 0.1]
    assert params["objects_distance"] == [3.0, 1.0]
    assert params["object_in_camera"] is True
    behind = params_at(*straight_track, (2.0, 0.0, 0.0), objects=objects[1:])
    assert behind["object_in_camera"] is False

"""Shared by the tests: a straight track, environments that are made once."""

import gymnasium
import pytest
from track_model.referee.course import Course
from track_model.track import load_track

import paddock_gym

STRAIGHT = """width: 0.8
closed: false
points: [[0, 0], [2, 0], [4, 0], [6, 0]]
"""


@pytest.fixture(scope="session")
def straight(tmp_path_factory):
    """Path of a straight course of 6 m along x, 0.8 m wide."""
    path = tmp_path_factory.mktemp("tracks") / "straight.yaml"
    path.write_text(STRAIGHT)
    return str(path)


@pytest.fixture(scope="session")
def straight_track(straight):
    """Track and Course of the straight course."""
    track = load_track(straight)
    return track, Course(track.lane)


@pytest.fixture(scope="session")
def circuit():
    """Track and Course of the track `easy`: a wide oval, driven counter-clockwise."""
    track = load_track("easy")
    return track, Course(track.lane)


@pytest.fixture(scope="module")
def env():
    """DeepRacerEnv with the observation `state` on `default`."""
    made = gymnasium.make(paddock_gym.IDS[0]).unwrapped
    yield made
    made.close()

"""Observations, worked out by hand, and the same from a robot's messages."""

import math
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
from paddock_gym.course import Motion
from paddock_gym.observations import LOOKAHEADS, NAMES, Assembler, StateObserver, locate

import paddock_gym
from paddock_gym import observations


def test_the_state_on_a_straight(straight_track):
    _, course = straight_track
    motion = Motion(1.0, 0.1, math.radians(30.0), 2.0, -0.5, 1.0)
    course_pose = locate(course, motion)
    row = StateObserver(course).observe(motion, course_pose, (3.0, math.radians(15.0)))
    expected = [0.25, 0.5, math.sqrt(0.75), 0.5, -0.5, 0.25, 0.5, 0.75]
    assert row[:8] == pytest.approx(expected, abs=1e-4)
    assert row[8:] == pytest.approx(np.zeros(len(LOOKAHEADS)), abs=1e-3)
    assert len(row) == len(NAMES) and row.dtype == np.float32


def test_curvatures_ahead_are_the_courses(circuit):
    _, course = circuit
    observer = StateObserver(course)
    for s in (0.5, 4.0, course.length - 0.3):
        course_pose = SimpleNamespace(s=s, lateral=0.0, heading_error=0.0, left=0.5, right=0.5)
        row = observer.observe(Motion(0, 0, 0, 0, 0, 0), course_pose, (0.0, 0.0))
        turns = (course.heading(at + 0.05) - course.heading(at - 0.05) for at in s + LOOKAHEADS)
        expected = [math.remainder(turn, 2.0 * math.pi) / 0.1 for turn in turns]
        assert row[8:] == pytest.approx(expected, abs=0.05)


def test_ranges():
    measured = np.full(64, 5.0)
    measured[:4] = math.inf, -math.inf, 20.0, math.nan
    row = observations.ranges(measured)
    assert row[:5] == pytest.approx([1.0, 0.0, 1.0, 1.0, 0.5])
    assert row.dtype == np.float32


def test_rays_of_a_finer_scan():
    half = math.radians(150.0)
    rays = observations.select_rays(-half, 2.0 * half / 599, 600)
    angles = -half + rays * 2.0 * half / 599
    assert np.abs(angles - observations.ANGLES).max() < math.radians(0.26)
    assert (observations.select_rays(-half, 2.0 * half / 63, 64) == np.arange(64)).all()


@pytest.mark.parametrize("scan", [(-1.0, 0.02, 100), (-2.618, 0.2, 27), (-2.618, 0.0873, 30)])
def test_a_scan_that_does_not_do_is_refused(scan):
    with pytest.raises(ValueError, match="the policy needs 64 or more from -150 to 150"):
        observations.select_rays(*scan)


def test_images():
    red = np.zeros((120, 160, 3), np.uint8)
    red[..., 0] = 200
    assert observations.image(red).shape == (120, 160, 1)
    assert observations.image(red)[5, 5, 0] == pytest.approx(0.299 * 200, abs=1)
    assert (observations.image(red, colour=True) == red).all()
    assert observations.image(np.zeros((480, 640, 3), np.uint8)).shape == (120, 160, 1)


def test_a_robots_messages_make_the_environments_observation():
    """Motion, ranges and image of messages make the observation that the policy was trained on."""
    names = ("state", "lidar", "camera")
    env = gymnasium.make(paddock_gym.IDS[0], observation=names, walls=True).unwrapped
    assembler = Assembler(names, course=env.task.course)
    assert assembler.observe((0.0, 0.0)) is None
    rng = np.random.default_rng(2)
    observation, _ = env.reset(seed=2, options={"start": 0.97})
    for _ in range(25):
        action = rng.uniform((-0.3, -0.8), (0.3, 0.0))
        observation, *_ = env.step(action)
        assembler.set_motion(env.task.motion)
        assembler.set_ranges(observation["lidar"] * observations.MAX_RANGE)
        assembler.set_image(env.task.camera())
        assembled = assembler.observe(env.options.actions.command(action))
        assert (assembled["state"] == observation["state"]).all()
        assert assembled["lidar"] == pytest.approx(observation["lidar"], abs=1e-6)
        assert (assembled["camera"] == observation["camera"]).all()
    env.close()


def test_the_camera_sees_the_track_and_the_lidar_its_walls():
    env = gymnasium.make(
        paddock_gym.IDS[0], observation=("camera", "lidar"), walls=True, colour=True
    ).unwrapped
    observation, _ = env.reset(seed=1, options={"start": 0.0})
    image = observation["camera"].astype(int)
    asphalt, dash, sky = image[100:, 30:50].mean((0, 1)), image[110, 85], image[5].mean(0)
    assert asphalt == pytest.approx([52, 53, 56], abs=25)  # colors of the track's file
    assert dash[0] > 1.4 * dash[1] > 2.0 * dash[2]
    assert sky[2] >= sky[0] > 150
    wide = observation["lidar"] * 10.0
    # a lane of 0.76 m with walls 0.15 m outside it: 0.53 m to either side
    left, right = (
        wide[np.abs(observations.ANGLES - side * math.pi / 2).argmin()] for side in (1, -1)
    )
    assert (left, right) == pytest.approx((0.53, 0.53), abs=0.05)
    env.close()

"""Backing on the kinematic model, with a steering that turns at a limited rate."""

import math

import numpy as np
import pytest
from cybertruck.trailer.geometry import Geometry, TrailerError, jackknife_angle
from cybertruck.trailer.kinematics import trailer_axle
from cybertruck.trailer.shapes import make_shape
from cybertruck.trailer.steering import IdealSteering, MeasuredSteering
from cybertruck.trailer.tracker import ARRIVED, FAILED, PULLING, CurvatureHold, Tracker, Tuning
from trailer_sim import advance, simulate, start_state, trailer_curvature

DEFAULT = Geometry()
TIGHT = Geometry(max_steering=math.atan(0.508 / 0.8))  # Fmax = 1/0.8 per meter
LINE = make_shape("line", (8.0,))


def steering_of(geometry):
    """The ideal steering of a geometry."""
    return IdealSteering(geometry.wheelbase, geometry.max_steering)


def back_up(path, geometry, lateral, heading, hitch, believed=None, tuning=Tuning(), limit=120.0):
    """Runs rigs from the start of a path.

    Returns:
        (Run, Tracker).
    """
    start = start_state(path, lateral, heading, hitch, geometry)
    tracker = Tracker(
        path, believed or geometry, steering_of(geometry), tuning, shape=start.shape[:-1]
    )
    axle = trailer_axle(*np.moveaxis(start[..., :3], -1, 0), start[..., 3], geometry)
    tracker.start(*axle[:2], np.zeros(start.shape[:-1]))
    return simulate(tracker, start, steering_of(geometry), geometry, limit, 0.04), tracker


@pytest.mark.parametrize(
    "geometry",
    (
        DEFAULT,
        TIGHT,
        Geometry(hitch_offset=0.0),
        Geometry(hitch_offset=0.05),
        Geometry(hitch_offset=0.12),
    ),
)
def test_a_thousand_random_starts_converge(geometry):
    random = np.random.default_rng(11)
    count = 1000
    run, _ = back_up(
        LINE,
        geometry,
        random.uniform(-1.0, 1.0, count),
        np.radians(random.uniform(-30.0, 30.0, count)),
        np.radians(random.uniform(-45.0, 45.0, count)),
    )
    assert np.all(run.mode[-1] == ARRIVED)
    assert not run.struck.any()
    assert np.max(np.abs(run.lateral[-1])) < 0.005
    assert np.degrees(np.max(np.abs(run.heading[-1]))) < 0.5


def test_starts_beyond_the_jackknife_angle_recover_by_pulling_forward():
    random = np.random.default_rng(12)
    low, count = math.degrees(jackknife_angle(TIGHT)), 200
    hitch = np.radians(random.uniform(low + 0.1, 79.9, count)) * random.choice((-1, 1), count)
    run, tracker = back_up(
        LINE,
        TIGHT,
        random.uniform(-1.0, 1.0, count),
        np.radians(random.uniform(-30.0, 30.0, count)),
        hitch,
    )
    assert np.all(run.mode[0] == PULLING)
    assert np.all(tracker.recoveries >= 1)
    assert np.all(run.mode[-1] == ARRIVED)
    assert not run.struck.any()
    assert np.max(np.abs(run.lateral[-1])) < 0.005


def test_without_pulling_forward_such_a_start_is_lost():
    state = np.array((0.0, 0.0, 0.0, jackknife_angle(TIGHT) + 0.02))
    for _ in range(1500):
        state = advance(state, -0.3, -TIGHT.max_curvature, 0.01, TIGHT)
    assert state[3] > TIGHT.hitch_stop


@pytest.fixture(name="fifty", scope="module")
def _fifty():
    """Fifty random starts, and how they are driven with the right lengths."""
    random = np.random.default_rng(13)
    starts = (
        random.uniform(-1.0, 1.0, 50),
        np.radians(random.uniform(-30.0, 30.0, 50)),
        np.radians(random.uniform(-45.0, 45.0, 50)),
    )
    return starts, back_up(LINE, DEFAULT, *starts)[0]


@pytest.mark.parametrize("offset, tongue", ((0.9, 0.9), (0.9, 1.1), (1.1, 0.9), (1.1, 1.1)))
def test_wrong_lengths_stay_stable_and_at_most_double_the_errors(fifty, offset, tongue):
    believed = Geometry(hitch_offset=0.3 * offset, tongue_length=0.7 * tongue)
    starts, exact = fifty
    wrong, _ = back_up(LINE, DEFAULT, *starts, believed, Tuning(steering_gain=1.15))
    assert np.all(wrong.mode[-1] == ARRIVED) and not wrong.struck.any()
    rms = [np.sqrt(np.mean(run.lateral**2, axis=0)) for run in (exact, wrong)]
    assert np.all(rms[1] <= 2.0 * rms[0])
    assert np.max(np.abs(wrong.lateral[-1])) < 0.005


@pytest.mark.parametrize(
    "name, largest", (("arc", 0.02), ("s", 0.02), ("lane-change", 0.02), ("park", 0.02))
)
def test_shapes_from_their_start(name, largest):
    run, _ = back_up(make_shape(name), DEFAULT, 0.0, 0.0, 0.0)
    assert run.mode[-1] == ARRIVED
    assert np.max(np.abs(run.lateral)) < largest
    assert np.degrees(abs(run.heading[-1])) < 1.0


def test_errors_decay_as_the_law_says():
    # small errors and a steering that follows at once: e'' + (1/l1 + 1/l2) e' + e / (l1 l2) = 0
    tuning, path = Tuning(steering_gain=1.0), make_shape("line", (4.0,))
    start = start_state(path, 0.02, 0.0, 0.0, DEFAULT)
    tracker = Tracker(path, DEFAULT, steering_of(DEFAULT), tuning)
    run = simulate(tracker, start, steering_of(DEFAULT), DEFAULT, 30.0, 0.01, steering_rate=1e6)
    first, second = 1.0 / tuning.lateral_length, 1.0 / tuning.heading_length
    arc = run.arc
    expected = (
        0.02 / (second - first) * (second * np.exp(-first * arc) - first * np.exp(-second * arc))
    )
    assert np.max(np.abs(run.lateral - expected)) < 4e-4


@pytest.mark.parametrize("geometry", (DEFAULT, Geometry(hitch_offset=0.0)))
@pytest.mark.parametrize("curvature, hitch", ((0.5, 0.7), (-0.3, 0.2), (0.0, -0.6)))
def test_held_curvature_is_reached_and_the_drive_ends(geometry, curvature, hitch):
    hold = CurvatureHold(curvature, 6.0, geometry, steering_of(geometry))
    state, made = np.array((0.0, 0.0, 0.0, hitch)), None
    for _ in range(2000):
        status = hold.step(*trailer_axle(*state, geometry), state[3])
        if status.mode == ARRIVED:
            break
        bend = math.tan(status.steering) / geometry.wheelbase
        made = -float(trailer_curvature(state[3], bend, geometry))
        state = advance(state, status.speed, bend, 0.02, geometry)
    assert status.mode == ARRIVED and status.speed == 0.0
    assert hold.arc == pytest.approx(6.0, abs=0.02)
    assert made == pytest.approx(curvature, abs=0.01)


@pytest.mark.parametrize(
    "curvature, length, word",
    (
        (2.0, 3.0, "2 1/m"),
        (math.nan, 3.0, "nan"),
        (0.3, 0.0, "length is 0"),
        (0.3, math.inf, "inf"),
    ),
)
def test_bad_holds_are_refused(curvature, length, word):
    with pytest.raises(TrailerError, match=word):
        CurvatureHold(curvature, length, DEFAULT, steering_of(DEFAULT))


def test_hold_ends_at_the_guard():
    hold = CurvatureHold(0.3, 3.0, DEFAULT, steering_of(DEFAULT))
    status = hold.step(0.0, 0.0, 0.0, math.radians(76.0))
    assert status.mode == FAILED and status.speed == 0.0


def test_speed_stays_below_the_limit_and_falls_towards_the_end():
    tracker = Tracker(LINE, DEFAULT, steering_of(DEFAULT), Tuning(speed=0.6))
    assert tracker.step(0.0, 0.0, math.pi, 0.0).speed == pytest.approx(-0.6)
    tracker.start(7.9, 0.0, 7.9)
    assert tracker.step(7.9, 0.0, math.pi, 0.0).speed == pytest.approx(-math.sqrt(0.06), abs=1e-6)
    status = tracker.step(8.0, 0.0, math.pi, 0.0)
    assert status.mode == ARRIVED and status.speed == 0.0


@pytest.mark.parametrize("hitch, mode", ((70.0, 0), (76.0, PULLING)))
def test_guard_before_the_hitch_stop(hitch, mode):
    tracker = Tracker(LINE, DEFAULT, steering_of(DEFAULT))
    status = tracker.step(0.0, 0.0, math.pi, math.radians(hitch))
    assert status.mode == mode
    assert (status.speed > 0.0) == (mode == PULLING)
    if mode == 0:  # backing at full lock, to the side that unfolds
        assert status.steering == pytest.approx(-DEFAULT.max_steering)


def test_a_rig_that_cannot_be_unfolded_fails_after_the_longest_pull():
    tracker = Tracker(LINE, DEFAULT, steering_of(DEFAULT))
    modes = [
        int(tracker.step(-0.1 * index, 0.0, math.pi, math.radians(78.0)).mode)
        for index in range(80)
    ]
    assert modes[0] == PULLING and modes[-1] == FAILED


def test_a_path_that_crosses_itself_is_followed_in_order():
    # an arc of one and a quarter turns passes its start again; the progress never jumps
    path = make_shape("arc", (2.0, 2.5 * math.pi))
    run, _ = back_up(path, DEFAULT, 0.05, 0.0, 0.0, tuning=Tuning(speed=0.5))
    assert run.mode[-1] == ARRIVED
    assert np.max(np.diff(run.arc)) < 0.033
    assert np.max(np.abs(run.lateral)) < 0.06


def test_a_measured_map_is_used():
    angles = np.radians(np.arange(-45.0, 46.0, 5.0))
    steering = MeasuredSteering(angles, 0.8 * np.tan(angles) / 0.508)
    tracker = Tracker(make_shape("s", (1.0, 4.0)), DEFAULT, steering)
    start = start_state(tracker.path, 0.0, 0.0, 0.0, DEFAULT)
    run = simulate(tracker, start, steering, DEFAULT, 60.0, 0.04)
    assert run.mode[-1] == ARRIVED and np.max(np.abs(run.lateral)) < 0.02


@pytest.mark.parametrize(
    "field, value",
    (
        ("speed", 0.0),
        ("speed", -0.3),
        ("speed", 0.7),
        ("speed", math.nan),
        ("speed", "fast"),
        ("recovery_speed", 1.0),
        ("lateral_length", 0.0),
        ("steering_gain", True),
        ("reference_limit", 1.5),
    ),
)
def test_bad_tuning_is_refused(field, value):
    with pytest.raises(TrailerError, match=field):
        Tuning(**{field: value})


def test_a_path_that_is_too_sharp_is_refused():
    with pytest.raises(TrailerError, match="radius of 0.50 m"):
        Tracker(make_shape("arc", (0.5, 3.0)), DEFAULT, steering_of(DEFAULT))

"""Backing in the physics, without ROS: the required accuracy, measured on the truck's links."""

import math

import numpy as np
import pytest
from cybertruck.trailer.geometry import Geometry
from cybertruck.trailer.shapes import make_shape
from cybertruck.trailer.steering import IdealSteering
from cybertruck.trailer.tracker import ARRIVED, PULLING, Tracker, Tuning
from trailer_sim import advance
from truck_rig import Rig

START = (0.0, 0.0, math.pi)  # paths begin here and lead to -x, so that trailers head to +x
ARC, LATERAL, HEADING, HITCH, MODE = range(5)
QUICK = Tuning(speed=0.5)  # [m/s]: simulated seconds are what costs, errors grow with speed


@pytest.fixture(scope="module")
def rig():
    """One world for all tests; every test places the truck again."""
    made = Rig()
    yield made
    made.close()


@pytest.fixture(scope="module")
def coarse_rig():
    """The same with a physics step of 2 ms and a coarser solution: many drives in little time.

    Against the worlds' step and 50 iterations a drive of 4 s in an arc ends 7 mm elsewhere.
    """
    made = Rig(0.002)
    made.world.engine.set_solver_iterations(10)
    yield made
    made.close()


def back_up(rig, path, lateral=0.0, heading=0.0, hitch=0.0, believed=None, tuning=Tuning()):
    """Backs from beside the start of a path.

    Returns:
        (rows of Rig.back_up, Tracker).
    """
    rig.place(0.0, -lateral, heading, hitch)  # the left of a path to -x is -y
    geometry = believed or rig.geometry
    tracker = Tracker(
        path.moved(*START),
        geometry,
        IdealSteering(geometry.wheelbase, geometry.max_steering),
        tuning,
    )
    return rig.back_up(tracker, path.length / tuning.speed + 40.0), tracker


def rms(values):
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def last(rows, length):
    """Rows of the last meters."""
    return rows[rows[:, ARC] > rows[-1, ARC] - length]


def test_line_from_beside_and_with_a_bent_hitch(coarse_rig):
    line = make_shape("line", (8.0,))
    rows, tracker = back_up(coarse_rig, line, 0.5, 0.0, math.radians(20.0), tuning=QUICK)
    assert rows[0, LATERAL] == pytest.approx(0.5, abs=0.01)
    assert math.degrees(rows[0, HITCH]) == pytest.approx(20.0, abs=1.0)
    assert rows[-1, MODE] == ARRIVED and tracker.recoveries == 0
    assert rms(last(rows, 3.0)[:, LATERAL]) < 0.02


def test_circle_has_its_radius(rig):
    path = make_shape("arc", (3.0, 0.5 * math.pi))
    rows, _ = back_up(rig, path, tuning=QUICK)
    assert rows[-1, MODE] == ARRIVED
    inner = rows[(rows[:, ARC] > 1.5) & (rows[:, ARC] < path.length - 1.5)]  # between the run-ups
    assert np.ptp(inner[:, ARC]) > 3.0
    assert np.max(np.abs(inner[:, LATERAL])) < 0.03 * 3.0


@pytest.mark.parametrize("name", ("s", "lane-change"))
def test_bends(coarse_rig, name):
    rows, _ = back_up(coarse_rig, make_shape(name), tuning=QUICK)
    assert rows[-1, MODE] == ARRIVED
    assert np.max(np.abs(rows[:, LATERAL])) < 0.10


def test_park_ends_in_its_place(coarse_rig):
    path = make_shape("park")
    rows, _ = back_up(coarse_rig, path, tuning=QUICK)
    assert rows[-1, MODE] == ARRIVED
    assert math.hypot(rows[-1, ARC] - path.length, rows[-1, LATERAL]) < 0.10
    assert math.degrees(abs(rows[-1, HEADING])) < 3.0


def random_starts(count, seed):
    """Starts whose lateral, heading and hitch values each fall once into each of `count` strata.

    Returns:
        (count, 3) within ±1 m, ±30 and ±45 degrees [m, rad, rad].
    """
    random = np.random.default_rng(seed)
    strata = np.stack([random.permutation(count) for _ in range(3)], axis=1)
    shares = (strata + random.uniform(size=(count, 3))) / count
    return (2.0 * shares - 1.0) * (1.0, math.radians(30.0), math.radians(45.0))


@pytest.mark.parametrize("start", random_starts(12, 21)[:4], ids="{0[0]:.2f}, {0[1]:.2f}".format)
def test_random_starts_converge(coarse_rig, start):
    """Four by default; tests/long has the others of twelve and fifty more."""
    check_start(coarse_rig, start)


def check_start(rig, start):
    """Backs from a start of random_starts() and checks where the trailer ends."""
    rows, _ = back_up(rig, make_shape("line", (5.0,)), *start, tuning=Tuning(speed=0.6))
    assert rows[-1, MODE] == ARRIVED
    assert np.max(np.abs(rows[:, HITCH])) < rig.geometry.hitch_stop
    assert abs(rows[-1, LATERAL]) < 0.05
    assert math.degrees(abs(rows[-1, HEADING])) < 5.0


@pytest.mark.parametrize("hitch", (77.0, -77.0))
def test_a_start_beyond_the_jackknife_angle_pulls_forward_first(coarse_rig, hitch):
    rig = coarse_rig
    tight = Geometry(max_steering=math.atan(0.508 / 0.8))  # Fmax = 1/0.8: jackknife at 75.6
    rows, tracker = back_up(
        rig, make_shape("line", (4.0,)), 0.2, 0.1, math.radians(hitch), tight, QUICK
    )
    assert rows[0, MODE] == PULLING and tracker.recoveries == 1
    assert rows[-1, MODE] == ARRIVED
    assert np.max(np.abs(rows[:, HITCH])) < rig.geometry.hitch_stop
    assert abs(rows[-1, LATERAL]) < 0.03


def test_half_circles_bend_the_hitch_as_kinematics_says(coarse_rig):
    rig = coarse_rig
    radius, speed, period = 1.5, 0.5, 0.04
    steering = math.atan(rig.geometry.wheelbase / radius)
    rig.place(0.0, 0.0, 0.0, 0.0)
    model, angle, pace, errors = rig.state(), 0.0, 0.0, []
    half = round(math.pi * radius / speed / period)
    for number in range(2 * half):
        wanted = steering if number < half else -steering
        rig.drive(wanted, speed, period)
        for _ in range(5):  # the drive node's limits, at its own period
            angle += np.clip(wanted - angle, -2.5 * 0.008, 2.5 * 0.008)
            pace += np.clip(speed - pace, -2.0 * 0.008, 2.0 * 0.008)
            model = advance(
                model, pace, math.tan(angle) / rig.geometry.wheelbase, 0.008, rig.geometry
            )
        errors.append(rig.state()[3] - model[3])
    assert math.degrees(np.max(np.abs(model[3]))) > 30.0  # a real bend
    assert math.degrees(rms(errors)) < 1.0

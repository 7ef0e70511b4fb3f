"""Figures, CSV and plot of a drive, from a simulated one."""

import csv
import math

import numpy as np
import pytest
from cybertruck.trailer import report
from cybertruck.trailer.geometry import Geometry
from cybertruck.trailer.shapes import make_shape
from cybertruck.trailer.steering import IdealSteering
from cybertruck.trailer.tracker import Tracker
from trailer_sim import simulate, start_state

GEOMETRY = Geometry()


@pytest.fixture(scope="module")
def drive():
    """(path, table) of a line, started 0.3 m to its side."""
    path = make_shape("line", (6.0,))
    steering = IdealSteering(GEOMETRY.wheelbase, GEOMETRY.max_steering)
    start = start_state(path, 0.3, 0.0, 0.0, GEOMETRY)
    run = simulate(Tracker(path, GEOMETRY, steering), start, steering, GEOMETRY, 60.0, 0.05)
    times = 100.0 + 0.05 * np.arange(len(run.states))
    return path, report.table(path, times, run.states, np.full(len(times), -0.3), GEOMETRY), run


def test_table_measures_what_the_tracker_saw(drive):
    _, rows, run = drive
    np.testing.assert_allclose(report.column(rows, "lateral_error"), run.lateral, atol=1e-9)
    np.testing.assert_allclose(report.column(rows, "hitch_angle"), run.states[:, 3])
    assert report.column(rows, "time")[0] == 0.0


def test_summary(drive):
    path, rows, _ = drive
    figures = report.summary(rows, path)
    lateral = report.column(rows, "lateral_error")
    assert figures["max_lateral_error_m"] == pytest.approx(0.3, abs=1e-6)
    assert figures["rms_lateral_error_m"] == pytest.approx(math.sqrt(np.mean(lateral**2)))
    assert figures["end_distance_m"] < 0.02
    assert abs(figures["end_heading_error_deg"]) < 1.0


def test_csv_and_figure(drive, tmp_path):
    path, rows, _ = drive
    report.write_csv(tmp_path / "drive.csv", rows)
    with open(tmp_path / "drive.csv") as stream:
        lines = list(csv.reader(stream))
    assert lines[0][:3] == ["time [s]", "arc [m]", "lateral_error [m]"]
    assert len(lines) == len(rows) + 1
    assert float(lines[1][2]) == pytest.approx(0.3, abs=1e-4)
    report.write_figure(tmp_path / "drive.png", rows, path, GEOMETRY, "line")
    assert (tmp_path / "drive.png").stat().st_size > 10000


def test_outline_is_a_closed_box_of_its_size():
    corners = report.outline(1.0, 2.0, math.pi / 2, (-0.2, 0.8, 0.4))
    np.testing.assert_allclose(corners[0], corners[-1])
    np.testing.assert_allclose(corners.min(axis=0), (0.8, 1.8))
    np.testing.assert_allclose(corners.max(axis=0), (1.2, 2.8))

"""The demo's measuring: unwrapped headings, path following, the plot of its path."""

import math

import numpy as np
import pytest
from deepracer_teleop.runs import results
from deepracer_teleop.runs.results import Recorder, along
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from nav_msgs.msg import Odometry
from track_model.track import load_track


def odometry(t, x, y, yaw, v=0.3):
    message = Odometry()
    message.header.stamp.secs, message.header.stamp.nsecs = int(t), round((t % 1) * 1e9)
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    message.pose.pose.orientation.z = math.sin(yaw / 2.0)
    message.pose.pose.orientation.w = math.cos(yaw / 2.0)
    message.twist.twist.linear.x = v
    return message


def test_headings_are_unwrapped():
    recorder = Recorder()
    for index in range(100):
        recorder.callback(odometry(index, 0.0, 0.0, 0.1 * index))
    assert recorder.last.yaw == pytest.approx(9.9)


def test_distance_along_the_heading():
    recorder = Recorder()
    recorder.callback(odometry(0.0, 1.0, 1.0, math.pi / 2.0))
    recorder.callback(odometry(1.0, 1.2, 1.3, math.pi / 2.0))
    assert along(*recorder.samples) == pytest.approx(0.3)


def test_csv(tmp_path):
    recorder = Recorder()
    recorder.callback(odometry(1.5, 1.0, -2.0, 0.5))
    recorder.write_csv(tmp_path / "path.csv")
    assert (tmp_path / "path.csv").read_text().splitlines() == [
        "t,x,y,yaw,v",
        "1.500000,1.000000,-2.000000,0.500000,0.300000",
    ]


def test_the_figure_shows_the_path_at_its_position_in_the_colors_of_its_phases():
    recorder = Recorder()
    for index in range(21):
        recorder.phase = "cruise" if index > 10 else "Forward"
        recorder.callback(odometry(index, -1.0 + 0.2 * index, 2.0, 0.0))
    figure = results.path_figure(load_track("default"), recorder.samples)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    image = np.asarray(canvas.buffer_rgba())
    (axes,) = figure.axes
    for x, color in ((0.5, results.COLORS[0]), (2.5, results.COLORS[1])):
        column, row = axes.transData.transform((x, 2.0)).round().astype(int)
        assert to_hex(image[len(image) - row, column] / 255.0) == color
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["buttons", "cruise + slider", "start", "end"]
    single = results.path_figure(load_track("default"), recorder.samples, ("line driver",))
    assert [line.get_label() for line in single.axes[0].lines] == ["line driver", "end"]
    assert np.isfinite(single.axes[0].lines[0].get_xydata()).all()

"""The demo's measuring: unwrapped headings, path following, the image from above."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from deepracer_teleop.runs import results
from deepracer_teleop.runs.results import Recorder, along
from nav_msgs.msg import Odometry


def odometry(t, x, y, yaw, v=0.3):
    message = Odometry()
    message.header.stamp.secs, message.header.stamp.nsecs = int(t), round((t % 1) * 1e9)
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    message.pose.pose.orientation.z = math.sin(yaw / 2.0)
    message.pose.pose.orientation.w = math.cos(yaw / 2.0)
    message.twist.twist.linear.x = v
    return message


def circle(radius=2.0, count=400):
    angle = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


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


def test_birdseye_shows_the_path_at_its_position():
    recorder = Recorder()
    recorder.phase = "cruise"
    for index in range(11):
        recorder.callback(odometry(index, -1.0 + 0.2 * index, 0.5, 0.0))
    track = SimpleNamespace(
        centreline=circle(2.0),
        inner=circle(1.6),
        outer=circle(2.4),
        extent=(-3.0, 3.0, -3.0, 3.0),
        texture="/no/such/texture.png",
    )
    image = results.render(track, recorder.samples, width=800)
    view = results.View(track.extent, 800)
    column, row = view.pixels([(0.5, 0.5)])[0]
    assert tuple(image[row, column]) == results.COLORS[1]
    assert image.shape == view.shape

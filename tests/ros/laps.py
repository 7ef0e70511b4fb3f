"""Whole laps as ./run lap drives them, each on a master of its own."""

import json
import os
import shutil
import subprocess
import tempfile
import unittest

import cv2
import numpy as np
from paddock_common.process import free_port, stop_session

SMALL = """points: [[0, 0], [0.6, 0], [1.3, 0.75], [0.6, 1.5], [-0.4, 1.5], [-1.1, 0.75], [-0.4, 0]]
width: 0.6
"""
SMALL_LENGTH = 6.4  # of its centreline [m]
LOOP = ("/cmd_vel", "/racecar/left_rear_wheel_velocity_controller/command")
LIMIT = 480.0  # wall time of one lap with its start and end [s]


def open_route():
    """N x 6 of a course of 5 m with a bend each way, in DeepRacer's form, points repeated."""
    x = np.linspace(0.0, 4.8, 60)
    center = np.stack([x, 0.4 * np.sin(1.1 * x)], axis=1)
    ahead = np.gradient(center, axis=0)
    left = ahead[:, ::-1] * (-1.0, 1.0) / np.linalg.norm(ahead, axis=1)[:, None]
    array = np.hstack([center, center + 0.35 * left, center - 0.3 * left])
    return np.repeat(array, 1 + (np.arange(60) % 7 == 0), axis=0)


def lap(folder, pace, **arguments):
    """Runs lap.launch on a master of its own; returns result.json.

    Args:
        pace: Words of paced().
    """
    port = free_port()
    environment = dict(
        os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{port}", QT_QPA_PLATFORM="offscreen"
    )
    command = [
        "roslaunch",
        "-p",
        str(port),
        "deepracer_teleop",
        "lap.launch",
        *pace,
        f"out_dir:={folder}",
        "camera_width:=320",
        "camera_height:=240",
        *(f"{name}:={value}" for name, value in arguments.items()),
    ]
    process = subprocess.Popen(
        command, env=environment, stdin=subprocess.DEVNULL, start_new_session=True
    )
    try:
        process.wait(LIMIT)
    finally:
        stop_session(process, LIMIT)
    with open(os.path.join(folder, "result.json"), encoding="utf-8") as stream:
        return json.load(stream)


class LapCase(unittest.TestCase):
    """A folder for the files of a lap."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="lap_run_")
        self.addCleanup(shutil.rmtree, self.folder)

    def small_track(self):
        """Path of a small oval's file."""
        track = os.path.join(self.folder, "small.yaml")
        with open(track, "w", encoding="utf-8") as stream:
            stream.write(SMALL)
        return track

    def check_files(self, frames):
        """The film, the pictures and the tables are there and belong to this lap."""
        for name in ("lap.mp4", "lap.png", "path.png", "path.csv", "referee.csv"):
            path = os.path.join(self.folder, name)
            self.assertGreater(os.path.getsize(path), 1000, name)
        video = cv2.VideoCapture(os.path.join(self.folder, "lap.mp4"))
        self.assertEqual((video.get(3), video.get(4)), (320, 240))
        codec = int(video.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little")
        self.assertIn(codec, (b"h264", b"avc1"))  # which browsers play
        self.assertEqual(int(video.get(cv2.CAP_PROP_FRAME_COUNT)), frames)

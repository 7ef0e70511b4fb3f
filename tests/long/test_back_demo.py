"""The backing demonstration as a user starts it: it arrives, ends and leaves its three files."""

import json
import os
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

from paced import paced

LAUNCH = "<launch></launch>"  # a ROS master

DEADLINE = 400.0  # wall time of the whole demonstration on a loaded machine [s]
STOP_LIMIT = 90.0  # wall time from SIGINT to its end [s]
SIZE = "1.0 4.0"  # offset and length of the S [m]
SPEED = 0.5  # [m/s]
BESIDE = 0.10  # the project asks for less [m]


def run_demo(folder):
    """Runs the launch file to its end.

    Returns:
        (exit status, what it printed).
    """
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    process = subprocess.Popen(
        [
            "roslaunch",
            "--wait",
            "cybertruck",
            "back_demo.launch",
            *paced("/odom", "/cmd_cyberdrive"),
            "shape:=s",
            f"size:={SIZE}",
            f"speed:={SPEED}",
            f"out_dir:={folder}",
        ],
        env=environment,
        text=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )
    try:
        output, _ = process.communicate(timeout=DEADLINE)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGINT)
        try:
            output, _ = process.communicate(timeout=STOP_LIMIT)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            output, _ = process.communicate()
        raise AssertionError(f"no end within {DEADLINE:g} s:\n{output}") from None
    return process.returncode, output


class BackDemo(unittest.TestCase):
    """One drive; each test looks at one file."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="back_demo_")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name) / "made" / "by_it"
        cls.status, cls.output = run_demo(cls.folder)

    def setUp(self):
        self.assertEqual(self.status, 0, self.output)

    def figures(self):
        return json.loads((self.folder / "back_s.json").read_text(encoding="utf-8"))

    def test_three_files_and_nothing_else(self):
        self.assertEqual(
            sorted(path.name for path in self.folder.iterdir()),
            ["back_s.csv", "back_s.json", "back_s.png"],
        )  # what is in them: test_trailer_report.py

    def test_figures(self):
        figures = self.figures()
        self.assertEqual(
            (figures["ok"], figures["shape"], figures["message"]), (True, "s", "arrived")
        )
        self.assertLess(figures["max_lateral_error_m"], BESIDE)
        self.assertLess(figures["end_distance_m"], BESIDE)
        self.assertLess(abs(figures["end_heading_error_deg"]), 3.0)

"""The bench's worlds beside Gazebo: one is measured, and its robot's path is recorded."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from testing import enter_class_context

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

import paths_beside_gazebo  # noqa: E402
from launching import Launch  # noqa: E402
from sections import beside_gazebo  # noqa: E402
from worlds import causes  # noqa: E402

RECORD = BENCH / "paths" / "record.py"
LIMIT = 300.0  # wall time of a recording [s]
REAL_TIME = "config: {doubles: [{name: max_update_rate, value: 1000.0}]}"  # steps of 1 ms a second
CIRCLE = {"linear": {"x": 0.4}, "angular": {"z": 0.8}}
DRIVES = {
    "model": "robot",
    "plan": [["turn", 2.0, [["/cmd_vel", "geometry_msgs/Twist", CIRCLE]]], ["after", 0.5, []]],
}


class Causes(unittest.TestCase):
    """One launch: the robot with a lidar among posts."""

    @classmethod
    def setUpClass(cls):
        cls.folder = enter_class_context(cls, tempfile.TemporaryDirectory())
        file = causes.write(cls.folder, "lidar")
        log = enter_class_context(cls, open(os.path.join(cls.folder, "log"), "w"))
        arguments = [f"world_name:={file}", "gui:=false"]
        launched = "gazebo_ros", "empty_world.launch"
        cls.launch = enter_class_context(cls, Launch(log, arguments, launched))

    def call(self, service, *request):
        """Calls one of the simulator's services."""
        subprocess.run(
            ["rosservice", "call", f"/gazebo/{service}", *request],
            env=self.launch.environment,
            timeout=LIMIT,
            check=True,
            stdout=subprocess.DEVNULL,
        )

    def record(self, plan):
        """Runs record.py with a plan; the process and its output file."""
        path, output = (Path(self.folder, name) for name in ("plan.json", "robot.paddock.json"))
        path.write_text(json.dumps(plan))
        done = subprocess.run(
            [sys.executable, RECORD, path, output],
            env=self.launch.environment,
            text=True,
            capture_output=True,
            timeout=LIMIT,
            check=False,
        )
        return done, output

    def test_1_a_world_is_measured(self):
        observer = self.launch.observer("paces.world", "lidar")
        figures = beside_gazebo.measure_world(observer, 0.5, 2)
        observer.close()
        self.assertEqual(figures["pairs"], 2)
        self.assertGreater(figures["ratio"]["least"], 0.0)
        self.assertEqual(set(figures["messages_over_bare"]), {"/odom", "/tf", "/scan"})
        self.assertAlmostEqual(figures["speed_m_s"], causes.SPEED, delta=0.02)

    def test_2_a_path_is_recorded(self):
        self.call("set_parameters", REAL_TIME)  # else a path has as many states as the machine lets
        self.call("unpause_physics")  # the observer has paused
        done, output = self.record(DRIVES)
        self.assertEqual(done.returncode, 0, done.stderr)
        paths = json.loads(output.read_text())["paths"]
        self.assertEqual(list(paths), ["turn", "after"])
        rows = paths["turn"]
        self.assertGreaterEqual(rows[-1][0], rows[0][0] + 2.0)
        self.assertGreater(len(rows), 10)
        motion = paths_beside_gazebo.motion_of(rows)
        self.assertAlmostEqual(motion.speed, 0.4, delta=0.02)
        self.assertAlmostEqual(motion.rate, 0.8, delta=0.08)

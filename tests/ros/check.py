#!/usr/bin/env python3
"""./run check on launch files of many styles: what comes up, as JSON, page and exit status."""

import json
import os
import subprocess
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import rostest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "tests" / "drop_in" / "yard_fleet"
LIMIT = 400.0  # wall time of one check [s]
AT_ONCE = 2
STYLES = {  # file -> topics of its robots' sensors
    "ghosts": set(),
    "skid": {"/odom", "/imu/data", "/navsat/fix", "/magnetic", "/sonar/front"},
    "scout": {"/odom", "/velodyne_points"},
    "sledge": {"/odom", "/range"},
    "tug": set(),
}


def check(*words):
    """Runs ./run check on a launch file of the package; returns the finished process."""
    environ = dict(os.environ, ROS_PACKAGE_PATH=f"{os.environ['ROS_PACKAGE_PATH']}:{PACKAGE}")
    return subprocess.run(
        [ROOT / "run", "check", PACKAGE.name, *words],
        env=environ,
        text=True,
        capture_output=True,
        timeout=LIMIT,
        check=False,
    )


class Check(unittest.TestCase):
    """All files are checked once, two at a time."""

    @classmethod
    def setUpClass(cls):
        with ThreadPoolExecutor(AT_ONCE) as pool:
            running = {
                name: pool.submit(check, f"{name}.launch", "--seconds", "2", "--json")
                for name in STYLES
            }
            cls.page = pool.submit(check, "ferry.launch").result()
            cls.done = {name: future.result() for name, future in running.items()}

    def found(self, name):
        done = self.done[name]
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return json.loads(done.stdout)

    def model(self, file, name):
        return next(model for model in self.found(file)["models"] if model["name"] == name)

    def test_every_style_holds_what_it_should(self):
        wrong = []
        for name, topics in STYLES.items():
            found = self.found(name)
            sensors = [sensor for model in found["models"] for sensor in model["sensors"]]
            wrong += [f"{name}: {problem}" for problem in found["problems"]]
            if {sensor["topic"] for sensor in sensors} != topics:
                wrong.append(f"{name}: {sensors}")
            for sensor in sensors:  # a message more or less within 2 s, and slack
                if abs(sensor["measured"] / sensor["rate"] - 1.0) > 0.1 + 1.0 / sensor["rate"]:
                    wrong.append(f"{name}: {sensor}")
        self.assertEqual(wrong, [])

    def test_cars_with_masks_of_their_own_stand_in_one_place(self):
        for name in ("red", "green", "blue"):
            car = self.model("ghosts", name)
            x, y, z = car["after"]["position"]
            self.assertAlmostEqual(x, 1.0, delta=0.01)
            self.assertAlmostEqual(y, 0.0, delta=0.01)
            self.assertAlmostEqual(z, 0.0, delta=0.01)
            self.assertEqual({state for _, _, state in car["controllers"]}, {"running"})

    def test_controllers_of_a_base_behind_twist_mux(self):
        names = {(name, state) for name, _, state in self.model("tug", "tug")["controllers"]}
        self.assertEqual(
            names,
            {("joint_state_controller", "running"), ("mobile_base_controller", "running")},
        )

    def test_broken_values_are_told_by_cause(self):
        found = self.found("sledge")
        told = found["warnings"] + self.model("sledge", "sledge")["warnings"]
        self.assertTrue(any("not well-formed XML" in line for line in told), told)
        self.assertTrue(any("values are not usable" in line for line in told), told)
        self.assertLess(len(told), 12)

    def test_what_cannot_start_is_named_on_the_page(self):
        self.assertEqual(self.page.returncode, 1, self.page.stdout + self.page.stderr)
        self.assertIn("1 problem:", self.page.stdout)
        self.assertIn("yard_ferry_description", self.page.stdout)


if __name__ == "__main__":
    rostest.rosrun("paddock_tests", "check", Check)

#!/usr/bin/env python3
"""./run check on launch files of many styles: what comes up, as JSON, page and exit status."""

import json
import os
import subprocess
import sys
import unittest
from pathlib import Path

import rostest

ROOT = Path(__file__).resolve().parents[2]
DROP_IN = ROOT / "tests" / "drop_in"
FLEET = "yard_fleet"
LIMIT = 400.0  # wall time of one check [s]
FIRST = {  # file -> topics of its robots' sensors
    "skid": {"/odom", "/imu/data", "/navsat/fix", "/magnetic", "/sonar/front"},
    "sledge": {"/odom", "/range"},
    "crab": {"/stereo/left/image_raw", "/stereo/right/image_raw", "/fisheye/image_raw", "/truth"},
}
OTHERS = {
    "ghosts": set(),
    "scout": {"/odom", "/velodyne_points"},
    "tug": set(),
    "arm": set(),
    "depot": {
        "/north/bumper",
        "/north/odom",
        "/north_camera/color/image_raw",
        "/north_camera/infra1/image_raw",
        "/north_camera/infra2/image_raw",
        "/north_camera/depth/image_raw",
    },
    "namespaced_world": set(),
    "paused_start": set(),
}
CAMPUS = {"namespaced_world", "paused_start"}  # of the package campus_rover, the others of FLEET


def check(name, *words):
    """Runs ./run check on a launch file; returns the finished process."""
    environ = dict(os.environ, ROS_PACKAGE_PATH=f"{os.environ['ROS_PACKAGE_PATH']}:{DROP_IN}")
    package = "campus_rover" if name in CAMPUS else FLEET
    return subprocess.run(
        [ROOT / "run", "check", package, f"{name}.launch", *words],
        env=environ,
        text=True,
        capture_output=True,
        timeout=LIMIT,
        check=False,
    )


class Rig(unittest.TestCase):
    """Each file is checked once."""

    STYLES = FIRST

    @classmethod
    def setUpClass(cls):
        cls.done = {name: check(name, "--seconds", "2", "--json") for name in cls.STYLES}

    def found(self, name):
        done = self.done[name]
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return json.loads(done.stdout)

    def model(self, file, name):
        return next(model for model in self.found(file)["models"] if model["name"] == name)

    def test_every_style_holds_what_it_should(self):
        wrong = []
        for name, topics in self.STYLES.items():
            found = self.found(name)
            sensors = [sensor for model in found["models"] for sensor in model["sensors"]]
            wrong += [f"{name}: {problem}" for problem in found["problems"]]
            if {sensor["topic"] for sensor in sensors} != topics:
                wrong.append(f"{name}: {sensors}")
            for sensor in sensors:  # a message more or less within 2 s, and slack
                share = (sensor["measured"] or 0.0) / sensor["rate"]
                slack = 0.1 + 1.0 / sensor["rate"]
                enough = share > 0.0 if sensor["is_camera"] else share > 1.0 - slack
                if not enough or share > 1.0 + slack:  # a busy machine draws fewer pictures
                    wrong.append(f"{name}: {sensor}")
        self.assertEqual(wrong, [])

    def check_controllers(self, name, model, kinds):
        controllers = self.model(name, model)["controllers"]
        self.assertEqual({state for _, _, state in controllers}, {"running"})
        self.assertLessEqual(kinds, {kind.rpartition("/")[2] for _, kind, _ in controllers})


class Others(Rig):
    """What is long."""

    STYLES = OTHERS

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

    def test_controllers_of_an_arm_run(self):
        kinds = {"JointTrajectoryController", "GripperActionController"}
        self.check_controllers("arm", "crane", kinds)


class Check(Rig):
    """What each run checks."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.page = check("ferry")

    def test_controllers_of_four_steered_wheels_run(self):
        self.check_controllers("crab", "crab", {"FourWheelSteeringController"})

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
    kinds = {kind.__name__: kind for kind in (Check, Others)}
    rostest.rosrun("paddock_tests", sys.argv[1].lower(), kinds[sys.argv[1]])

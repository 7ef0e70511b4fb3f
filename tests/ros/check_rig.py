"""./run check on launch files of many styles: what comes up, as JSON, page and exit status."""

import json
import os
import subprocess
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DROP_IN = ROOT / "tests" / "drop_in"
FLEET = "yard_fleet"
LIMIT = 400.0  # wall time of one check [s]
FIRST = {  # file -> topics of its robots' sensors
    "sledge": {"/odom", "/range"},
}
OTHERS = {
    "skid": {"/odom", "/imu/data", "/navsat/fix", "/magnetic", "/sonar/front"},
    "crab": {"/stereo/left/image_raw", "/stereo/right/image_raw", "/fisheye/image_raw", "/truth"},
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
LACKS = {  # file -> its problems
    "sledge": ["mesh package://yard_fleet/meshes/gone & lost.dae is missing and left out"],
    "paused_start": ["mesh package://campus_rover/meshes/lost_cover.STL is missing and left out"],
}
CAMPUS = {"namespaced_world", "paused_start"}  # of the package campus_rover, the others of FLEET


def package_of(name):
    """The package of a launch file."""
    return "campus_rover" if name in CAMPUS else FLEET


def environ():
    """Environment in which the packages of the launch files are found."""
    return dict(os.environ, ROS_PACKAGE_PATH=f"{os.environ['ROS_PACKAGE_PATH']}:{DROP_IN}")


def check(name, *words):
    """Runs ./run check on a launch file; returns the finished process."""
    return subprocess.run(
        [ROOT / "run", "check", package_of(name), f"{name}.launch", *words],
        env=environ(),
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
        self.assertEqual(done.returncode, int(name in LACKS), done.stdout + done.stderr)
        return json.loads(done.stdout)

    def model(self, file, name):
        return next(model for model in self.found(file)["models"] if model["name"] == name)

    def test_every_check_leaves_a_replay(self):
        for name in self.STYLES:
            path = Path(self.found(name)["replay"])
            self.assertEqual(path, ROOT / "out" / "check" / package_of(name) / f"{name}.html")
            text = path.read_text()
            self.assertTrue(text.startswith("<!doctype html>"))
            self.assertIn("window.REPLAY = ", text)
            self.assertLess(path.stat().st_size, 10_000_000)

    def test_every_style_holds_what_it_should(self):
        wrong = []
        for name, topics in self.STYLES.items():
            found = self.found(name)
            sensors = [sensor for model in found["models"] for sensor in model["sensors"]]
            if found["problems"] != LACKS.get(name, []):
                wrong.append(f"{name}: {found['problems']}")
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

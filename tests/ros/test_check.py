"""./run check on launch files of many styles: what comes up, as JSON, page and exit status."""

import subprocess
import time
import unittest
import uuid

import check_rig
from check_rig import check

from commands import procfs
from commands.check_observer import BY_SERVICES


class Check(check_rig.Rig):
    """What each run checks."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.page = check("ferry")

    def test_broken_values_are_told_by_cause(self):
        found = self.found("sledge")
        told = found["warnings"] + self.model("sledge", "sledge")["warnings"]
        self.assertTrue(any("not well-formed XML" in line for line in told), told)
        self.assertTrue(any("values are not usable" in line for line in told), told)
        self.assertLess(len(told), 12)

    def test_what_commands_a_robot_is_known(self):
        sledge = self.model("sledge", "sledge")
        self.assertEqual((sledge["commands"], sledge["driven_by"]), (["/cmd_vel"], [BY_SERVICES]))
        self.assertEqual(sledge["joints"], 0)
        ((cause, items),) = sledge["missing"].items()
        self.assertEqual(cause, "meshes are missing and left out")
        self.assertEqual(items, ["package://yard_fleet/meshes/gone & lost.dae"])

    def test_what_cannot_start_is_named_on_the_page(self):
        self.assertEqual(self.page.returncode, 1, self.page.stdout + self.page.stderr)
        first = self.page.stdout.partition("\n")[0]
        self.assertTrue(first.startswith("does not work because roslaunch refuses"), first)
        self.assertIn("yard_ferry_description", first)
        self.assertNotIn("problem", self.page.stdout)


class Killed(unittest.TestCase):
    """A check that does not come to its end."""

    def test_it_leaves_nothing_running(self):
        mark = uuid.uuid4().hex
        process = subprocess.Popen(
            [
                check_rig.ROOT / "run",
                "check",
                check_rig.FLEET,
                "sledge.launch",
                "--seconds",
                "3600",
            ],
            env=dict(check_rig.environ(), OF_THIS_TEST=mark),
            stdout=subprocess.DEVNULL,
        )

        def wait(is_over):
            deadline = time.monotonic() + check_rig.LIMIT
            while not is_over(names := self._programs(mark)):
                self.assertLess(time.monotonic(), deadline, names)
                time.sleep(0.2)

        wait(lambda names: "gazebo" in names)
        process.kill()
        process.wait()
        wait(lambda names: not names)

    @staticmethod
    def _programs(mark):
        """Names of this test's processes."""
        pids = procfs.marked("OF_THIS_TEST", mark)
        return [procfs.program(procfs.arguments(pid)) for pid in pids]

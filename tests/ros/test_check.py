"""./run check on launch files of many styles: what comes up, as JSON, page and exit status."""

import check_rig
from check_rig import check


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
        self.assertEqual((sledge["commands"], sledge["driven_by"]), (["/cmd_vel"], []))
        ((cause, items),) = sledge["missing"].items()
        self.assertEqual(cause, "meshes are missing and left out")
        self.assertEqual(items, ["package://yard_fleet/meshes/gone & lost.dae"])

    def test_what_cannot_start_is_named_on_the_page(self):
        self.assertEqual(self.page.returncode, 1, self.page.stdout + self.page.stderr)
        first = self.page.stdout.partition("\n")[0]
        self.assertTrue(first.startswith("does not work because roslaunch refuses"), first)
        self.assertIn("yard_ferry_description", first)
        self.assertNotIn("problem", self.page.stdout)

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

    def test_what_cannot_start_is_named_on_the_page(self):
        self.assertEqual(self.page.returncode, 1, self.page.stdout + self.page.stderr)
        self.assertIn("1 problem:", self.page.stdout)
        self.assertIn("yard_ferry_description", self.page.stdout)

"""The drive node refuses wrong parameters: it ends with 1 and names parameter, value and choice."""

import subprocess
import unittest

from testing import executable

LAUNCH = "<launch></launch>"  # a ROS master


DEADLINE = 120.0  # wall time for a node to refuse [s]


class TruckRefuse(unittest.TestCase):
    """Starts the node as a user would."""

    def refuse(self, parameter, *words):
        """Starts a drive node with one parameter and searches its output for words."""
        name = "drive" + parameter.split(":=")[0]  # parameters stay with the name
        done = subprocess.run(
            [executable("cybertruck", "drive"), parameter, "__name:=" + name],
            text=True,
            check=False,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=DEADLINE,
        )
        self.assertEqual(done.returncode, 1, done.stdout)
        for word in words:
            self.assertIn(word, done.stdout)
        self.assertNotIn("Traceback", done.stdout)

    def test_wrong_parameters(self):
        for parameter, *words in (
            ("_odom_source:=gps", "odom_source is 'gps'", "wheels, ground_truth"),
            ("_wheelbase:=-0.5", "wheelbase is -0.5", "above 0"),
            ("_start_x:=here", "start_x is 'here'", "must be a number"),
            ("_joy:=maybe", "joy is 'maybe'", "true or false"),
        ):
            self.refuse(parameter, *words)

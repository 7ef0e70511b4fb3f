"""The bench alternates a launched world with bare stepping; what it counts is checked."""

import os
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from sections import efficiency  # noqa: E402

PAIRS = 2
SECONDS = 1.0  # of a round


class BenchFree(unittest.TestCase):
    """One variant: the car of effort controllers, whose bare world has another description."""

    def test_a_variant_gives_all_its_figures(self):
        variant = efficiency.VARIANTS["six_effort_pids"]
        with open(os.devnull, "w") as log:
            figures = efficiency.measure_variant(variant, SECONDS, PAIRS, log)
        self.assertEqual(figures["pairs"], PAIRS)
        self.assertEqual(figures["step_s"], 0.001)
        self.assertGreater(figures["ratio"]["least"], 0.0)
        for role in ("bridge", "relay", "rosmaster", "observer"):
            self.assertIn(role, figures["spent"]["cpu"])
        self.assertGreater(figures["spent"]["cpu"]["bridge"], 0.0)
        self.assertEqual(set(figures["received_per_sim_s"]), set(efficiency.TOPICS))
        joint_states = figures["received_per_sim_s"]["/racecar/joint_states"]
        self.assertAlmostEqual(joint_states, 50.0, delta=25.0)
        (row, *_) = efficiency.rows({"six_effort_pids": figures})
        self.assertIn("of bare stepping, 2 pairs", row.text)

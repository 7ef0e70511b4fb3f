#!/usr/bin/env python3
"""The other drivers through ./run lap's launch file: by the camera alone, and by the buttons."""

import rospy
import rostest
from lap_run import LOOP, SMALL_LENGTH, LapCase, lap
from paced import paced


class LapDrivers(LapCase):
    """Each test is one launch."""

    def test_line(self):
        result = lap(self.folder, paced(*LOOP, lag=0.1), driver="line", track=self.small_track())
        self.assertTrue(result["ok"], result["error"])
        [start] = result["starts"]
        self.assertEqual((start["outcome"], start["penalty"]), ("lap", 0.0))
        self.assertLess(start["mean_lateral_error"], 0.05)
        # 0.6 m/s on straights, slower in bends; corners are cut a little
        self.assertGreater(start["lap_time"], 0.95 * SMALL_LENGTH / 0.62)
        self.assertLess(start["lap_time"], 1.05 * SMALL_LENGTH / 0.4)
        self.check_files(result["film_frames"])

    def test_buttons(self):
        result = lap(self.folder, (), driver="buttons", track="easy", roam=15.0, real_time_factor=2)
        self.assertTrue(result["ok"], result["error"])
        [start] = result["starts"]
        self.assertEqual(start["outcome"], "roamed")
        self.assertGreater(start["driven"], 1.0)
        self.check_files(result["film_frames"])


if __name__ == "__main__":
    rospy.init_node("lap_drivers_test")
    rostest.rosrun("paddock_tests", "lap_drivers", LapDrivers)

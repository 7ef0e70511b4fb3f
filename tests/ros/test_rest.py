"""A car at rest stays where it is."""

import math
import unittest

from nav_msgs.msg import Odometry
from shared_worlds import CAR as LAUNCH  # noqa: F401
from sim_client import Recorder, turned, yaw_of
from stepping import Time

SETTLE = 2.0  # simulated time [s]
DURATION = 20.0  # simulated time [s]
CREEP = 0.001  # [m] a minute
TURN = 0.1  # [deg] a minute


class Rest(unittest.TestCase):
    """Watches the car without any command."""

    def test_it_creeps_less_than_a_millimeter_a_minute(self):
        odometry = Recorder("/racecar/odom", Odometry)
        time = Time(topics=[odometry.topic])
        self.addCleanup(time.close)
        time.go(SETTLE)
        before = time.latest(odometry)
        time.go(DURATION)
        after = time.latest(odometry)
        old, new = before.pose.pose, after.pose.pose
        creep = math.dist(
            (old.position.x, old.position.y, old.position.z),
            (new.position.x, new.position.y, new.position.z),
        )
        turn = math.degrees(turned(yaw_of(old.orientation), yaw_of(new.orientation)))
        print(f"creep {1000 * creep:.4f} mm, turn {turn:.5f} deg in {DURATION:g} s")
        self.assertLess(creep, CREEP * DURATION / 60.0)
        self.assertLess(abs(turn), TURN * DURATION / 60.0)

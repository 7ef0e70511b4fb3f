"""pause_physics, unpause_physics, reset_simulation and reset_world."""

import math
import time
import unittest

import rospy
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from shared_worlds import CAR as LAUNCH  # noqa: F401
from sim_client import (
    WHEELS,
    Recorder,
    command_publishers,
    sleep_sim,
    wait_for_car,
    wait_until,
    world_time,
)
from std_srvs.srv import Empty


class Pause(unittest.TestCase):
    """Calls the services and watches /clock and the car's place."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        cls.clock = Recorder("/clock", Clock)
        cls.odometry = Recorder("/racecar/odom", Odometry)
        cls.odometry.wait_count(1)
        cls.publishers = command_publishers()
        sleep_sim(1.0)
        cls.start = cls.odometry.next().pose.pose.position

    def tearDown(self):
        self.call("unpause_physics")
        self.drive(0.0)

    def call(self, name, kind=Empty):
        rospy.wait_for_service("/gazebo/" + name, timeout=120.0)
        return rospy.ServiceProxy("/gazebo/" + name, kind)()

    def drive(self, speed):
        for wheel in WHEELS:
            self.publishers[wheel].publish(speed)

    def distance_from_start(self):
        place = self.odometry.last.pose.pose.position
        return math.hypot(place.x - self.start.x, place.y - self.start.y)

    def test_pause_freezes_the_clock_and_unpause_goes_on(self):
        for _ in range(2):  # is as once
            self.call("pause_physics")
        now = world_time()
        wait_until(lambda: self.clock.newest.clock.to_sec() > now - 1e-6, "/clock of the pause")
        frozen = self.clock.last.clock
        time.sleep(1.0)
        self.assertEqual(self.clock.last.clock, frozen)
        self.assertAlmostEqual(
            world_time(),
            frozen.to_sec(),
            delta=1e-6,
            msg="services answer while paused",
        )
        self.call("unpause_physics")
        wait_until(lambda: self.clock.last.clock > frozen, "/clock going on")
        first = next(message.clock for message in self.clock.messages if message.clock > frozen)
        self.assertLess((first - frozen).to_sec(), 0.1, "/clock goes on where it stopped")

    def test_a_command_sent_while_paused_counts_afterwards(self):
        self.call("pause_physics")
        before = self.distance_from_start()
        self.drive(10.0)
        time.sleep(0.5)
        self.assertAlmostEqual(self.distance_from_start(), before, delta=1e-3)
        self.call("unpause_physics")
        wait_until(lambda: abs(self.distance_from_start() - before) > 0.05, "the car moving")

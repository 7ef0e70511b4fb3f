"""Launch files with the oddities of published ones: torques, a fall, a stiff car."""

import math

from harbour_rig import HarbourCase, forward
from sim_client import sleep_sim, wait_until


class Harbour(HarbourCase):
    """Each test is one launch file."""

    def test_skid_steering_with_a_torque_reaches_its_speed(self):
        launched = self.launch("porter.launch")
        self.wait_model(launched, "porter")
        command = self.publisher("/cmd_vel")
        for speed in (0.5, -0.5):
            command.publish(forward(speed))
            sleep_sim(2.0)
            self.assertAlmostEqual(self.state("porter").twist.linear.x, speed, delta=0.025)

    def test_a_mass_without_an_inertia_falls_through_the_ground(self):
        launched = self.launch("stacker.launch")
        self.wait_model(launched, "stacker")
        wait_until(lambda: self.state("stacker").pose.position.z < -5.0, "the fall")
        self.assertIn("<box_inertia> a macro without 'xacro:'", launched.output())

    def test_a_stiff_car_whose_body_arches_over_its_wheels_stays_where_it_is(self):
        launched = self.launch("crane.launch")
        self.wait_model(launched, "crane")
        self.wait_running("/crane", "front_left_steer", "rear_right_axle")
        sleep_sim(1.0)
        before = self.state("crane").pose.position
        sleep_sim(3.0)
        after = self.state("crane")
        way = math.dist((before.x, before.y), (after.pose.position.x, after.pose.position.y))
        self.assertLess(way, 0.01)
        self.assertLess(abs(after.pose.position.z), 0.02)
        self.assertLess(abs(after.twist.angular.z), 0.01)

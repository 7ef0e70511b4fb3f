"""Launch files with the oddities of published ones: what drives, what is on the wire, a fall."""

import math

import rosservice
from harbour_rig import HarbourCase, forward, lengths
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, JointState, LaserScan, Range
from sim_client import sleep_sim, wait_until
from std_msgs.msg import String


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

    def test_four_cad_wheels_in_the_root_namespace_and_a_script_for_usr_bin_python(self):
        launched = self.launch("flatbed.launch")
        self.wait_model(launched, "/")
        self.wait_running("", "joint_state_controller", "drive")
        states, odometry = (
            self.record("/joint_states", JointState),
            self.record("/drive/odom", Odometry),
        )
        horn = self.record("/horn", String)
        command = self.publisher("/drive/cmd_vel")
        states.wait_count(1)
        odometry.wait_count(1)

        def at_speed():  # told while it is commanded: the controller has a time-out
            command.publish(forward(0.5))
            wheels = [speed for item in states.messages[-20:] for speed in item.velocity]
            bodies = self.state("/").twist, odometry.last.twist.twist
            return all(abs(speed - 5.0) < 0.25 for speed in wheels) and all(
                abs(twist.linear.x - 0.5) < 0.025 for twist in bodies
            )

        wait_until(at_speed, "0.5 m/s of the wheels, the body and the odometry")
        self.assertEqual(states.last.name, ["front_left", "front_right", "rear_left", "rear_right"])
        self.assertEqual(lengths(states.last), [4, 4, 4])
        wait_until(lambda: horn.last is not None, "the script's message")
        self.assertNotIn("died", launched.output())

    def test_sensors_and_joint_states_are_on_the_wire_as_in_gazebo(self):
        launched = self.launch("pilot.launch")
        self.wait_model(launched, "pilot")
        self.wait_running("", "joint_state_controller")
        scans, images = self.record("/scan", LaserScan), self.record("/eye/image_raw", Image)
        states = self.record("/joint_states", JointState)
        of_plugin = self.record("/plugin/joint_states", JointState)
        sonar = self.record("/sonar", Range)
        for recorder in (scans, images, states, of_plugin):
            wait_until(lambda recorder=recorder: recorder.last is not None, "a message")
        self.assertEqual((len(scans.last.ranges), len(scans.last.intensities)), (410, 410))
        self.assertEqual((images.last.header.frame_id, images.last.width), ("", 160))
        self.assertEqual(states.last.name, ["left", "right", "rudder"])
        self.assertEqual(lengths(states.last), [3, 3, 3])
        self.assertEqual(of_plugin.last.name, ["left", "right"])
        self.assertEqual(lengths(of_plugin.last), [2, 2, 0])
        messages = sonar.wait_count(len(sonar.messages) + 6)
        seconds = (messages[-1].header.stamp - messages[0].header.stamp).to_sec()
        self.assertAlmostEqual((len(messages) - 1) / seconds, 10.0, delta=2.0)
        offered = rosservice.get_service_list()
        for name in ("/imu_service", "/imu/set_accel_bias", "/imu/set_rate_bias",
                     "/fix/set_reference_geopose"):  # fmt: skip
            self.assertIn(name, offered)

"""Launch files with the oddities of published ones: two that have most of them."""

import rosservice
from harbour_rig import HarbourCase, forward, lengths
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, JointState, LaserScan, Range
from sim_client import wait_until
from std_msgs.msg import String


class Harbour(HarbourCase):
    """Each test is one launch file."""

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

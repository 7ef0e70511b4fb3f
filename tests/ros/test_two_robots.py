"""Two robots in one world: each in its namespace, one drives alone, one goes, the other stays."""

import math
import unittest

import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState, LaserScan
from sim_client import (
    Recorder,
    joint,
    sleep_sim,
    wait_connected,
    wait_running,
    wait_until,
)
from std_msgs.msg import Float64

ROBOT = """
  <group ns="{0}">
    <param name="robot_description" textfile="$(find paddock_tests)/ros/models/small_car.urdf"/>
    <rosparam file="$(find paddock_tests)/ros/models/small_car.yaml"/>
    <node name="spawn" pkg="gazebo_ros" type="spawn_model" output="screen"
          args="-urdf -param robot_description -model {0} -y {1} -z 0.05"/>
    <node name="controllers" pkg="controller_manager" type="spawner" output="screen"
          args="--timeout 120 joints rear_left rear_right"/>
  </group>"""
LAUNCH = f"""<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="gui" value="false"/>
  </include>{ROBOT.format("car1", 1)}{ROBOT.format("car2", -1)}
  <param name="/gazebo/pub_clock_frequency" value="50.0"/>
</launch>
"""

CARS = ("car1", "car2")
RADIUS, SPEED = 0.05, 10.0  # of the wheels [m], [rad/s]


class TwoRobots(unittest.TestCase):
    """Both cars stay; a third one comes and goes."""

    @classmethod
    def setUpClass(cls):
        for car in CARS:
            wait_running(f"/{car}", 3)
        cls.odometry = {car: Recorder(f"/{car}/odom", Odometry) for car in CARS}
        cls.states = {car: Recorder(f"/{car}/joint_states", JointState) for car in CARS}
        cls.commands = {
            (car, side): rospy.Publisher(f"/{car}/rear_{side}/command", Float64, queue_size=1)
            for car in CARS
            for side in ("left", "right")
        }
        for key, publisher in cls.commands.items():
            wait_connected(publisher, "/".join(key))

    def drive(self, car, speed):
        for side in ("left", "right"):
            self.commands[car, side].publish(speed)

    def spin(self, car):
        """Speed of a wheel [rad/s]."""
        return abs(joint(self.states[car].next(), "rear_left_joint")[1])

    def place(self, car):
        position = self.odometry[car].next().pose.pose.position
        return position.x, position.y

    def test_each_has_its_topics_and_services_and_no_others(self):
        topics = {name for name, _ in rospy.get_published_topics()}
        for car in CARS:
            names = {f"/{car}/{name}" for name in ("scan", "odom", "imu", "joint_states")}
            self.assertLessEqual(names, topics)
            self.assertEqual(self.odometry[car].next().child_frame_id, "base_link")
            scan = Recorder(f"/{car}/scan", LaserScan)
            self.assertTrue(scan.next().header.frame_id.endswith("laser"))
            scan.close()
        self.assertIn("/shared/odom", topics, "an absolute topic stays as it is")
        self.assertFalse({"/scan", "/odom", "/imu", "/joint_states", "/car1/shared/odom"} & topics)

    def test_one_drives_and_the_other_stands(self):
        sleep_sim(0.2)  # a command of another test has arrived
        wait_until(lambda: math.dist(self.place("car2"), self.place("car2")) < 1e-5, "rest")
        before = self.place("car2")
        self.drive("car1", SPEED)
        sleep_sim(1.5)
        start = self.odometry["car1"].next()
        sleep_sim(1.0)
        end = self.odometry["car1"].next()
        begin, stop = start.pose.pose.position, end.pose.pose.position
        way = math.hypot(stop.x - begin.x, stop.y - begin.y)  # its wheels may have begun in turn
        seconds = (end.header.stamp - start.header.stamp).to_sec()
        self.assertAlmostEqual(way / seconds, SPEED * RADIUS, delta=0.03 * SPEED * RADIUS)
        self.assertAlmostEqual(self.spin("car1"), SPEED, delta=0.2)
        for axis in (0, 1):
            self.assertAlmostEqual(self.place("car2")[axis], before[axis], delta=1e-3)
        self.assertLess(self.spin("car2"), 0.05)
        self.drive("car1", 0.0)

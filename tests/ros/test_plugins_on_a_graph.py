"""Plugins on a real graph: topics and services of each kind arrive and tell."""

import unittest

import rospy
from bullet_bridge.services.attaching import FIELDS, attach_type
from gazebo_msgs.msg import ModelStates
from gazebo_msgs.srv import GetModelState, SpawnModel
from geometry_msgs.msg import Pose, Twist
from nav_msgs.msg import Odometry
from sim_client import START_LIMIT, Recorder, wait_connected
from std_msgs.msg import Bool
from std_srvs.srv import Empty
from urdf_texts import joint, link, robot

from bullet_bridge.srv import Step

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="world_name" value="$(find paddock_tests)/ros/plugins.world"/>
    <arg name="gui" value="false"/>
    <arg name="lockstep" value="true"/>
  </include>
</launch>
"""


def box(x, y, z):
    return f'<box size="{x} {y} {z}"/>'


def with_plugin(name, parts, library, **tags):
    inner = "".join(f"<{tag}>{text}</{tag}>" for tag, text in tags.items())
    plugin = f'<plugin name="p" filename="lib{library}.so">{inner}</plugin>' if library else ""
    return robot(parts, f"<gazebo>{plugin}</gazebo>", name=name)


BLOCK = link("base", 2.0, 0.02, box(0.2, 0.2, 0.2))
CRATE = link("base", 0.05, 1e-4, box(0.04, 0.04, 0.04))
ROBOTS = {  # name -> URDF, y and height where it is spawned
    "mover": (
        with_plugin("mover", BLOCK, "gazebo_ros_force_based_move", robotNamespace="mover",
              x_velocity_p_gain=1500, y_velocity_p_gain=1500, yaw_velocity_p_gain=5), 0, 0.1,
    ),
    "sucker": (
        with_plugin("sucker", '<link name="world"/>' + link("arm", 1.0, 0.01)
              + joint("f", "fixed", "world", "arm"),
              "gazebo_ros_vacuum_gripper", bodyName="arm", robotNamespace="sucker",
              topicName="grasping"), 10, 0.5,
    ),
    "crate": (robot(CRATE, name="crate"), 10, 0.47),
    "load": (robot(BLOCK, name="load"), 0, 0.1),  # behind the mover
}  # fmt: skip
COMMAND = Twist()
COMMAND.linear.x = 0.5


class PluginsOnAGraph(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.wait_for_service("/gazebo/step", START_LIMIT)
        cls.step = rospy.ServiceProxy("/gazebo/step", Step, persistent=True)
        cls.state = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState, persistent=True)
        spawn = rospy.ServiceProxy("/gazebo/spawn_urdf_model", SpawnModel)
        for name, (text, y, z) in ROBOTS.items():
            pose = Pose()
            pose.position.x = -0.4 if name == "load" else 0.0
            pose.position.y, pose.position.z, pose.orientation.w = y, z, 1.0
            answer = spawn(name, text, "", pose, "world")
            assert answer.success, answer.status_message
        cls.odometry = Recorder("/mover/odom", Odometry)
        cls.grasping = Recorder("/sucker/grasping", Bool)
        cls.states = Recorder("/gazebo/model_states", ModelStates)
        cls.drive = rospy.Publisher("/mover/cmd_vel", Twist, queue_size=1)
        wait_connected(cls.drive, "the plugin")

    def advance(self, steps, topics=()):
        answer = self.step(steps, list(topics), [1] * len(topics))
        self.assertTrue(answer.success, answer.status_message)

    def place(self, name):
        found = self.state(name, "world").pose.position
        return found.x, found.y, found.z

    def test_each_does_as_it_is_told(self):
        attach, detach = (
            rospy.ServiceProxy(f"/link_attacher_node/{name}", attach_type())
            for name in ("attach", "detach")
        )
        names = dict(zip(FIELDS, ("mover", "base", "load", "base")))
        self.assertFalse(detach(**names).ok)
        self.assertFalse(attach(**{**names, FIELDS[2]: "nobody"}).ok)
        self.assertTrue(attach(**names).ok)
        rospy.ServiceProxy("/sucker/on", Empty)()
        self.drive.publish(COMMAND)
        self.advance(600, ["/mover/cmd_vel"])
        self.assertAlmostEqual(self.place("crate")[2], 0.5, delta=0.04)  # it would lie on the floor
        before = {name: self.place(name) for name in ROBOTS}
        self.advance(1000)
        moved = {name: self.place(name)[0] - before[name][0] for name in ROBOTS}
        self.assertAlmostEqual(moved["mover"], 0.5, delta=0.12)
        self.assertAlmostEqual(moved["load"], moved["mover"], delta=0.02)
        self.assertTrue(self.grasping.newest.data)
        walker = self.place("walker")
        self.assertAlmostEqual(walker[0], 1.14, delta=0.1)  # of a cubic that begins at 0.5 m/s
        self.assertIn("walker", self.states.newest.name)
        self.assertAlmostEqual(self.odometry.newest.twist.twist.linear.x, 0.5, delta=0.1)

        self.assertTrue(detach(**names).ok)
        rospy.ServiceProxy("/sucker/off", Empty)()
        self.advance(1000)
        self.assertLess(self.place("crate")[2], 0.1)
        gap = self.place("mover")[0] - self.place("load")[0]
        self.assertGreater(gap, 0.7)  # the load stays behind

"""A world and a robot full of bad values: each costs itself and is said, the rest comes up."""

import pathlib
import unittest

import rospkg
import rospy
from gazebo_msgs.srv import GetModelState, GetWorldProperties
from sensor_msgs.msg import JointState
from sim_client import (
    NO_GAINS,
    Recorder,
    joint,
    sleep_sim,
    wait_connected,
    wait_running,
    wait_until,
)
from std_msgs.msg import Float64

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="world_name" value="$(find paddock_tests)/ros/broken.world"/>
    <arg name="use_sim_time" value="True "/>
    <arg name="gui" value="false"/>
    <arg name="missing_packages" value="warn"/>
  </include>
  <rosparam command="load" file="$(find paddock_tests)/ros/broken_bot.yaml" ns="bot"/>
  <node name="spawn" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-urdf -file $(find paddock_tests)/ros/broken_bot.urdf -model bot -y -3 -z 0.1"/>
  <node name="spawner" pkg="controller_manager" type="spawner" ns="/bot" output="screen"
        args="--timeout 90 joint_state_controller left right"/>
</launch>
"""

SPEED = 2.0  # [rad/s] of the wheels
RADIUS = 0.08  # [m]
# Words of the lines that the simulator has to say, and how often.
SAID = {
    "broken.world is not well-formed XML": 1,
    "2 included models cannot be used: 'model://castle', 'model://moat & bridge'": 1,
    "world plugin 'libweather.so'": 1,
    "3 meshes are missing and left out: model://castle/tower.dae": 1,
    "model 'no_link' is left out": 1,
    "joint 'j' of 'crate' has type 'glue'": 1,
    "joint 'k' of 'crate' joins 'link' and 'nothing'": 1,
    "'crate_1'": 1,
    "2 meshes are missing and left out: package://no_such_package/hood.dae": 1,
    "plugin 'libparty.so'": 1,
    "<xacro:property>": 1,
    "joint 'ghost'": 1,
    "legacyModeNS": 0,
    "maxVel": 0,
    "drake": 0,
    "image format 'RGB8'": 1,
}


def logged(level, files="*.log"):
    """The lines of a level in the log files of this run's nodes."""
    folder = pathlib.Path(rospkg.get_log_dir(), rospy.get_param("/run_id"))
    lines = [line for file in folder.glob(files) for line in file.read_text().splitlines()]
    return [line for line in lines if line.startswith(level)]


class BrokenValues(unittest.TestCase):
    """Looks at everything that has to be there in spite of them."""

    @classmethod
    def setUpClass(cls):
        wait_running("/bot", 3)

    def state(self, model):
        answer = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)(model, "world")
        self.assertTrue(answer.success, answer.status_message)
        return answer.pose.position

    def test_the_models_are_there(self):
        names = rospy.ServiceProxy("/gazebo/get_world_properties", GetWorldProperties)().model_names
        expected = {"ground_plane", "weightless", "five_numbers", "crate", "crate_1", "bot"}
        self.assertEqual(set(names), expected)

    def test_the_wheels_turn_and_the_bot_drives(self):
        states = Recorder("/bot/joint_states", JointState)
        publishers = [
            rospy.Publisher(f"/bot/{side}/command", Float64, queue_size=1)
            for side in ("left", "right")
        ]
        for publisher in publishers:
            wait_connected(publisher, "the controllers")
        start = self.state("bot").x
        for publisher in publishers:
            publisher.publish(SPEED)
        sleep_sim(2.0)
        for side in ("left", "right"):
            _, speed = joint(states.last, f"{side}_joint")
            self.assertAlmostEqual(speed, SPEED, delta=0.1)
        self.assertGreater(self.state("bot").x - start, 0.5 * 2.0 * SPEED * RADIUS)
        for publisher in publishers:
            publisher.publish(0.0)

    def test_each_cause_is_one_line(self):
        def warnings():
            return logged("[rosout][WARNING]", "gazebo-*.log")

        for words, count in SAID.items():
            if count:
                wait_until(lambda: any(words in line for line in warnings()), f"'{words}'")
            self.assertEqual(sum(words in line for line in warnings()), count, words)
        errors = logged("[rosout][ERROR]") + logged("[rosout][CRITICAL]")
        self.assertEqual([line for line in errors if NO_GAINS not in line], [])

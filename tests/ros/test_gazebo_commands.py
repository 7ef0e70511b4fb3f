"""gzserver's command line, and spawn_model with each of its flags and exit codes."""

import math
import os
import signal
import subprocess
import time
import unittest

import roslib.packages
import rospy
from gazebo_msgs.srv import (
    DeleteModel,
    GetJointProperties,
    GetModelState,
    GetPhysicsProperties,
    GetWorldProperties,
)
from gazebo_ros import gazebo_interface
from geometry_msgs.msg import Point, Pose, Quaternion
from rosgraph_msgs.msg import Clock, Log
from sim_client import START_LIMIT, Recorder, wait_until, world_time, yaw_of
from std_srvs.srv import Empty

LAUNCH = """<launch>
  <param name="/use_sim_time" value="true"/>
  <param name="robot_description" textfile="$(find paddock_tests)/ros/models/small_car.urdf"/>
  <node name="gazebo" pkg="gazebo_ros" type="gzserver" output="screen" respawn="false"
        args="-u -e ode --verbose -s libgazebo_ros_paths_plugin.so -s libother.so --seed 7
              $(find gazebo_ros)/worlds/shapes.world">
    <env name="GAZEBO_MODEL_PATH" value="$(find paddock_tests)/ros/models"/>
  </node>
  <node name="gazebo_gui" pkg="gazebo_ros" type="gzclient" output="screen"/>
</launch>
"""

SPAWN = roslib.packages.find_node("gazebo_ros", "spawn_model")[:1]
MODELS = os.path.join(os.path.dirname(__file__), "models")
CAR, BOX = f"{MODELS}/small_car.urdf", f"{MODELS}/box.sdf"
TAKEN = "Spawn status: SpawnModel: Failure - entity already exists."
LIMIT = 180.0  # of one command, wall time [s]


def call(name, kind, *values):
    """Calls a service below /gazebo."""
    rospy.wait_for_service("/gazebo/" + name, timeout=START_LIMIT)
    return rospy.ServiceProxy("/gazebo/" + name, kind)(*values)


def models():
    """Names of all models."""
    return call("get_world_properties", GetWorldProperties).model_names


def spawn(words, text=None):
    """Runs spawn_model to its end.

    Returns:
        (exit status, all that it printed).
    """
    done = subprocess.run(
        [*SPAWN, *words.split()],
        input=text,
        text=True,
        timeout=LIMIT,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    return done.returncode, done.stdout


class GazeboCommands(unittest.TestCase):
    """Each test finds the world paused."""

    @classmethod
    def setUpClass(cls):
        wait_until(lambda: "sphere" in models(), "the world of gzserver", START_LIMIT)
        cls.paused = call("get_physics_properties", GetPhysicsProperties).pause, world_time()

    def spawned(self, model, words, text=None):
        """Spawns, checks, and gives the model's state."""
        status, output = spawn(f"{words} -model {model}", text)
        self.assertEqual(status, 0, output)
        state = call("get_model_state", GetModelState, model, "")
        self.assertTrue(state.success, state.status_message)
        self.addCleanup(call, "delete_model", DeleteModel, model)
        return state

    def test_gzserver_took_its_arguments(self):
        self.assertLessEqual({"ground_plane", "box", "sphere", "cylinder"}, set(models()))
        self.assertEqual(self.paused, (True, 0.0), "-u")
        self.assertEqual(rospy.get_param("/gazebo/seed"), 7)

    def test_pose_and_frame(self):
        words = "-urdf -param /robot_description -x 1 -y -2 -z 0.5 -Y 1.5"
        state = self.spawned("placed", words)
        place = state.pose.position
        for value, expected in zip((place.x, place.y, place.z), (1.0, -2.0, 0.5)):
            self.assertAlmostEqual(value, expected, delta=1e-12)
        self.assertAlmostEqual(yaw_of(state.pose.orientation), 1.5, delta=1e-5)
        state = self.spawned("beside", f"-sdf -file {BOX} -reference_frame placed -x 3")
        self.assertAlmostEqual(state.pose.position.x, 1.0 + 3.0 * math.cos(1.5), delta=1e-5)
        self.assertAlmostEqual(state.pose.position.y, -2.0 + 3.0 * math.sin(1.5), delta=1e-5)

    def test_sources(self):
        log = Recorder("/rosout", Log)
        self.spawned("first", f"-urdf -file {CAR} -y 6")
        with open(CAR, encoding="utf-8") as stream:
            self.spawned("from_stdin", "-urdf -stdin -y 9", stream.read())
        words = "'first' has its controller_manager in the namespace '/'"
        wait_until(
            lambda: any(words in line.msg for line in log.messages),
            "the warning of two robots in one namespace",
        )
        self.spawned("from_database", "-sdf -database crate -y 12")
        self.assertNotIn("crate", models())

    def test_joints_and_namespace(self):
        self.spawned(
            "bent",
            f"-urdf -file {CAR} -y 15 -robot_namespace /fleet/bent -gazebo_namespace /gazebo/ "
            "-package_to_model -J rear_left_joint 0.25 -J rear_right_joint -0.5 -J nose 1",
        )  # a joint that the model lacks is skipped, as in Gazebo
        for joint, expected in (("rear_left_joint", 0.25), ("rear_right_joint", -0.5)):
            properties = call("get_joint_properties", GetJointProperties, "bent::" + joint)
            self.assertAlmostEqual(properties.position[0], expected, delta=1e-9)
        rospy.wait_for_service("/fleet/bent/controller_manager/list_controllers", timeout=120.0)

    def test_nodes_spawn_by_the_python_module(self):
        with open(CAR, encoding="utf-8") as stream:
            text = stream.read()
        pose = Pose(Point(0, 30, 1), Quaternion(0, 0, 0, 1))
        values = "by_module", text, "/by_module", pose, "world", "/gazebo"
        self.assertTrue(gazebo_interface.spawn_urdf_model_client(*values))
        self.addCleanup(call, "delete_model", DeleteModel, "by_module")
        self.assertFalse(gazebo_interface.spawn_urdf_model_client(*values), "the name is taken")
        values = "by_module", "robot_description", ["rear_left_joint"], [0.5], "/gazebo"
        self.assertTrue(gazebo_interface.set_model_configuration_client(*values))
        properties = call("get_joint_properties", GetJointProperties, "by_module::rear_left_joint")
        self.assertAlmostEqual(properties.position[0], 0.5, delta=1e-9)

    def test_exit_codes(self):
        for status, word, words in (
            (2, "usage", f"-urdf -file {CAR}"),
            (1, "/no/such/file", "-urdf -file /no/such/file -model a"),
            (1, "/no_such_parameter", "-urdf -param /no_such_parameter -model a"),
            (1, "not well-formed XML", "-urdf -stdin -model a"),
            (1, TAKEN, f"-urdf -file {CAR} -model sphere"),
            (1, "no_such_model", "-sdf -database no_such_model -model a"),
            (1, "never_comes", f"-urdf -file {CAR} -model a -wait never_comes -timeout 1"),
        ):
            with self.subTest(words):
                found, output = spawn(words, "<robot>")
                self.assertEqual(found, status, output)
                self.assertIn(word, output)
        self.assertNotIn("a", models())

    def bonded(self):
        """Starts spawn_model with -b."""
        return subprocess.Popen([*SPAWN, *f"-sdf -file {BOX} -model bonded -y 20 -b".split()])

    def test_bond_deletes_on_exit(self):
        process = self.bonded()
        try:
            wait_until(lambda: "bonded" in models(), "the bonded model", START_LIMIT)
            time.sleep(1.0)  # it stays while spawn_model does
            self.assertIn("bonded", models())
            self.assertIsNone(process.poll())
        finally:
            process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(LIMIT), 0)
        self.assertNotIn("bonded", models())

    def test_bond_deletes_at_a_stop_before_the_answer(self):
        name = "/gazebo/get_world_properties"
        world = rospy.ServiceProxy(name, GetWorldProperties, persistent=True)
        for _ in range(4):
            process = self.bonded()
            while process.poll() is None and "bonded" not in world().model_names:
                pass
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(LIMIT), 0)
            self.assertNotIn("bonded", models())
        world.close()

    def test_unpause(self):
        self.addCleanup(call, "pause_physics", Empty)
        clock = Recorder("/clock", Clock)
        begin = world_time()
        self.assertEqual(clock.messages, [], "/clock is silent while paused")
        self.spawned("starter", f"-sdf -file {BOX} -y 25 -z 1 -wait sphere -unpause")
        wait_until(lambda: clock.newest.clock.to_sec() > begin + 0.1, "time to run")
        self.assertFalse(call("get_physics_properties", GetPhysicsProperties).pause)

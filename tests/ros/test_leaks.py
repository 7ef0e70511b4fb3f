"""Models are spawned and deleted: memory, threads, files, services and topics do not grow."""

import os
import unittest

import psutil
import rosgraph
import rospy
from controller_manager_msgs.srv import LoadController, SwitchController, SwitchControllerRequest
from gazebo_msgs.srv import DeleteModel, GetWorldProperties, SpawnModel
from geometry_msgs.msg import Pose
from launches import memory, simulator_pid, threads
from sensor_msgs.msg import JointState, LaserScan
from sim_client import START_LIMIT, Recorder, wait_until
from std_msgs.msg import Float64

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="gui" value="false"/>
  </include>
  <rosparam command="load" file="$(find paddock_tests)/ros/lidar_bot_control.yaml"/>
  <param name="/gazebo/pub_clock_frequency" value="50.0"/>
</launch>
"""

WARM_UP = 40
CYCLES = 120
GROWTH = 0.05
CONTROLLERS = ("joint_state_controller", "left", "right")


def graph():
    """Services, and topics with what the simulator does with them."""
    published, subscribed, services = rosgraph.Master(rospy.get_name()).getSystemState()
    return tuple(
        sorted(name for name, nodes in part if "/gazebo" in nodes)
        for part in (published, subscribed, services)
    )


def files(pid):
    """Number of open files of a process."""
    return psutil.Process(pid).num_fds()


class Leaks(unittest.TestCase):
    """Spawns a robot with sensors and controllers, uses it, deletes it, many times."""

    def setUp(self):
        for name in ("spawn_urdf_model", "delete_model", "step"):
            rospy.wait_for_service("/gazebo/" + name, timeout=START_LIMIT)
        self.spawn = rospy.ServiceProxy("/gazebo/spawn_urdf_model", SpawnModel)
        self.delete = rospy.ServiceProxy("/gazebo/delete_model", DeleteModel)
        with open(
            os.path.join(os.path.dirname(__file__), "lidar_bot.urdf"), encoding="utf-8"
        ) as file:
            self.text = file.read()
        self.pid = simulator_pid()

    def cycle(self, number):
        answer = self.spawn("bot", self.text, "", Pose(), "")
        self.assertTrue(answer.success, answer.status_message)
        if number % 5 == 0:
            self.use()
        answer = self.delete("bot")
        self.assertTrue(answer.success, answer.status_message)

    def use(self):
        """Starts the controllers and subscribes to the sensors."""
        manager = "/bot/controller_manager/"
        load = rospy.ServiceProxy(manager + "load_controller", LoadController)
        for name in CONTROLLERS:
            self.assertTrue(load(name).ok)
        switch = rospy.ServiceProxy(manager + "switch_controller", SwitchController)
        self.assertTrue(
            switch(start_controllers=CONTROLLERS, strictness=SwitchControllerRequest.STRICT).ok
        )
        command = rospy.Publisher("/bot/left/command", Float64, queue_size=1)
        recorders = [Recorder("/bot/scan", LaserScan), Recorder("/bot/joint_states", JointState)]
        wait_until(lambda: command.get_num_connections() > 0, "the command's subscriber")
        command.publish(5.0)
        for recorder in recorders:
            recorder.wait_count(1)
            recorder.close()
        command.unregister()

    def figures(self):
        """Memory [B], threads and files, once connections of deleted topics are closed."""
        counts = []

        def calm():
            counts.append((threads(self.pid), files(self.pid)))
            return len(counts) > 100 and len(set(counts[-100:])) == 1

        wait_until(calm, "threads and files of the simulator coming to rest")
        return memory(self.pid), *counts[-1]

    def test_nothing_is_left(self):
        before_all = graph()
        for number in range(WARM_UP):
            self.cycle(number)
        wait_until(lambda: graph() == before_all, "the graph as before")
        size, thread_count, file_count = self.figures()
        for number in range(CYCLES):
            self.cycle(number)
        wait_until(lambda: graph() == before_all, "the graph as before")
        size_after, threads_after, files_after = self.figures()
        print(
            f"after {WARM_UP} cycles {size / 1e6:.2f} MB, {thread_count} threads, {file_count} "
            f"files; after {CYCLES} more {size_after / 1e6:.2f} MB, {threads_after} threads, "
            f"{files_after} files"
        )
        self.assertLess(size_after, size * (1 + GROWTH))
        self.assertLessEqual(threads_after, thread_count + 2, "rospy ends idle ones later")
        self.assertLessEqual(files_after, file_count + 2)
        names = rospy.ServiceProxy("/gazebo/get_world_properties", GetWorldProperties)()
        self.assertNotIn("bot", names.model_names)

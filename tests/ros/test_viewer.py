"""The viewer process: opened by gui; the simulation survives its crash."""

import os
import signal
import unittest
import xmlrpc.client

import psutil
import rosgraph
import rospy
from rosgraph_msgs.msg import Clock
from sim_client import START_LIMIT, Recorder, sleep_sim, wait_until
from std_srvs.srv import Trigger

from commands import procfs

LAUNCH = """<launch>
  <env name="QT_QPA_PLATFORM" value="offscreen"/>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="world_name" value="$(find gazebo_ros)/worlds/shapes.world"/>
    <arg name="gui" value="true"/>
  </include>
  <param name="/gazebo/pub_clock_frequency" value="50.0"/>
</launch>
"""


def children(pid):
    """Process ids of a process's direct children."""
    return [child.pid for child in psutil.Process(pid).children()]


def simulator_pid():
    """Process id of the node /gazebo."""
    uri = rosgraph.Master("/viewer_test").lookupNode("/gazebo")
    return xmlrpc.client.ServerProxy(uri).getPid("/viewer_test")[2]


class Viewer(unittest.TestCase):
    """Finds the viewer among the simulator's children."""

    @classmethod
    def setUpClass(cls):
        cls.clock = Recorder("/clock", Clock)
        cls.clock.wait_count(2, START_LIMIT)
        rospy.wait_for_service("/gazebo/open_viewer", timeout=START_LIMIT)
        cls.open = rospy.ServiceProxy("/gazebo/open_viewer", Trigger)
        cls.simulator = simulator_pid()

    def viewers(self):
        return [
            pid for pid in children(self.simulator) if "bullet_viewer.main" in procfs.arguments(pid)
        ]

    def viewer(self):
        """The one viewer, once it draws (its render worker is there)."""

        def drawing():
            found = self.viewers()
            return (
                len(found) == 1
                and any(
                    "bullet_sim.render.worker" in procfs.arguments(child)
                    for child in children(found[0])
                )
                and found[0]
            )

        return wait_until(drawing, "the viewer and its render worker", START_LIMIT)

    def setUp(self):
        self.assertTrue(self.open().success)

    def test_gui_opens_one_and_opening_again_keeps_it(self):
        pid = self.viewer()
        self.assertTrue(self.open().success)
        self.assertEqual(self.viewer(), pid)

    def test_the_simulator_itself_has_no_qt(self):
        self.viewer()
        with open(f"/proc/{self.simulator}/maps", encoding="utf-8") as file:
            self.assertNotIn("Qt5", file.read())

    def test_its_death_leaves_the_simulation_alone(self):
        for number in (signal.SIGKILL, signal.SIGTERM):
            pid = self.viewer()
            os.kill(pid, number)
            wait_until(lambda: pid not in self.viewers(), "the viewer's end")
            sleep_sim(0.5)
            self.assertEqual(simulator_pid(), self.simulator)
            self.assertTrue(self.open().success, "it can be opened again")

    def test_a_hanging_viewer_does_not_hold_up_the_clock(self):
        pid = self.viewer()
        os.kill(pid, signal.SIGSTOP)
        try:
            sleep_sim(1.0)
        finally:
            os.kill(pid, signal.SIGCONT)

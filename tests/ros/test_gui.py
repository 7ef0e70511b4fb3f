"""gui:=true: the page in a browser window, or its address where there is none."""

import json
import os
import re
import signal
import subprocess
import unittest
import urllib.error
import urllib.request
from pathlib import Path

import psutil
import rospy
from launches import proxy
from page_client import PageClient
from rosgraph_msgs.msg import Clock
from sim_client import START_LIMIT, WALL_LIMIT, Recorder, sleep_sim, wait_until

LAUNCH = """<launch>
  <param name="/folder_of_nodes" value="$(env ROS_HOME)"/>
  <env name="DISPLAY" value=":99"/>
  <env name="BROWSER" value="$(find paddock_tests)/ros/looking_browser.py"/>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="world_name" value="$(find gazebo_ros)/worlds/shapes.world"/>
    <arg name="gui" value="true"/>
  </include>
</launch>
"""
TOLD = "looking_browser.json"
DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")


def command_lines():
    """Command lines of all processes that can be read."""
    lines = []
    for process in psutil.process_iter():
        try:
            lines.append(" ".join(process.cmdline()))
        except psutil.Error:
            continue
    return lines


class Client:
    """gzclient without a display, as started by hand.

    Attributes:
        line: what it has printed first.
    """

    def __init__(self, *words, **environ):
        inherited = {name: os.environ[name] for name in os.environ if name not in DISPLAYS}
        self.process = subprocess.Popen(
            ["rosrun", "gazebo_ros", "gzclient", *words],
            env={**inherited, **environ},
            stdout=subprocess.PIPE,
            text=True,
        )
        self.line = self.process.stdout.readline()

    @property
    def address(self):
        return re.search(r"http://\S+/", self.line)[0]

    def end(self):
        """Ends it as Ctrl-C does; returns its exit status."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.process.communicate(timeout=WALL_LIMIT)
        return self.process.returncode


class Gui(unittest.TestCase):
    """The world's own node, and clients beside it."""

    @classmethod
    def setUpClass(cls):
        cls.clock = Recorder("/clock", Clock)
        cls.clock.wait_count(2, START_LIMIT)
        told = Path(rospy.get_param("/folder_of_nodes")) / TOLD
        wait_until(told.exists, "the browser's report", START_LIMIT)
        cls.told = json.loads(told.read_text())

    def test_a_browser_window_shows_the_page(self):
        self.assertEqual(self.told["page"], "<!doctype html>")
        page = PageClient(self.told["address"])
        self.addCleanup(page.close)
        wait_until(lambda: page.views, "a view")

    def test_nobody_else_sees_the_address(self):
        self.assertEqual(self.told["mode"], 0o600)
        wait_until(lambda: not os.path.exists(self.told["file"]), "the file's end")
        token = self.told["address"].split("/")[3]
        self.assertEqual([line for line in command_lines() if token in line], [])
        with self.assertRaises(urllib.error.HTTPError) as error:
            urllib.request.urlopen(self.told["address"].replace(token, "x"), timeout=WALL_LIMIT)
        self.assertEqual(error.exception.code, 403)
        error.exception.close()

    def test_when_gazebos_node_dies_the_simulation_goes_on(self):
        _, _, pid = proxy("/gazebo_gui").getPid("/gui_test")
        self.assertIn("bullet_web", " ".join(psutil.Process(pid).cmdline()))
        os.kill(pid, signal.SIGKILL)
        wait_until(lambda: not psutil.pid_exists(pid), "the page's end")
        sleep_sim(0.5)
        client = Client()
        self.addCleanup(client.end)
        self.assertIn("the page, in a browser: http://127.0.0.1:", client.line)

    def test_without_a_display_one_sentence_has_the_address(self):
        client = Client("__name:=client_without_display")
        self.addCleanup(client.end)
        self.assertRegex(
            client.line,
            r"^the page, in a browser: http://127\.0\.0\.1:\d+/[\w-]{22}/ "
            r"\(no window opens here: there is no display "
            r"\(neither DISPLAY nor WAYLAND_DISPLAY is set\)\)$",
        )
        page = PageClient(client.address)
        self.addCleanup(page.close)
        wait_until(lambda: page.views, "a view")
        self.assertEqual(client.end(), 0)

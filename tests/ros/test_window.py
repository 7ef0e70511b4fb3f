"""Keys of a real X server, a pad and the record button in the window, checked on ROS topics."""

import glob
import os
import re
import subprocess
import tempfile
import unittest

import av
import rosbag
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from shared_worlds import SEEING_CAR as LAUNCH  # noqa: F401
from sim_client import Recorder, wait_for_car, wait_until
from terminal_rig import XServer
from testing import executable

LIMIT = 60.0  # longest wait for an end [s]
STOP, FORWARD = (0.0, 0.0), (10.0, 0.0)


class Window:
    """The node `teleop` on an X server."""

    def __init__(self, server, folder):
        environment = dict(
            os.environ,
            DISPLAY=server.display,
            QT_QPA_PLATFORM="xcb",
            XDG_CONFIG_HOME=os.path.join(folder, "config"),
        )
        environment.pop("WAYLAND_DISPLAY", None)
        self.log = os.path.join(folder, "log")
        self._server = server
        with open(self.log, "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(
                [executable("deepracer_teleop", "teleop"), f"_record_dir:={folder}/out"],
                env=environment,
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        try:
            wait_until(self._find, "the window")
        except AssertionError as error:
            with open(self.log, encoding="utf-8") as log:
                said = log.read()
            raise AssertionError(f"{error}; exit {self.process.poll()}; it said:\n{said}") from None
        server.xdotool("windowfocus", "--sync", self._id)

    def _find(self):
        found = self._server.xdotool("search", "--onlyvisible", "--name", "^Teleop Interface$")
        self._id = found.strip()
        return bool(self._id)

    def geometry(self):
        """Returns x, y, width, height [px]."""
        text = self._server.xdotool("getwindowgeometry", "--shell", self._id)
        return tuple(
            int(re.search(f"{name}=(-?\\d+)", text)[1]) for name in ("X", "Y", "WIDTH", "HEIGHT")
        )

    def click_record(self):
        """Clicks the button at the top right."""
        _, _, width, _ = self.geometry()
        place = ["--window", self._id, str(width - 60), "30"]
        self._server.xdotool("mousemove", *place, "click", "1")

    def close(self):
        """Ends it; returns its exit code."""
        self.process.terminate()
        return self.process.wait(LIMIT)


class Driving(unittest.TestCase):
    """One window for all."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder, cls.server = folder.name, XServer()
        cls.addClassCleanup(cls.server.close)
        cls.commands = Recorder("/cmd_vel", Twist)
        cls.odometry = Recorder("/racecar/odom", Odometry)
        cls.window = Window(cls.server, cls.folder)
        cls.addClassCleanup(lambda: cls.window.close())
        wait_until(lambda: publishers("/cmd_vel"), "the window's commands")

    def setUp(self):
        self.commands.clear()

    def sent(self):
        return [(message.linear.x, message.angular.z) for message in self.commands.messages]

    def wait_last(self, command):
        wait_until(lambda: self.sent()[-1:] == [command], f"{command} on /cmd_vel")

    def speed(self):
        return self.odometry.newest.twist.twist.linear.x

    def test_a_held_key_drives_and_its_repeats_do_not_stutter(self):
        self.server.xdotool("keydown", "Up")
        wait_until(
            lambda: len(self.sent()) >= 15,
            "commands for 1.4 s",  # the X server repeats by then
        )
        wait_until(lambda: self.speed() > 0.25, "the car at speed")
        self.server.xdotool("keyup", "Up")
        self.wait_last(STOP)
        self.assertEqual(self.sent(), [*[FORWARD] * (len(self.sent()) - 1), STOP])
        wait_until(lambda: abs(self.speed()) < 0.01, "the car at rest")

    def test_record_leaves_a_bag_and_a_film(self):
        self.window.click_record()
        wait_until(lambda: glob.glob(f"{self.folder}/out/*.bag.active"), "the bag")
        wait_until(lambda: glob.glob(f"{self.folder}/out/*.mp4"), "the film")
        self.server.xdotool("keydown", "Up")
        wait_until(lambda: len(self.sent()) >= 20, "commands for 2 s")
        self.server.xdotool("keyup", "Up")
        self.wait_last(STOP)
        self.window.click_record()
        wait_until(lambda: "Recorded" in self.log(), "the end of the recording")
        [bag], [film] = glob.glob(f"{self.folder}/out/*.bag"), glob.glob(f"{self.folder}/out/*.mp4")
        self.assertEqual(bag[:-4], film[:-4])
        self.assertIn(f"{bag} (", self.log())
        with rosbag.Bag(bag) as recorded:
            topics = set(recorded.get_type_and_topic_info().topics)
            speeds = [message.linear.x for _, message, _ in recorded.read_messages("/cmd_vel")]
        self.assertLessEqual(
            {"/cmd_vel", "/racecar/odom", "/tf", "/referee/status", "/racecar/joint_states"}, topics
        )
        self.assertFalse(topics & {"/clock", "/camera/image", "/gazebo/model_states"}, topics)
        self.assertEqual((speeds[0], speeds[-1]), (10.0, 0.0))  # it subscribes within a second
        with av.open(film) as container:
            stream = container.streams.video[0]
            self.assertEqual(stream.codec_context.name, "h264")
            self.assertGreater(sum(1 for _ in container.decode(stream)), 8)

    def log(self):
        with open(self.window.log, encoding="utf-8") as stream:
            return stream.read()


def publishers(topic):
    """Returns the nodes that publish a topic."""
    published, _, _ = rospy.get_master().getSystemState()[2]
    return [name for found, names in published for name in names if found == topic]

"""The desk's screen and web server with the real window: token, picture, clicks, two viewers."""

import os
import subprocess
import tempfile
import unittest
import urllib.error
import urllib.request
from pathlib import Path

from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from shared_worlds import SEEING_CAR as LAUNCH  # noqa: F401
from sim_client import Recorder, wait_for_car, wait_until
from testing import enter_class_context, executable
from vnc_client import ROW, VncClient, wait_for_window
from websocket import WebSocketBadStatusException

from commands.subcommands import desk

PAGE = "<!DOCTYPE html><title>a page</title>"


def end(process):
    process.terminate()
    process.wait(60.0)


class DeskTest(unittest.TestCase):
    """One desk with the window on it for all tests."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        (Path(folder.name) / "vnc.html").write_text(PAGE)
        desk.PAGE = folder.name
        cls.desk = desk.Desk(os.environ, "1200x700")
        enter_class_context(cls, cls.desk)
        cls.window = subprocess.Popen(
            [executable("deepracer_teleop", "teleop")], env=cls.desk.environ
        )
        cls.addClassCleanup(end, cls.window)
        cls.address = cls.desk.url.replace("http:", "ws:") + "websockify"
        cls.viewer = VncClient(cls.address)
        cls.addClassCleanup(cls.viewer.close)
        cls.stop = wait_for_window(cls.viewer)

    def test_a_wrong_token_gets_nothing(self):
        token = self.desk.url.split("/")[3]
        for wrong in ("", "/", f"/{token[:-1]}/", f"/{token}x/websockify", f"/x/{token}/vnc.html"):
            base = self.desk.url.replace(f"/{token}/", wrong)
            with self.assertRaises(urllib.error.HTTPError, msg=wrong) as refused:
                urllib.request.urlopen(base, timeout=60.0)
            self.assertEqual(refused.exception.code, 403)
            self.assertNotIn(token, refused.exception.read().decode())
            with self.assertRaisesRegex(WebSocketBadStatusException, "403"):
                VncClient(base.replace("http:", "ws:"))

    def test_the_token_opens_the_page_and_names_the_web_socket(self):
        with urllib.request.urlopen(self.desk.url, timeout=60.0) as answer:
            self.assertEqual(answer.read().decode(), PAGE)
            token = self.desk.url.split("/")[3]
            self.assertIn(f"path=%2F{token}%2Fwebsockify", answer.url)
            self.assertEqual(answer.headers["Referrer-Policy"], "no-referrer")

    def test_only_this_machine_is_listened_to(self):
        port = int(self.desk.url.split(":")[2].split("/")[0])
        listening = [line.split()[1] for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
        self.assertIn(f"0100007F:{port:04X}", listening)
        self.assertNotIn(f"00000000:{port:04X}", listening)

    def test_a_click_on_forward_moves_the_car(self):
        commands = Recorder("/cmd_vel", Twist)
        odometry = Recorder("/racecar/odom", Odometry)
        self.addCleanup(commands.close)
        self.addCleanup(odometry.close)
        begin = odometry.next().pose.pose.position.x
        self.viewer.click(self.stop[0], self.stop[1] - ROW)
        wait_until(lambda: commands.last is not None, "a command")
        self.assertEqual(commands.messages[0].linear.x, 10.0)
        self.assertEqual(commands.messages[0].angular.z, 0.0)
        wait_until(lambda: odometry.last.pose.pose.position.x > begin + 0.1, "the car's move")

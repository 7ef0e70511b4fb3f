"""A vision node as students write it, with cv2's windows: on a virtual display, and without one."""

import os
import subprocess
import sys
import unittest

import cv2
import numpy as np
import rospy
from paddock_common.process import free_port
from page_client import PageClient, WebNode
from sensor_msgs.msg import Image
from sim_client import WALL_LIMIT, wait_until
from terminal_rig import XServer

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch"/>
</launch>
"""
# The window is made in one thread and filled in another, by a subscriber's callback.
VISION = """
import sys
import cv2, numpy, rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image
rospy.init_node("lookout")
cv2.namedWindow("Lane Detection")
cv2.createTrackbar("threshold", "Lane Detection", 40, 255, lambda value: None)
def show(message):
    image = CvBridge().imgmsg_to_cv2(message, "bgr8")
    image[:, :, 2] = cv2.getTrackbarPos("threshold", "Lane Detection")
    cv2.imshow("Lane Detection", image)
    cv2.waitKey(1)
    seen.publish(message)
seen = rospy.Publisher("seen", Image, queue_size=1)
rospy.Subscriber("seen_by_a_test", Image, show)
rospy.spin()
"""
TOPIC = "/lookout/windows/Lane_Detection"


class Windows(unittest.TestCase):
    """One node a test."""

    def start(self, display, python=sys.executable, text=VISION):
        """Starts the node; its environment is that of ./run exec."""
        environ = {name: value for name, value in os.environ.items() if name != "QT_QPA_PLATFORM"}
        environ["DISPLAY"] = display
        self.node = subprocess.Popen([python, "-c", text], env=environ)
        self.addCleanup(self.end)

    def end(self):
        self.node.terminate()
        self.node.wait(WALL_LIMIT)

    def is_running(self):
        """Whether the callback goes on: it sends back what it has shown."""
        image = np.zeros((60, 80, 3), np.uint8)
        image[:30, :, 1] = 200
        message = Image(height=60, width=80, encoding="bgr8", step=240, data=image.tobytes())
        publisher = rospy.Publisher("seen_by_a_test", Image, queue_size=1)
        seen = []
        subscriber = rospy.Subscriber("seen", Image, seen.append)
        self.addCleanup(publisher.unregister)
        self.addCleanup(subscriber.unregister)

        def has_seen_five():
            publisher.publish(message)
            self.assertIsNone(self.node.poll())
            return len(seen) >= 5

        wait_until(has_seen_five, "five images that the node has shown")

    def look(self, url):
        """A page that has got the picture."""
        page = PageClient(url)
        self.addCleanup(page.close)
        wait_until(lambda: TOPIC in page.status.get("cameras", ()), "its topic")
        page.send("want", camera=TOPIC, lidar="", data=False, contacts=False)
        _, payload = wait_until(
            lambda: next((m for m in page.binary if m[0]["type"] == "image"), None), "its picture"
        )
        shown = cv2.imdecode(np.frombuffer(payload, np.uint8), cv2.IMREAD_COLOR)
        self.assertEqual(shown.shape, (60, 80, 3))
        np.testing.assert_allclose(shown[10, 40], (0, 200, 40), atol=12)
        np.testing.assert_allclose(shown[50, 40], (0, 0, 40), atol=12)
        return page

    def test_on_a_display_its_window_is_there(self):
        server = XServer()
        self.addCleanup(server.close)
        self.start(server.display)
        self.is_running()
        found = server.xdotool("search", "--onlyvisible", "--name", "^Lane Detection$")
        self.assertEqual(len(found.split()), 1, found)

    def test_without_a_display_it_runs_on_and_the_page_has_its_picture(self):
        web = WebNode(f"_port:={free_port()}")
        self.addCleanup(web.end)
        for python in (sys.executable, "/usr/bin/python3"):
            with self.subTest(python=python):
                self.start("", python)
                self.is_running()
                # no other picture is shown: the last one is sent to whoever comes
                pages = [self.look(web.url), self.look(web.url)]
                self.end()
                for page in pages:
                    wait_until(
                        lambda p=page: TOPIC not in p.status["cameras"], "the end of its topic"
                    )

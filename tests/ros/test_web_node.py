"""The page's node beside a real world: what a page sees, drives and does."""

import signal
import unittest

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from paddock_common.process import free_port
from page_client import PageClient, WebNode
from shared_worlds import SEEING_CAR as LAUNCH  # noqa: F401
from sim_client import Recorder, wait_for_car, wait_until


class Web(unittest.TestCase):
    """One node for all tests, pages of their own."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        cls.commands = Recorder("/cmd_vel", Twist)
        cls.odometry = Recorder("/racecar/odom", Odometry)
        # no driver is taken for gone because this machine is busy
        cls.web = WebNode(f"_port:={free_port()}", "_timeout:=5")
        cls.addClassCleanup(cls.web.end)

    def setUp(self):
        self.page = self.open()
        wait_until(lambda: self.page.status.get("topic"), "a topic to drive")
        wait_until(self.has_subscriber, "control hearing the page")
        self.commands.clear()

    def open(self):
        page = PageClient(self.web.url)
        self.addCleanup(page.close)
        return page

    def has_subscriber(self):
        """Whether the node's publisher of /cmd_vel is there."""
        return self.commands._subscriber.get_num_connections() > 0

    def scene(self, page=None):
        page = page or self.page
        wait_until(lambda: page.scene, "a scene")
        return wait_until(lambda: self.web.scene(page.scene), "the present scene")

    def key(self, name):
        return next(body["key"] for body in self.scene()["bodies"] if body["name"] == name)

    def twists(self):
        return [(m.linear.x, m.angular.z) for m in self.commands.messages]

    def test_a_page_gets_the_world_as_it_is(self):
        scene = self.scene()
        self.assertLessEqual({"racecar", "track"}, {body["name"] for body in scene["bodies"]})
        self.assertEqual(scene["problems"], [])
        instances = [each for b in scene["bodies"] for k in b["links"] for each in k["instances"]]
        self.assertGreater(len(instances), 10)
        for name in {each["mesh"] for each in instances}:
            data = self.web.get(f"asset/{name}")
            (count,) = np.frombuffer(data, "<u4", 1)
            triangles = np.frombuffer(data, "<u4", offset=4 + 32 * count)
            self.assertLess(triangles.max(), count)
        images = {each["image"] for each in instances} - {None}
        self.assertTrue(images)
        for name in images:
            self.assertIn(self.web.get(f"asset/{name}")[:2], (b"\xff\xd8", b"\x89P"))
        key = self.key("racecar")
        row = wait_until(lambda: self.page.row(key), "the car")
        pose = self.odometry.newest.pose.pose.position
        self.assertAlmostEqual(row[0], pose.x, delta=0.05)
        self.assertAlmostEqual(row[1], pose.y, delta=0.05)

    def test_a_page_that_goes_stops_the_car(self):
        page = self.open()
        page.send("drive", speed=0.2, steering=0.5)
        wait_until(self.twists, "a command")
        self.assertEqual(self.twists()[0], (10.0, 2.0))
        page._socket.sock.close()  # without a word, as when the network goes
        wait_until(lambda: self.twists()[-1] == (0.0, 0.0), "the last zero")
        wait_until(lambda: self.page.status["driver"] is None, "an empty seat")
        rospy.sleep(0.6)
        self.assertEqual(self.twists().count((0.0, 0.0)), 1)

    def test_pause_step_resume_and_pace(self):
        page = self.page
        page.act("pause")
        wait_until(lambda: page.views and page.views[-1]["paused"], "the pause")
        self.addCleanup(page.act, "resume")
        end = page.views[-1]["time"] + 0.25
        page.act("step", count=250)
        wait_until(lambda: page.views[-1]["time"] >= end - 1e-6, "the steps")  # views come between
        self.assertAlmostEqual(page.views[-1]["time"], end, delta=1e-6)
        page.act("pace", factor=0.5)
        wait_until(lambda: page.status["pace"] == 0.5, "the pace")
        page.act("resume")
        wait_until(lambda: not page.views[-1]["paused"], "going on")
        page.act("pace", factor=1)
        wait_until(lambda: page.status["pace"] == 1.0, "the pace")

    def test_reset_sets_time_back(self):
        page = self.page
        wait_until(lambda: page.views and page.views[-1]["time"] > 2.0, "some time")
        page.act("pause")
        page.act("reset")
        wait_until(lambda: page.views[-1]["time"] < 1.0, "time from the start")
        page.act("resume")
        wait_for_car()

    def test_camera_and_lidar_come_while_they_are_wanted(self):
        page = self.page
        wait_until(lambda: page.status["cameras"] and page.status["lidars"], "the topics")
        self.assertIn("/camera/image", page.status["cameras"])
        lidar = page.status["lidars"][0]
        page.send("want", camera="/camera/image", lidar=lidar, data=True, contacts=True)
        wait_until(lambda: {"image", "points"} <= {head["type"] for head, _ in page.binary}, "both")
        head = next(head for head, _ in page.binary if head["type"] == "points")
        frames = {name for body in self.scene()["bodies"] for name in body["frames"]}
        self.assertIn(head["frame"], frames)
        wait_until(lambda: "lateral_error" in page.data, "the referee's word")
        wait_until(lambda: page.contacts and len(page.contacts["rows"]) >= 4, "contacts of wheels")
        page.send("want", camera="", lidar="", data=False, contacts=False)
        wait_until(lambda: not self.subscribed("/camera/image"), "the end of the subscription")

    def subscribed(self, topic):
        """Whether the node subscribes to a topic."""
        _, subscribers, _ = rospy.get_master().getSystemState()[2]
        return any(name == topic and "/web" in nodes for name, nodes in subscribers)

    def test_nothing_is_asked_when_nobody_looks(self):
        wait_until(lambda: self.page.views, "views")
        self.page.close()
        wait_until(lambda: not self.asked(), "the end of the calls")

    def asked(self):
        """Whether the node has a connection to the simulator's service."""
        import psutil

        server = int(rospy.get_master().lookupService("/gazebo/view")[2].rpartition(":")[2])
        connections = psutil.Process(self.web.process.pid).connections("tcp")
        return any(each.raddr and each.raddr.port == server for each in connections)

    def test_a_node_that_ends_while_one_drives_sends_one_zero(self):
        web = WebNode(f"_port:={free_port()}", "__name:=second_web")
        self.addCleanup(web.end)
        page = PageClient(web.url)
        self.addCleanup(page.close)
        wait_until(lambda: page.status.get("topic"), "a topic to drive")
        wait_until(lambda: self.commands._subscriber.get_num_connections() > 1, "its publisher")
        page.send("drive", speed=0.2, steering=0.0)
        wait_until(self.twists, "a command")
        self.assertEqual(web.end(signal.SIGTERM), 0)
        wait_until(lambda: self.twists()[-1] == (0.0, 0.0), "the last zero")
        self.assertEqual(self.twists().count((0.0, 0.0)), 1)

"""A drive recorded by rosbag record -a; its /cmd_vel, by rosbag play, gives the drive again.

Time advances by /gazebo/step, and rosbag play hands out one message for each `s` that it reads, so
that nothing depends on the machine's speed: the odometry is the same to the byte.
"""

import math
import os
import pty
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
import xmlrpc.client

import rosbag
import rosgraph
import rospy
from geometry_msgs.msg import Twist
from launches import Launch, wait_subscribed
from roslib.packages import find_node
from sim_client import CAR_COMMANDS, START_LIMIT, Recorder, wait_running, wait_until
from stepping import place

from bullet_bridge.srv import Step

LAUNCH = "<launch></launch>"  # a ROS master

SETTLING = 500  # physics steps of 1 ms before the recording: rosbag knows no time 0
TICKS, TICK = 40, 50  # commands, and physics steps for each
ODOMETRY = 50  # [Hz]
RECORDED = ("/racecar/odom", "/racecar/joint_states", "/scan", "/camera/image")


class World:
    """A fresh world and its odometry, serialised."""

    def __init__(self):
        wait_running("/racecar", 7)
        self.odometry = Recorder("/racecar/odom", rospy.AnyMsg)
        wait_subscribed(["/racecar/odom"])
        wait_subscribed(CAR_COMMANDS, "/gazebo", "/control")
        rospy.wait_for_service("/gazebo/step", timeout=START_LIMIT)
        self._step = rospy.ServiceProxy("/gazebo/step", Step, persistent=True)
        self.step(SETTLING)

    def step(self, count, commands=0):
        """Steps, after so many commands of each of the car's six topics."""
        topics = CAR_COMMANDS if commands else ()
        answer = self._step(count, topics, [commands] * len(topics))
        assert answer.success, answer.status_message

    def drive(self, command):
        """Has each tick commanded, and stepped; returns the odometry's bytes."""
        for tick in range(TICKS):
            command(tick)
            self.step(TICK, commands=1)
        self.odometry.wait_count((SETTLING + TICKS * TICK) * ODOMETRY // 1000)
        return [message._buff for message in self.odometry.messages]

    def close(self):
        """Unsubscribes."""
        self.odometry.close()
        self._step.close()


def links(node, topic):
    """Per publisher of a topic, how many messages a C++ node has received, by its statistics."""
    uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
    _, subscriptions = xmlrpc.client.ServerProxy(uri).getBusStats(rospy.get_name())[:2]
    return [link[2] for name, found, *_ in subscriptions if name == topic for link in found]


class Replay(unittest.TestCase):
    """One drive, and its replay."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="replay_")
        self.addCleanup(shutil.rmtree, self.folder)
        self.bag = os.path.join(self.folder, "drive.bag")

    def rosbag(self, program, *arguments, stdin=subprocess.DEVNULL):
        """Starts a program of rosbag that ends with the test."""
        process = subprocess.Popen([find_node("rosbag", program)[0], *arguments], stdin=stdin)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def record(self):
        """Drives and records; returns the odometry."""
        with Launch("replay_world.launch"):
            world = World()
            out = rospy.Publisher("/cmd_vel", Twist, queue_size=10)
            process = self.rosbag("record", "-a", "-O", self.bag, "__name:=recorder")
            wait_until(lambda: out.get_num_connections() == 2, "control and rosbag on /cmd_vel")
            wait_subscribed(RECORDED, "/recorder")

            def command(tick):
                message = Twist()
                message.linear.x, message.angular.z = 2.0, 1.5 * math.sin(0.2 * tick)
                out.publish(message)

            odometry = world.drive(command)
            wait_until(lambda: links("/recorder", "/cmd_vel") == [TICKS], "rosbag's messages")
            self.wait_written()
            process.send_signal(signal.SIGINT)
            process.wait()
            out.unregister()
            world.close()
        return odometry

    def wait_written(self):
        """Waits until the file has what was recorded: it no longer grows."""
        sizes = [0]

        def written():
            time.sleep(1.0)
            sizes.append(os.path.getsize(self.bag + ".active"))
            return sizes[-1] == sizes[-2] > 0

        wait_until(written, "rosbag's file")

    def replay(self):
        """Plays the recorded commands into a fresh world; returns the odometry."""
        with Launch("replay_world.launch"):
            world = World()
            keys, stdin = pty.openpty()
            self.addCleanup(os.close, keys)
            options = ("--pause", "--wait-for-subscribers", self.bag, "--topics", "/cmd_vel")
            self.rosbag("play", *options, "__name:=player", stdin=stdin)
            os.close(stdin)
            probe = rospy.Subscriber("/cmd_vel", Twist)
            wait_until(lambda: probe.get_num_connections() == 1, "rosbag play")
            wait_subscribed(["/cmd_vel"], "/control", "/player")
            odometry = world.drive(lambda _: os.write(keys, b"s"))
            probe.unregister()
            world.close()
        return odometry

    def test_the_commands_of_a_bag_give_the_drive_again(self):
        first = self.record()
        with rosbag.Bag(self.bag) as bag:
            counts = {
                name: found.message_count
                for name, found in bag.get_type_and_topic_info().topics.items()
            }
            raw = bag.read_messages("/racecar/odom", raw=True)
            recorded = {message[1] for _, message, _ in raw}
        self.assertEqual(counts["/cmd_vel"], TICKS)
        self.assertLessEqual({"/clock", "/tf", *RECORDED}, set(counts))
        second = self.replay()
        self.assertGreater(math.dist(place(first[0]), place(first[-1])), 1.0)
        self.assertEqual(len(first), len(second))
        different = [n for n, pair in enumerate(zip(first, second)) if pair[0] != pair[1]]
        self.assertEqual(different, [], "messages of the replay that differ")
        self.assertTrue(recorded)
        self.assertLessEqual(recorded, set(second), "the bag's odometry is the replay's")

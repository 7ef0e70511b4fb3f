"""Shared by the Cyber Truck's integration tests."""

import math
import xmlrpc.client

import rosgraph
import rospy
from controller_manager_msgs.srv import ListControllers
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from sim_client import START_LIMIT, Recorder, sleep_sim, turned, wait_connected, wait_until, yaw_of

from bullet_bridge.srv import Step
from cybertruck.msg import CyberDriveStamped

TRUTH = "/ground_truth/odom"


def wait_for_truck():
    """Waits until the truck is in the world and its drive node publishes odometry."""
    odometry = Recorder("/odom", Odometry)
    odometry.next(START_LIMIT)
    odometry.close()
    sleep_sim(1.0)


def pose_of(message):
    """Returns (x [m], y [m], yaw [rad]) of an odometry message."""
    position = message.pose.pose.position
    return position.x, position.y, yaw_of(message.pose.pose.orientation)


def way(messages):
    """Returns the distance [m] driven and the sum of all turning [rad] along odometry messages."""
    poses = [pose_of(message) for message in messages]
    pairs = list(zip(poses, poses[1:]))
    return (
        sum(math.dist(a[:2], b[:2]) for a, b in pairs),
        sum(abs(turned(a[2], b[2])) for a, b in pairs),
    )


class Driver:
    """Publishes drive commands 25 times a second of simulated time."""

    def __init__(self):
        self._publisher = rospy.Publisher("/cmd_cyberdrive", CyberDriveStamped, queue_size=1)
        wait_connected(self._publisher, "drive node")

    def give(self, steering, speed, stamp=None):
        """Publishes one command.

        Args:
            steering: Bicycle's angle [rad].
            speed: [m/s].
            stamp: rospy.Time; now if left out.
        """
        message = CyberDriveStamped()
        message.header.stamp = rospy.Time.now() if stamp is None else stamp
        message.drive.steering_angle, message.drive.speed = steering, speed
        self._publisher.publish(message)

    def hold(self, steering, speed, seconds):
        """Repeats a command for a simulated time [s]."""
        end = rospy.get_time() + seconds
        while rospy.get_time() < end:
            self.give(steering, speed)
            sleep_sim(0.04)


def wait_link(sender, topic, receiver):
    """Waits until a node has counted another one's subscription, so that no message is lost."""

    def there():
        try:
            node = xmlrpc.client.ServerProxy(rosgraph.Master(rospy.get_name()).lookupNode(sender))
            links = node.getBusInfo(rospy.get_name())[2]
        except (rosgraph.MasterException, OSError):
            return False
        return any(
            link[1] == receiver and link[2] == "o" and link[4] == topic and link[5]
            for link in links
        )

    wait_until(there, f"{sender} sending {topic} to {receiver}", START_LIMIT)


class Stepper:
    """Steps simulated time; each step waits for the drive node's commands.

    For launches with lockstep:=true; results then do not depend on the machine's speed.
    """

    TOPICS = ("/cybertruck/steering_controller/command", "/cybertruck/axle_controller/command")
    PERIOD = 8  # physics steps between joint states

    def __init__(self):
        self._wait_for_controllers()
        rospy.wait_for_service("/gazebo/step", START_LIMIT)
        self._service = rospy.ServiceProxy("/gazebo/step", Step, persistent=True)
        joints = Recorder("/joint_states", JointState)
        wait_link("/gazebo", "/cybertruck/joint_states", "/drive")
        for topic in self.TOPICS:
            wait_link("/drive", topic, "/gazebo")
        wait_link("/drive", "/joint_states", rospy.get_name())
        self._call(self.PERIOD, 0)
        joints.wait_count(1, START_LIMIT)  # the drive node got that period's joint states
        joints.close()

    @staticmethod
    def _wait_for_controllers():
        name = "/cybertruck/controller_manager/list_controllers"
        rospy.wait_for_service(name, START_LIMIT)
        service = rospy.ServiceProxy(name, ListControllers)
        wait_until(
            lambda: [item.state for item in service().controller] == ["running"] * 3,
            "three controllers running",
            START_LIMIT,
        )

    def _call(self, count, commands):
        answer = self._service(count, self.TOPICS, [commands] * len(self.TOPICS))
        if not answer.success:
            raise AssertionError(answer.status_message)

    def advance(self, periods=1):
        """Makes some periods of 8 ms; the commands of as many periods must have come."""
        for _ in range(periods):
            self._call(self.PERIOD, 1)

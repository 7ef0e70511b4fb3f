"""Observers of the bridge at work: its start, driving at real time, latency."""

import sys
import threading
import time

import rospy
from figures import BenchError
from geometry_msgs.msg import Twist
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from observers import graph

HINGE = "left_steering_hinge_joint"
WHEEL = "left_rear_wheel_joint"


def start(began):
    """Answers first_image, first_joint_state, controllers [s]."""
    began = float(began)
    graph.join()
    images = graph.record("/camera/image")
    states = graph.record("/racecar/joint_states")
    controllers = graph.wait_for_controllers() - began
    limit = time.monotonic() + graph.START_LIMIT
    while not (images and states):
        if time.monotonic() > limit:
            sys.exit("observer: no image or no joint states")
        time.sleep(0.01)
    graph.say(
        first_image=images[0][0] - began,
        first_joint_state=states[0][0] - began,
        controllers=controllers,
    )


def drive():
    """Each line "BEGIN END" (time.monotonic) on stdin is a window; answers its receipts."""
    graph.join()
    images, ticks = graph.record("/camera/image", 4), graph.record("/clock", 0)
    scans = graph.record("/scan", 4)
    graph.wait_for_controllers()
    graph.wait_for(images, "/camera/image")
    outputs = graph.publishers()
    graph.start_circle(outputs)
    graph.say(ready=True)
    while True:
        begin, end = map(float, graph.receive())
        speed = 0.0
        while time.monotonic() < end:
            for publisher, value in outputs:
                publisher.publish(value)
            if not speed and time.monotonic() > (begin + end) / 2:
                speed = graph.car_speed()
            time.sleep(1 / 30)
        graph.say(
            images=[pair for pair in images if begin <= pair[0] < end],
            ticks=[pair for pair in ticks if begin <= pair[0] < end],
            scans=sum(begin <= pair[0] < end for pair in scans),
            speed=speed,
        )


# What shows a command; at rest both are below a hundredth of it. [rad, rad/s]
TURNED, ROLLING = 1e-4, 0.05


def _joints(message):
    """Joint name -> (position, velocity)."""
    if not len(message.name) == len(message.position) == len(message.velocity):
        raise BenchError(f"joint states of {len(message.name)} names have other numbers of values")
    return dict(zip(message.name, zip(message.position, message.velocity)))


class States:
    """Joint states with their receipt."""

    def __init__(self):
        self._changed = threading.Condition()
        self._last = None
        rospy.Subscriber("/racecar/joint_states", JointState, self._take, tcp_nodelay=True)

    def _take(self, message):
        now = time.monotonic()
        with self._changed:
            self._last = (now, _joints(message))
            self._changed.notify_all()

    def wait(self, shows, limit=2.0):
        """Receipt of the first message from now on that shows something, or None."""
        end = time.monotonic() + limit
        with self._changed:
            while True:
                before = self._last
                while self._last is before:
                    if not self._changed.wait(end - time.monotonic()):
                        return None
                if shows(self._last[1]):
                    return self._last[0]

    def now(self):
        """The newest joints: name -> (position, velocity)."""
        with self._changed:
            return self._last[1]


def hinge_latencies(states, count):
    """[s] from a Float64 on the hinge's command topic to joint states that show it."""
    publisher = rospy.Publisher(
        "/racecar/left_steering_hinge_position_controller/command",
        Float64,
        queue_size=1,
        tcp_nodelay=True,
    )
    graph.start_circle([(publisher, 0.0)])
    time.sleep(0.5)
    found, sign = [], 1.0
    for number in range(count):
        before = states.now()[HINGE][0]
        sent = time.monotonic()
        publisher.publish(0.2 * sign)
        seen = states.wait(lambda joints, before=before: abs(joints[HINGE][0] - before) > TURNED)
        if seen is not None:
            found.append(seen - sent)
        sign = -sign
        time.sleep(0.25 + 0.0037 * (number % 7))  # all phases of the publish period
    return found


def wheel_latencies(states, count):
    """[s] from a Twist on /cmd_vel to wheels that move, or stand again."""
    publisher = rospy.Publisher("/cmd_vel", Twist, queue_size=1, tcp_nodelay=True)
    limit = time.monotonic() + graph.START_LIMIT
    while not publisher.get_num_connections() and time.monotonic() < limit:
        time.sleep(0.01)
    found = []
    for number in range(count):
        command = Twist()
        command.linear.x = 10.0 if number % 2 == 0 else 0.0
        before = states.now()[WHEEL][1]
        sent = time.monotonic()
        publisher.publish(command)
        seen = states.wait(lambda joints, before=before: abs(joints[WHEEL][1] - before) > ROLLING)
        if seen is not None:
            found.append(seen - sent)
        time.sleep(0.25 + 0.0037 * (number % 7))
    return found


def latency(count, with_camera):
    """Answers both lists and the publish period of the joint states [s]."""
    graph.join()
    images = graph.record("/camera/image") if with_camera == "camera" else []
    graph.wait_for_controllers()
    states = States()
    states.wait(lambda _: True, graph.START_LIMIT)
    time.sleep(1.0)
    hinge = hinge_latencies(states, int(count))
    wheel = wheel_latencies(states, int(count))
    graph.say(
        hinge=hinge,
        wheel=wheel,
        asked=int(count),
        images=len(images),
        period=1.0 / rospy.get_param("/racecar/joint_state_controller/publish_rate"),
    )

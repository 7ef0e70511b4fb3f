"""What the observers share: joining the graph, recording topics, controllers, the pace of time."""

import json
import os
import socket
import struct
import sys
import time
from urllib.parse import urlparse

import rospy
from controller_manager_msgs.srv import ListControllers
from gazebo_msgs.srv import GetModelState, GetWorldProperties
from paddock_common.nodes import retain_freed_memory
from std_msgs.msg import Float64
from std_srvs.srv import Empty, Trigger
from worlds.car_description import COMMANDS

CONTROLLERS = len(COMMANDS) + 1  # with the joint states' controller
START_LIMIT = 120.0  # [s]
ROUND_TRIP = 0.005  # [s] a service call that took longer is made again ...
ATTEMPTS = 5  # ... but no more often than this


_answers = sys.stdout


def answer_on(stream):
    """Say what there is to say on a stream of its own from now on."""
    global _answers
    _answers = stream


def say(**values):
    """Answer bench.py."""
    print(json.dumps(values), file=_answers, flush=True)


def fail(text):
    """Answer bench.py why there are no figures, and end."""
    say(error=text)
    os._exit(1)


def receive():
    """The words of the next line from bench.py, or exit when it has gone."""
    line = sys.stdin.readline()
    if not line:
        os._exit(0)
    return line.split()


def receive_json():
    """The next line from bench.py as JSON, or exit when it has gone."""
    line = sys.stdin.readline()
    if not line:
        os._exit(0)
    return json.loads(line)


def join():
    """Become a node, without a subscription to /clock of its own."""
    retain_freed_memory()  # the worlds of bare.py left malloc like this while they loaded images
    address = urlparse(os.environ["ROS_MASTER_URI"])
    limit = time.monotonic() + START_LIMIT
    while True:
        try:
            socket.create_connection((address.hostname, address.port), 1).close()
            break
        except OSError:
            if time.monotonic() > limit:
                fail(f"no ROS master within {START_LIMIT:g} s")
            time.sleep(0.02)
    rospy.init_node(
        "bench", anonymous=True, disable_rostime=True, disable_rosout=True, disable_signals=True
    )


def record(topic, offset=None):
    """Subscribe to raw messages; returns the list that gets (receipt [s], stamp [s]).

    Args:
        offset: of the stamp in the serialised message [bytes]; None: no stamp is read.
    """
    found = []

    def take(message):
        now = time.monotonic()
        stamp = 0.0
        if offset is not None:
            seconds, nanoseconds = struct.unpack_from("<II", message._buff, offset)
            stamp = seconds + nanoseconds * 1e-9
        found.append((now, stamp))

    rospy.Subscriber(topic, rospy.AnyMsg, take, buff_size=1 << 22, tcp_nodelay=True)
    return found


def wait_for(received, topic):
    """Returns once a list of record() has a message: a first image may take long to draw."""
    limit = time.monotonic() + START_LIMIT
    while not received:
        if time.monotonic() > limit:
            fail(f"nothing on {topic} within {START_LIMIT:g} s")
        time.sleep(0.03)


def counts(received):
    """Number of messages of each topic; received: topic -> list of record()."""
    return {topic: len(found) for topic, found in received.items()}


def serve(kinds):
    """Answers each line "KIND SECONDS" by what kinds[KIND] gives for them, until bench.py goes."""
    while True:
        kind, seconds = receive()
        say(**kinds[kind](float(seconds)))


def running_controllers(namespace="/racecar"):
    """How many controllers run; 0 while the manager is not there."""
    try:
        listed = rospy.ServiceProxy(
            f"{namespace}/controller_manager/list_controllers", ListControllers
        )()
    except (rospy.ServiceException, rospy.ROSException):
        return 0
    return sum(controller.state == "running" for controller in listed.controller)


def wait_for_controllers(namespace="/racecar"):
    """Returns when all controllers run, as time.monotonic."""
    limit = time.monotonic() + START_LIMIT
    while running_controllers(namespace) < CONTROLLERS:
        if time.monotonic() > limit:
            fail(
                f"{running_controllers(namespace)} of {CONTROLLERS} controllers of {namespace} "
                f"run after {START_LIMIT:g} s"
            )
        time.sleep(0.03)
    return time.monotonic()


def publishers(namespace="/racecar"):
    """[(publisher, value)] of the circle."""
    return [
        (rospy.Publisher(f"{namespace}/{name}/command", Float64, queue_size=1), value)
        for name, value in COMMANDS
    ]


def start_circle(outputs):
    """Send the circle's commands once all of them have subscribers."""
    limit = time.monotonic() + START_LIMIT
    for publisher, _ in outputs:
        while not publisher.get_num_connections():
            if time.monotonic() > limit:
                fail(f"no subscriber of {publisher.name}")
            time.sleep(0.01)
    for publisher, value in outputs:
        publisher.publish(value)


def car_speed(name="racecar"):
    """Speed of a car over the ground [m/s]."""
    state = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)(name, "")
    return (state.twist.linear.x**2 + state.twist.linear.y**2) ** 0.5


class Simulation:
    """Simulated time, and whether it goes on; keeps its connection, so that a call is short."""

    def __init__(self):
        rospy.wait_for_service("/gazebo/get_world_properties", START_LIMIT)
        self._properties = rospy.ServiceProxy(
            "/gazebo/get_world_properties", GetWorldProperties, persistent=True
        )
        self._statistics = rospy.ServiceProxy("/gazebo/statistics", Trigger)
        self.pause = rospy.ServiceProxy("/gazebo/pause_physics", Empty)
        self.unpause = rospy.ServiceProxy("/gazebo/unpause_physics", Empty)

    def shares(self):
        """What the wall time of the last second of running went into: part -> fraction."""
        return json.loads(self._statistics().message)["shares"]

    def moment(self):
        """(wall time, simulated time) [s]; the first is the middle of a short service call."""
        for _ in range(ATTEMPTS):
            begin = time.monotonic()
            sim = self._properties().sim_time
            end = time.monotonic()
            if end - begin < ROUND_TRIP:
                break
        return (begin + end) / 2, sim

    def time(self):
        """Simulated time [s]."""
        return self._properties().sim_time

    def wait(self, seconds):
        """Return when so much simulated time has passed [s]."""
        end = self.time() + seconds
        limit = time.monotonic() + START_LIMIT
        while self.time() < end:
            if time.monotonic() > limit:
                fail(f"{seconds:g} simulated s do not pass within {START_LIMIT:g} s")
            time.sleep(0.05)

    def pace(self, seconds):
        """(simulated seconds per wall second, simulated seconds) of a window of wall time [s]."""
        begin, first = self.moment()
        time.sleep(seconds)
        end, last = self.moment()
        return (last - first) / (end - begin), last - first

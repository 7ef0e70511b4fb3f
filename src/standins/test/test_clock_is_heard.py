"""A node hears /clock whose publisher registers while the node subscribes.

Without a clock time stands, and interactive_markers refuses what moves a marker within a second of
its start: the node never answers.
"""

import subprocess
import sys

import pytest
import testing

# The master's answer to the subscription is read after its word of the publisher; the thread that
# reads both waits for the subscription meanwhile, for it looks at all topics twice a second.
LATE_ANSWER = """
import time
from rospy.impl import registration
ask = registration.xmlrpcapi
class Late:
    def __init__(self, master):
        self.master = master
    def __getattr__(self, name):
        return getattr(self.master, name)
    def registerSubscriber(self, *args):
        answer = self.master.registerSubscriber(*args)
        if args[1] == "/clock":
            time.sleep(1.5)
            print("answered", flush=True)
            manager = next(iter(registration.get_registration_listeners().listeners))
            while not any(topic == "/clock" for topic, _ in manager.updates):
                time.sleep(0.01)
        return answer
registration.xmlrpcapi = lambda uri, cache=True: Late(ask(uri, cache))
"""
# The node goes on from its start when it has heard the clock.
AFTER_CLOCK = """
import time
import rospy
init_node = rospy.init_node
def init_and_hear(*args, **options):
    init_node(*args, **options)
    while not rospy.get_time():
        time.sleep(0.01)
rospy.init_node = init_and_hear
"""
COMMAND = """
import rospy
from geometry_msgs.msg import Twist
rospy.init_node("listener", disable_rostime=True)
rospy.wait_for_message("/marker_server/cmd_vel", Twist, {limit})
print("heard")
"""
CLOCK = """
import itertools, rospy, time
from rosgraph_msgs.msg import Clock
rospy.init_node("clock", disable_rostime=True)
publisher = rospy.Publisher("/clock", Clock, queue_size=1)
for number in itertools.count(1):
    publisher.publish(Clock(rospy.Time(number)))
    time.sleep(0.02)
"""
FEEDBACK = {"/twist_marker_server/feedback": "visualization_msgs/InteractiveMarkerFeedback"}
VALUES = ("client_id='rviz'", "marker_name='robot_twist_marker'", "event_type=1")


NODE = ("interactive_marker_twist_server", "marker_server")
STANDING = """
import rospy, time
from rosgraph_msgs.msg import Clock
rospy.init_node("clock", disable_rostime=True)
publisher = rospy.Publisher("/clock", Clock, queue_size=1)
while True:
    publisher.publish(Clock(rospy.Time(10)))
    time.sleep(0.02)
"""


@pytest.fixture
def environment():
    with testing.ros_master() as environment:
        subprocess.run(["rosparam", "set", "/use_sim_time", "true"], env=environment, check=True)
        yield environment


def assert_answers(environment):
    """Moves the marker until the node answers."""
    listener = [sys.executable, "-c", COMMAND.format(limit=30.0)]
    with testing.flood(environment, FEEDBACK, *VALUES):
        done = subprocess.run(listener, env=environment, capture_output=True, text=True)
    assert done.stdout == "heard\n", done.stderr


def test_marker_server_hears_a_clock_that_comes_as_it_subscribes(environment, tmp_path):
    (tmp_path / "sitecustomize.py").write_text(LATE_ANSWER)
    late = testing.with_path(environment, tmp_path)
    with testing.running(late, [testing.executable(*NODE)]) as process:
        assert process.stdout.readline() == "answered\n"
        with testing.running(environment, [sys.executable, "-c", CLOCK]):
            assert_answers(environment)


def test_marker_server_answers_where_the_clock_stands(environment, tmp_path):
    """As in a paused world: it hears the clock before it makes its marker."""
    (tmp_path / "sitecustomize.py").write_text(AFTER_CLOCK)
    later = testing.with_path(environment, tmp_path)
    with testing.running(environment, [sys.executable, "-c", STANDING]):
        with testing.running(later, [testing.executable(*NODE)]):
            assert_answers(environment)

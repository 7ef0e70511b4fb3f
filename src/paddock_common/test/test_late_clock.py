"""A node hears /clock whose publisher registers while the node subscribes: else its time stands."""

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
NODE = """
import time
import rospy
from paddock_common import nodes
nodes.init_node("hears")
deadline = time.monotonic() + 30.0
while not rospy.get_time() and time.monotonic() < deadline:
    time.sleep(0.01)
print("time" if rospy.get_time() else "no time", flush=True)
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


@pytest.fixture
def environment():
    with testing.ros_master() as environment:
        subprocess.run(["rosparam", "set", "/use_sim_time", "true"], env=environment, check=True)
        yield environment


def test_a_clock_that_comes_as_a_node_subscribes_is_heard(environment, tmp_path):
    (tmp_path / "sitecustomize.py").write_text(LATE_ANSWER)
    late = testing.with_path(environment, tmp_path)
    with testing.running(late, [sys.executable, "-c", NODE]) as process:
        assert process.stdout.readline() == "answered\n"
        with testing.running(environment, [sys.executable, "-c", CLOCK]):
            assert process.stdout.readline() == "time\n"

"""A node hears /clock whose publisher registers while the node subscribes.

Without a clock time stands, and interactive_markers refuses what moves a marker within a second of
its start: the node never answers.
"""

import subprocess
import sys

from paddock_common import testing_nodes

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


def test_marker_server_hears_a_clock_that_comes_as_it_subscribes(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(LATE_ANSWER)
    with testing_nodes.ros_master() as environment:
        subprocess.run(["rosparam", "set", "/use_sim_time", "true"], env=environment, check=True)
        late = testing_nodes.with_path(environment, tmp_path)
        node = [testing_nodes.executable("interactive_marker_twist_server", "marker_server")]
        with testing_nodes.running(late, node) as process:
            assert process.stdout.readline() == "answered\n"
            clock = [sys.executable, "-c", CLOCK]
            with (
                testing_nodes.running(environment, clock),
                testing_nodes.flood(environment, FEEDBACK, *VALUES),
            ):
                listener = [sys.executable, "-c", COMMAND.format(limit=30.0)]
                done = subprocess.run(listener, env=environment, capture_output=True, text=True)
    assert done.stdout == "heard\n", done.stderr

"""Observer of a robot that maps or navigates."""

import itertools
import time

import rospy
from geometry_msgs.msg import PoseStamped, Twist

from observers import graph

GOALS = (
    (-0.55, -0.55),
    (-0.55, 0.55),
)  # x, y [m] in the map of TurtleBot3's world, between its pillars
GOAL_TIME = 15.0  # [s] between two goals


def drive(*words):
    """Drives; each line "BEGIN END" (time.monotonic) on stdin is a window; answers its receipts.

    Args:
        words: speed [m/s] and turn [rad/s] of a circle, or "goals".
    """
    graph.join()
    ticks, scans, maps = graph.record("/clock", 0), graph.record("/scan", 4), graph.record("/map")
    graph.wait_for(scans, "/scan")
    goals = words == ("goals",)
    topic, kind = ("/move_base_simple/goal", PoseStamped) if goals else ("/cmd_vel", Twist)
    output = rospy.Publisher(topic, kind, queue_size=1)
    limit = time.monotonic() + graph.START_LIMIT
    while not output.get_num_connections():
        if time.monotonic() > limit:
            graph.fail(f"nobody subscribes to {topic} within {graph.START_LIMIT:g} s")
        time.sleep(0.05)
    if goals:
        time.sleep(5.0)  # [s] for the costmaps
    send = _goals(output) if goals else _circle(output, *map(float, words))
    graph.say(ready=True)
    while True:
        begin, end = map(float, graph.receive())
        while time.monotonic() < end:
            send()
            time.sleep(0.05)
        graph.say(
            ticks=[pair for pair in ticks if begin <= pair[0] < end],
            scans=sum(begin <= pair[0] < end for pair in scans),
            maps=sum(begin <= pair[0] < end for pair in maps),
        )


def _circle(output, speed, turn):
    message = Twist()
    message.linear.x, message.angular.z = speed, turn
    return lambda: output.publish(message)


def _goals(output):
    places, due = itertools.cycle(GOALS), 0.0

    def send():
        nonlocal due
        if time.monotonic() < due:
            return
        due = time.monotonic() + GOAL_TIME
        message = PoseStamped()
        message.header.frame_id = "map"
        message.pose.position.x, message.pose.position.y = next(places)
        message.pose.orientation.w = 1.0
        output.publish(message)

    return send

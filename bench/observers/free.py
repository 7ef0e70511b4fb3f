"""free SECONDS TOPIC...: windows of the bridge, as fast as possible, and of the bare engine.

The topics are subscribed. Lines on stdin: "bridge" or "bare"; one answer each.
"""

import time

import rospy
from std_srvs.srv import Empty

from observers import graph


def main(seconds, *topics):
    """The bridge is paused while the bare engine runs, and the other way round."""
    seconds = float(seconds)
    graph.join()
    received = {topic: graph.record(topic) for topic in topics}
    graph.wait_for_controllers()
    pause = rospy.ServiceProxy("/gazebo/pause_physics", Empty)
    unpause = rospy.ServiceProxy("/gazebo/unpause_physics", Empty)
    graph.start_circle(graph.publishers())
    time.sleep(1.0)
    pause()
    world = graph.bare_world()
    graph.pace_of_engine(world, 0.5)
    graph.say(step=world.time_step)
    while True:
        if graph.hear()[0] == "bare":
            graph.say(pace=graph.pace_of_engine(world, seconds), speed=graph.bare_speed(world))
            continue
        unpause()
        time.sleep(0.3)
        before = {topic: len(found) for topic, found in received.items()}
        pace, sim = graph.pace_of_bridge(seconds)
        counts = {topic: len(found) - before[topic] for topic, found in received.items()}
        speed = graph.car_speed()
        pause()
        graph.say(pace=pace, sim=sim, speed=speed, received=counts)

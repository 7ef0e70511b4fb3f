"""Reconnecting subscribers whose connection was closed."""

import time

import rosgraph
import rospy
from rospy.impl.registration import get_topic_manager

DELAYS = (1.0, 4.0)  # [s] wall time before each try: a busy subscriber sees the loss later


def reconnect_subscribers(delays=DELAYS):
    """Register this node's publishers with the master again.

    A rospy subscriber does not reconnect by itself when its connection is closed. The master sends
    it the publishers of the topic whenever one registers, also one that is registered already.
    """
    for delay in delays:
        time.sleep(delay)
        if rospy.is_shutdown():
            return
        try:
            master = rosgraph.Master(rospy.get_name())
            for topic, kind in get_topic_manager().get_publications():
                master.registerPublisher(topic, kind, rospy.get_node_uri())
        except (rosgraph.MasterException, OSError) as error:
            rospy.logerr("subscribers cannot be reconnected: %s", error)

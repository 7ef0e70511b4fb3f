"""Subscribers that lost their connection are told where to connect again."""

import time

import rosgraph
import rospy
from rospy.impl.registration import get_topic_manager

DELAYS = (1.0, 4.0)  # [s] wall time before each try: who is busy notices the loss later


def call_subscribers_back(delays=DELAYS):
    """Register this node's publishers with the master once more.

    rospy's subscribers do not try again when a connection ends; the master tells them about a
    publisher when it registers, even if it knows it already.
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
            rospy.logerr("subscribers cannot be called back: %s", error)

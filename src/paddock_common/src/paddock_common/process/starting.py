"""The start of a node without what delays it."""

import time
from types import SimpleNamespace

import rospy
import rospy.impl.init

from paddock_common.process import serving

LOOK = 0.003  # [s] between two looks whether the master has registered the node


def init_node(name, **options):
    """Calls rospy.init_node, which looks for its registration every 0.1 s: here it does so sooner.

    Args:
        name: Of the node.
        options: rospy.init_node's.
    """
    serving.end_with_node()
    clock = rospy.impl.init.time
    rospy.impl.init.time = SimpleNamespace(sleep=lambda seconds: time.sleep(min(seconds, LOOK)))
    try:
        rospy.init_node(name, **options)
    finally:
        rospy.impl.init.time = clock

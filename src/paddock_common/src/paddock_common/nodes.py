"""The life of a node: it starts, or says in one sentence why it cannot."""

import sys

import rospy

from paddock_common.logs import bear_failures
from paddock_common.process import signals
from paddock_common.process.orphans import end_with_roslaunch


def start(name, make, errors=ValueError):
    """Starts a node.

    Args:
        name: Of the node.
        make: Class or function without arguments that connects.
        errors: Exceptions that tell what keeps it from starting: they are logged, and the process
            ends with exit status 1.

    Returns:
        What `make` gave.
    """
    bear_failures()
    signals.init_node(name)
    end_with_roslaunch()
    try:
        return make()
    except errors as error:
        rospy.logfatal("%s cannot start: %s", name, error)
        sys.exit(1)


def run(name, make, errors=ValueError):
    """Starts a node and waits until ROS shuts down; arguments as those of start."""
    node = start(name, make, errors)
    rospy.spin()
    return node

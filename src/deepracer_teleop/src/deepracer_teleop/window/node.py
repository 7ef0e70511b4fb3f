"""The node `teleop`, and the start and end of other nodes with this window."""

import signal
import sys
import time

import rosgraph
import rospy
from paddock_common.settings import read

from deepracer_teleop.window.master_watch import MasterWatch, run_id
from deepracer_teleop.window.settings import Settings
from deepracer_teleop.window.window import InterfaceWindow


def connect(name):
    """Starts the ROS node and builds the window with the node's private parameters.

    Args:
        name: The node's name.

    Returns:
        InterfaceWindow.

    Raises:
        ConnectionError: No ROS master answers.
        ValueError: A parameter is wrong; the message names it.
    """
    uri = rosgraph.get_master_uri()
    if run_id(uri, 5.0) is None:
        raise ConnectionError(
            f"no ROS master answers at {uri}; start roscore (or a launch file), "
            "or set ROS_MASTER_URI"
        )
    rospy.init_node(name, disable_signals=True)
    window = InterfaceWindow(read(Settings, rospy.get_param), MasterWatch(uri))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: window.close())
    return window


def leave():
    """Ends the node after its last command is sent."""
    time.sleep(0.1)  # rospy sends from a thread
    rospy.signal_shutdown("the window was closed")


def main():
    """Runs the node `teleop`; returns its exit code."""
    try:
        window = connect("teleop")
    except (ConnectionError, ValueError) as error:
        print(f"teleop cannot start: {error}", file=sys.stderr)
        return 1
    code = window.executeInterface()
    leave()
    return code

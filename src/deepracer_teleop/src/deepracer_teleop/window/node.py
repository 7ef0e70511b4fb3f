"""The node `teleop`, and the start and shutdown of other nodes with this window."""

import sys

import rosgraph
import rospy
from paddock_common.master import ERRORS, MasterMonitor
from paddock_common.nodes import tolerate_log_errors
from paddock_common.process import StopRequest, exit_with_roslaunch
from paddock_common.settings import read
from paddock_common.waiting import flush

from deepracer_teleop.window.settings import Settings, WindowGeometry
from deepracer_teleop.window.status import run_id
from deepracer_teleop.window.window import InterfaceWindow
from paddock_common import nodes

MASTER_LIMIT = 30.0  # for a master that accepts connections and does not respond, at the start [s]


def connect(name, geometry=None) -> InterfaceWindow:
    """Starts the ROS node and builds the window with the node's private parameters.

    Args:
        geometry: WindowGeometry that stores position and size, or None.

    Raises:
        ConnectionError: No ROS master responds.
        ValueError: A parameter is not valid; the message has its name.
    """
    uri = rosgraph.get_master_uri()
    try:
        run_id(uri, MASTER_LIMIT)
    except ERRORS:
        raise ConnectionError(
            f"no ROS master responds at {uri}; start roscore (or a launch file), "
            "or set ROS_MASTER_URI"
        ) from None
    tolerate_log_errors()
    nodes.init_node(name, disable_signals=True)
    exit_with_roslaunch()
    window = InterfaceWindow(read(Settings, rospy.get_param), MasterMonitor(uri, run_id), geometry)
    StopRequest(then=window.close)
    return window


def send_last(window):
    """Waits until the last command of an InterfaceWindow is sent."""
    publisher = window.publisher()
    if publisher is not None:
        flush(publisher)


def leave(window):
    """Shuts the node down after the last command of its InterfaceWindow is sent."""
    send_last(window)
    rospy.signal_shutdown("the window was closed")


def main():
    """Runs the node `teleop`; returns its exit code."""
    try:
        window = connect("teleop", WindowGeometry())
    except (ConnectionError, ValueError) as error:
        print(f"teleop cannot start: {error}", file=sys.stderr)
        return 1
    code = window.executeInterface()
    leave(window)
    return code

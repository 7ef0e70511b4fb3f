"""gzclient: asks the running simulator to open its viewer, and stays until the end."""

import os
import sys

import rospy
from std_srvs.srv import Trigger

from paddock_common import nodes, waiting

SERVICE = "/gazebo/open_viewer"
TIMEOUT = 60.0  # [s] wall clock


def open_viewer(service=SERVICE, timeout=TIMEOUT):
    """Opens the viewer.

    Returns:
        '' or why there is none.

    Raises:
        rospy.ROSInterruptException: the node was shut down meanwhile.
    """
    try:
        waiting.wait_for_service(service, timeout)
        answer = rospy.ServiceProxy(service, Trigger)()
    except (waiting.WaitTimeout, rospy.ServiceException) as error:
        return str(error)
    return "" if answer.success else answer.message


def main():
    """Runs the node; returns 0 also without a viewer: the simulation does not need one."""
    nodes.init_interruptible("gazebo_gui", anonymous=True)
    if not any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")):
        print("gzclient: no display (DISPLAY is not set), so no viewer", file=sys.stderr)
        return 0
    try:
        problem = open_viewer()
    except rospy.ROSInterruptException:
        return 0
    if problem:
        rospy.logwarn("no viewer: %s", problem)
        return 0
    rospy.spin()
    return 0

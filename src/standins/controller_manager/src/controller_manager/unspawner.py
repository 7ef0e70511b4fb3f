"""The unspawner node: stop controllers while it runs, start them again on exit."""

import time

import rospy

from controller_manager import ending, options
from controller_manager.client import ManagerClient, ManagerError, run_bounded
from paddock_common import nodes, waiting

SHUTDOWN_TIMEOUT = 2.0  # [s], wall clock


def main():
    """Runs the node; returns its exit code: 0, or 1 when the controllers could not be stopped."""
    opts = options.parse_unspawner(rospy.myargv()[1:])
    nodes.init_node("unspawner", anonymous=True, disable_signals=True)
    ending.watch()
    manager = ManagerClient(opts.namespace)
    try:
        manager.wait(opts.timeout, ["switch_controller"])
        if not manager.switch(stop=opts.controllers):
            raise ManagerError("controllers did not stop: {}".format(", ".join(opts.controllers)))
    except rospy.ROSInterruptException:
        return 0
    except ManagerError as error:
        rospy.logfatal("unspawner: %s", error)
        return 1
    rospy.loginfo("Stopped %s", ", ".join(opts.controllers))
    while not ending.over():
        time.sleep(waiting.POLL_PERIOD)
    reason = run_bounded(
        lambda: manager.switch(start=opts.controllers, strict=False), SHUTDOWN_TIMEOUT
    )
    if reason and manager.is_there():
        rospy.logwarn(f"Controllers were not started again: {reason}")
    rospy.signal_shutdown("the unspawner has ended")
    return 0

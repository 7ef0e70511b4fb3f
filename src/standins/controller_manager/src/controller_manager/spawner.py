"""The spawner node: bring controllers up, keep them, take them down on exit."""
import time

import rospy
from std_msgs.msg import Bool

from controller_manager import options, waiting
from controller_manager.bring_up import Spawner
from controller_manager.client import ManagerClient, ManagerError, run_bounded


def wait_for_true(topic):
    """Waits for a Bool that is true; says so when nothing comes for a while."""
    heard = []
    subscriber = rospy.Subscriber(topic, Bool, lambda message: heard.append(message.data))
    start = time.monotonic()

    def _true():
        if not heard and time.monotonic() - start > 10.0:
            rospy.logwarn_once('Nothing heard yet on %s (--wait-for)' % subscriber.resolved_name)
        return True in heard

    waiting.wait_until(_true, None, 'topic ' + subscriber.resolved_name)
    subscriber.unregister()


def main():
    """Runs the node; returns its exit code: 0, or 1 when nothing could be brought up."""
    opts = options.parse_spawner(rospy.myargv()[1:])
    rospy.init_node('spawner', anonymous=True)
    begin = time.monotonic()
    manager = ManagerClient(opts.namespace)
    spawner = Spawner(manager, rospy.loginfo, rospy.logerr)

    def _on_shutdown():
        reason = run_bounded(spawner.take_down, opts.shutdown_timeout)
        if reason:
            rospy.logwarn('Controllers were not taken down: %s' % reason)

    rospy.on_shutdown(_on_shutdown)
    try:
        controllers, parameters = options.expand(opts.controllers)
        for name, value in parameters.items():
            rospy.set_param(name, value)
        manager.wait(opts.timeout)
        if opts.wait_for:
            wait_for_true(opts.wait_for)
        spawner.bring_up(controllers, start=not opts.stopped)
    except rospy.ROSInterruptException:
        return 0
    except (ManagerError, ValueError, OSError) as error:
        if rospy.is_shutdown():
            return 0
        rospy.logfatal('spawner: %s', error)
        return 1
    if not spawner.loaded and not rospy.is_shutdown():
        rospy.logfatal('spawner: none of the controllers loaded: %s', ', '.join(controllers))
        return 1
    rospy.loginfo('%s %d of %d controllers in %.2f s: %s',
                  'Started' if spawner.started else 'Loaded', len(spawner.loaded),
                  len(controllers), time.monotonic() - begin, ', '.join(spawner.loaded))
    rospy.spin()
    return 0

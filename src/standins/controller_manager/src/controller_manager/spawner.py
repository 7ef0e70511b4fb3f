"""The nodes spawner and unspawner."""

import time

import rospy
from paddock_common.process import StopRequest
from std_msgs.msg import Bool

from controller_manager import command_line
from controller_manager.client import ManagerClient, ManagerError, Spawner, run_bounded
from paddock_common import nodes, waiting

SHUTDOWN_TIMEOUT = 2.0  # [s], wall clock
LEAVING_TIME = 1.0  # [s] time for a simulator that shuts down at the same time to respond


def start_node(name):
    """Starts a node that still calls services after a signal has requested its exit.

    Returns:
        Function without arguments: whether a shutdown was requested.
    """
    nodes.init_node(name, anonymous=True, disable_signals=True)
    stop = StopRequest()
    return lambda: stop.requested() or rospy.is_shutdown()


def wait_for_true(topic, timeout, stop_requested):
    """Waits for a Bool that is true; logs when none has arrived for a while.

    Args:
        timeout: that while, wall clock [s]; None: it logs nothing.
        stop_requested: of start_node.
    """
    received = []
    subscriber = rospy.Subscriber(topic, Bool, lambda message: received.append(message.data))
    start = time.monotonic()

    def _true():
        if not received and timeout and time.monotonic() - start > timeout:
            rospy.logwarn_once(
                f'Controller Spawner hasn\'t heard anything from its "wait for" topic ({topic})'
            )
        return True in received

    waiting.wait_until(_true, None, "topic " + subscriber.resolved_name, is_shutdown=stop_requested)
    subscriber.unregister()


def wait_for_manager(manager, timeout, stop_requested):
    """Waits for a manager's services, as upstream: as long as there is no simulated time yet.

    Args:
        timeout: wall-clock limit for each service [s]; None: there is none.
        stop_requested: of start_node.

    Returns:
        Whether they are there.
    """
    while True:
        try:
            for service in ("load_controller", "switch_controller", "unload_controller"):
                name = f"{manager.prefix}controller_manager/{service}"
                rospy.loginfo("Controller Spawner: Waiting for service %s", name)
                manager.wait(timeout, [service])
            return True
        except ManagerError as error:
            if stop_requested():
                return False
            if not (rospy.get_param("/use_sim_time", False) and rospy.get_rostime().is_zero()):
                rospy.logwarn(
                    "Controller Spawner couldn't find the expected controller_manager ROS "
                    "interface."
                )
                rospy.logwarn("%s", error)
                return False
            rospy.loginfo("Waiting for /clock to be available...")


def take_down_quietly(spawner, manager, timeout):
    """Stops and unloads controllers; warns about failures unless the manager shuts down, too.

    roslaunch stops all nodes together, and the controllers stop with the simulator.

    Args:
        timeout: wall-clock limit [s].
    """
    failures = []
    spawner.warn = failures.append
    reason = run_bounded(spawner.take_down, timeout)
    if reason:
        failures.append(f"Controllers were not unloaded: {reason}")
    deadline = time.monotonic() + LEAVING_TIME
    while failures and manager.is_there():
        if time.monotonic() > deadline:
            for text in failures:
                rospy.logwarn(text)
            return
        time.sleep(0.05)


def main():
    """Runs the node; returns its exit code: 0, or 1 when a call of the manager failed."""
    opts = command_line.parse_spawner(rospy.myargv()[1:])
    stop_requested = start_node("spawner")
    if opts.shutdown_timeout is not None:
        rospy.logwarn("DEPRECATION warning: --shutdown-timeout has no effect.")
    manager = ManagerClient(opts.namespace, stop_requested)
    spawner = Spawner(manager, rospy.loginfo, rospy.logerr)
    # rosnode kill: later than in this hook a node reads no responses of services.
    rospy.on_shutdown(lambda: take_down_quietly(spawner, manager, SHUTDOWN_TIMEOUT))
    try:
        return run(opts, manager, spawner, stop_requested)
    except rospy.ROSInterruptException:
        return 0
    except (ManagerError, ValueError, OSError) as error:
        if stop_requested():
            return 0
        rospy.logfatal("spawner: %s", error)
        return 1
    finally:
        take_down_quietly(spawner, manager, SHUTDOWN_TIMEOUT)
        rospy.signal_shutdown("the spawner has stopped")


def run(opts, manager, spawner, stop_requested):
    """Loads and starts the controllers and waits for the shutdown; returns the exit code.

    Args:
        stop_requested: of start_node.
    """
    if not wait_for_manager(manager, opts.timeout, stop_requested):
        return 0
    if opts.wait_for:
        wait_for_true(opts.wait_for, opts.timeout, stop_requested)
    controllers, parameters = command_line.expand(opts.controllers)
    for name, value in parameters.items():
        rospy.set_param(name, value)
    spawner.bring_up(controllers, start=not opts.stopped)
    while not stop_requested():
        time.sleep(waiting.POLL_PERIOD)
    return 0


INHIBIT_PERIOD = 3.0  # [s], simulated
CALL_TIMEOUT = 10.0  # [s], wall clock


def inhibit(manager, names, stopped):
    """Stops those of some controllers that run, and adds them to a list of names."""
    running = [name for name in manager.running() if name in names]
    if running:
        rospy.loginfo("Inhibiting controllers: %s", ", ".join(running))
        manager.switch(stop=running, strict=False)
        stopped += [name for name in running if name not in stopped]


def unspawn():
    """Runs the node: stops controllers that run, also later; returns its exit code, see main()."""
    opts = command_line.parse_unspawner(rospy.myargv()[1:])
    stop_requested = start_node("unspawner")
    manager, stopped = ManagerClient(opts.namespace, stop_requested), []
    try:
        manager.wait(opts.timeout, ["switch_controller", "list_controllers"])
        inhibit(manager, opts.controllers, stopped)
    except rospy.ROSInterruptException:
        return 0
    except ManagerError as error:
        rospy.logfatal("unspawner: %s", error)
        return 1
    restarts = [lambda: manager.switch(start=stopped, strict=False)]

    def restart():
        """Starts them again, once: at a signal, or in a hook at rosnode kill as the spawner."""
        reason = run_bounded(restarts.pop(), SHUTDOWN_TIMEOUT) if restarts else None
        if reason and manager.is_there():
            rospy.logwarn(f"Controllers were not started again: {reason}")

    rospy.on_shutdown(restart)
    last = rospy.get_time()
    while not stop_requested():
        time.sleep(waiting.POLL_PERIOD)
        if not 0.0 <= rospy.get_time() - last < INHIBIT_PERIOD:
            last = rospy.get_time()
            reason = run_bounded(lambda: inhibit(manager, opts.controllers, stopped), CALL_TIMEOUT)
            if reason:
                rospy.logwarn("unspawner: %s", reason)
    restart()
    rospy.signal_shutdown("the unspawner has stopped")
    return 0

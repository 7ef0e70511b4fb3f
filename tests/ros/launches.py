"""Starting a launch file from within a test, on the master of that test, and ending it again."""

import os
import subprocess
import time
import xmlrpc.client

import psutil
import rosgraph
import rospy
from paddock_common.process import stop_session
from sim_client import wait_until

STOP_LIMIT = 90.0  # wall time from SIGINT to the end [s]


class Launch:
    """One roslaunch, to be used with `with`.

    Args:
        target: A launch file in this folder, or a package and its launch file.
    """

    def __init__(self, *target, **arguments):
        if len(target) == 1:
            target = (os.path.join(os.path.dirname(os.path.abspath(__file__)), target[0]),)
        self._command = [
            "roslaunch",
            "--wait",
            *target,
            *(f"{name}:={value}" for name, value in arguments.items()),
        ]
        self._process = None

    def __enter__(self):
        self._process = subprocess.Popen(
            self._command, stdin=subprocess.DEVNULL, start_new_session=True
        )
        return self

    def __exit__(self, *exception):
        stop_session(self._process, STOP_LIMIT)
        wait_until(lambda: not self.simulator_is_known(), "the simulator leaving the graph")

    @staticmethod
    def simulator_is_known():
        """Whether a node /gazebo is registered and responds."""
        try:
            uri = rosgraph.Master(rospy.get_name()).lookupNode("/gazebo")
            xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())
        except (rosgraph.MasterException, OSError, xmlrpc.client.Fault):
            return False
        return True


def proxy(node):
    """XML-RPC proxy of a node."""
    return xmlrpc.client.ServerProxy(rosgraph.Master(rospy.get_name()).lookupNode(node))


def simulator():
    """XML-RPC proxy of the simulator's node."""
    return proxy("/gazebo")


def wait_subscribed(topics, node=None, publisher="/gazebo"):
    """Waits until a publisher has counted a node's subscriptions to its topics.

    A subscriber sees its connection a moment before the publisher counts it.

    Args:
        node: Name of the node; None: this one.
        publisher: Name of the publisher's node; by default the simulator.
    """
    node = node or rospy.get_name()
    wanted = {rospy.resolve_name(topic) for topic in topics}

    def all_there():
        try:
            _, _, links = proxy(publisher).getBusInfo(rospy.get_name())
        except (rosgraph.MasterException, OSError):
            return False
        there = {link[4] for link in links if link[1] == node and link[2] == "o" and link[5]}
        return wanted <= there

    wait_until(all_there, f"{publisher} sending {', '.join(sorted(wanted))} to {node}")


def simulator_pid():
    """Process id of the simulator's node."""
    return simulator().getPid(rospy.get_name())[2]


def memory(pid):
    """Resident memory of a process [B]."""
    return psutil.Process(pid).memory_info().rss


def threads(pid):
    """Number of threads of a process."""
    return psutil.Process(pid).num_threads()


def settle(seconds):
    """Sleeps for wall time [s], for connections to close; not for expectations."""
    time.sleep(seconds)

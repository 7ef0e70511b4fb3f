"""The relay process dies: all subscribers reconnect to the simulator."""

import os
import signal
import unittest

import psutil
from launches import simulator_pid
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from shared_worlds import CAR as LAUNCH  # noqa: F401
from sim_client import START_LIMIT, Recorder, sleep_sim, wait_until
from tf2_msgs.msg import TFMessage

from commands import procfs

BACK = 120.0  # wall time until all is as before; it takes about five seconds [s]


def relays(pid):
    """Process ids of the relays that a process has started and that have not ended."""
    children = [child.pid for child in psutil.Process(pid).children()]
    return [
        child
        for child in children
        if any("relay_process" in word for word in procfs.arguments(child))
    ]


class RelayDeath(unittest.TestCase):
    """Kills the relay once."""

    def test_subscribers_come_back(self):
        recorders = {
            name: Recorder(name, kind)
            for name, kind in (
                ("/clock", Clock),
                ("/racecar/joint_states", JointState),
                ("/tf", TFMessage),
            )
        }
        for recorder in recorders.values():
            recorder.wait_count(5, START_LIMIT)
        pid = simulator_pid()
        [relay] = relays(pid)
        os.kill(relay, signal.SIGKILL)
        wait_until(lambda: not relays(pid), "its end")
        counts = {name: len(recorder.messages) for name, recorder in recorders.items()}
        # /tf comes from subscribers of the simulator: a rospy and a roscpp node
        for name, recorder in recorders.items():
            wait_until(lambda r=recorder, n=counts[name]: len(r.messages) > n + 50, name, BACK)
        sleep_sim(1.0)
        stamps = [
            message.header.stamp for message in recorders["/racecar/joint_states"].messages[-20:]
        ]
        self.assertEqual(stamps, sorted(set(stamps)), "each message comes once, in order")

#!/usr/bin/env python3
"""Lets simulated time go on step by step, no faster than the nodes of a control loop follow.

Beside a world that runs by itself a busy machine would let seconds of simulated time pass while a
driver waits for a processor, and its car would leave the road. Here time waits for the driver: it
goes on only while each topic of the loop has brought a message within ~lag of simulated time. A
topic that brings nothing for ~patience of wall time has nothing to say; it counts again from its
next message on. Time in which this process had no processor, as its drivers may have had none, is
no part of that.

A chain may send a command within each lag and fall behind all the same, with its commands in a
queue. So every ~settle of simulated time the pacer waits until the loop is quiet: all that was sent
has been answered. Topics of a node that repeats its commands by itself, as the window does, do not
tell that; it is one of ~nodes, and quiet when all its threads were asleep at looks that make up
longer than two periods of its timers. Time in which it has something to do, but no processor, is no
part of that, nor is time in which the pacer itself had none.

Parameters: ~topics, ~nodes (lists of names), ~lag [s], ~period [s], ~patience [s], ~settle [s].
"""

import pathlib
import sys
import time

import rosgraph
import rospy
from gazebo_msgs.srv import GetPhysicsProperties
from std_srvs.srv import Empty

from bullet_bridge.srv import Step

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "plugins"))

from testing import call, is_asleep  # noqa: E402

START_LIMIT = 180.0  # wall time for the world to come up [s]
NAP = 0.0005  # between two looks [s]
LONGEST_NAP = 0.01  # longer ones were not ours [s]
QUIET = 0.015  # without a message: the loop has settled [s]
LONGEST_SETTLING = 0.2  # of loops that are never quiet [s]
ASLEEP = 0.045  # that all threads of the nodes sleep, in all: two periods of their timers [s]
LONGEST_WAKE = 10.0  # of nodes that never sleep [s]


class Topic:
    """A topic of the loop.

    Attributes:
        seen: Count of periods made when its last message came; None: it has nothing to say.
    """

    def __init__(self, name, count):
        self.name, self.seen, self.messages, self._count = name, None, 0, count
        rospy.Subscriber(name, rospy.AnyMsg, self._on_message, queue_size=1, tcp_nodelay=True)

    def _on_message(self, _message):
        self.seen = self._count()
        self.messages += 1


class Node:
    """A process of the loop, by the name of its node."""

    def __init__(self, name):
        self._name, self._pid = rospy.resolve_name(name), None

    def is_asleep(self):
        """Whether it has nothing to do; True while it is not there."""
        if self._pid is None:
            uri = call(rosgraph.get_master_uri(), "lookupNode", self._name)
            self._pid = uri and call(uri, "getPid")
        return self._pid is None or is_asleep(self._pid)


class Pacer:
    """Makes periods for as long as the world is there."""

    def __init__(self):
        self._made = 0
        self._period = rospy.get_param("~period", 0.016)
        self._lag = max(1, round(rospy.get_param("~lag", 0.048) / self._period))
        self._settle = max(1, round(rospy.get_param("~settle", 0.1) / self._period))
        self._patience = rospy.get_param("~patience", 3.0)
        self._topics = [Topic(name, lambda: self._made) for name in rospy.get_param("~topics")]
        self._nodes = [Node(name) for name in rospy.get_param("~nodes", [])]
        for name in ("pause_physics", "step", "get_physics_properties"):
            rospy.wait_for_service("/gazebo/" + name, START_LIMIT)
        physics = rospy.ServiceProxy("/gazebo/get_physics_properties", GetPhysicsProperties)
        self._steps = round(self._period / physics().time_step)
        self._pause = rospy.ServiceProxy("/gazebo/pause_physics", Empty)
        self._step = rospy.ServiceProxy("/gazebo/step", Step, persistent=True)

    def run(self):
        """Makes periods; ends with the world."""
        self._pause()
        while not rospy.is_shutdown():
            self._wait()
            if self._made % self._settle == 0:
                self._calm_down()
                self._await_sleep()
            answer = self._step(self._steps, [], [])
            if not answer.success:  # somebody let the world run
                rospy.logwarn(answer.status_message)
                self._pause()
            self._made += 1

    def _wait(self):
        """Waits until no topic of the loop is late."""
        waited = 0.0
        while late := [topic for topic in self._topics if self._is_late(topic)]:
            waited += nap()
            if waited > self._patience:
                for topic in late:
                    topic.seen = None

    def _calm_down(self):
        """Waits until no topic of the loop brings anything more."""
        waited, quiet, before = 0.0, 0.0, None
        while quiet < QUIET and waited < LONGEST_SETTLING:
            heard = [topic.messages for topic in self._topics if topic.seen is not None]
            if not heard:
                return
            napped = nap()
            waited += napped
            quiet, before = quiet + napped if heard == before else 0.0, heard

    def _await_sleep(self):
        """Waits until the nodes have nothing to do."""
        waited = asleep = 0.0
        while self._nodes and asleep < ASLEEP and waited < LONGEST_WAKE:
            napped = nap()
            waited += napped
            if all(node.is_asleep() for node in self._nodes):
                asleep += min(napped, 2.0 * NAP)

    def _is_late(self, topic):
        seen = topic.seen
        return seen is not None and self._made - seen > self._lag


def nap():
    """Sleeps a little; gives how long, without time in which others had the processor [s]."""
    before = time.monotonic()
    time.sleep(NAP)
    return min(time.monotonic() - before, LONGEST_NAP)


def main():
    """Runs the node; the world's end is its own."""
    rospy.init_node("pacer")
    try:
        Pacer().run()
    except (rospy.ServiceException, rospy.ROSInterruptException) as error:
        rospy.loginfo("the world has ended: %s", error)


if __name__ == "__main__":
    main()

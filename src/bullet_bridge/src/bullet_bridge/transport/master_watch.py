"""Watching the ROS master: without it nobody finds the simulation any more."""

import time

import rosgraph
import rospy
from paddock_common.master import MasterMonitor, proxy

ANSWER_LIMIT = 2.0  # [s] for an answer
SILENCE = 5.0  # [s] without an answer after which it is said
GONE = 3.0  # [s] for which nobody has listened on the master's port, after which it has ended


def master_pid(uri):
    """Process id of the master.

    Raises:
        paddock_common.master.ERRORS: it gave none.
    """
    with proxy(uri, ANSWER_LIMIT) as master:
        return master.getPid("/gazebo")[2]


class MasterWatch:
    """Asks the master for its process id; ends the simulation when it is gone or another one.

    A master that is silent but there, as when it is stopped or its machine has gone to sleep, is
    waited for without an end.

    Args:
        end: called once with the reason why the simulation has to end.
        uri: of the master; None: that of this node.
        warn: called with one line of text.
        identity: function of the URI -> process id.
        now: clock [s].

    Attributes:
        monitor: MasterMonitor, to be started.
        reason: why the simulation has to end; '' as long as it need not.
    """

    def __init__(self, end, uri=None, warn=rospy.logwarn, identity=master_pid, now=time.monotonic):
        self._end, self._warn = end, warn
        self._said, self.reason = False, ""
        uri = uri or rosgraph.get_master_uri()
        self.monitor = MasterMonitor(uri, identity, self._judge, now)

    def _judge(self):
        uri = self.monitor.uri
        if self.monitor.replaced:
            self._end_with(
                f"another ROS master runs at {uri} now, which does not know this simulation"
            )
        elif self.monitor.refused_for >= GONE:
            self._end_with(f"the ROS master at {uri} is gone")
        elif self._said != (self.monitor.unresponsive_for >= SILENCE):
            self._said = not self._said
            self._warn(
                f"the ROS master at {uri} does not answer; the simulation goes on, new nodes "
                "cannot connect meanwhile"
                if self._said
                else f"the ROS master at {uri} answers again"
            )

    def _end_with(self, reason):
        self.reason = reason
        self.monitor.close()
        self._end(f"{reason}: the simulation ends")

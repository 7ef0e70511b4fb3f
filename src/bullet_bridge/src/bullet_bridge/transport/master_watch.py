"""Watching the ROS master: without it nobody finds the simulation any more.

rospy does not notice a master that dies or is started anew. A node would go on for ever that no
subscriber, no service call and no roslaunch can reach.
"""

import threading
import time

import rosgraph
import rospy

from paddock_common import rpc

PERIOD = 1.0  # [s] between two questions
ANSWER_LIMIT = 2.0  # [s] for an answer
SILENCE = 5.0  # [s] without an answer after which it is said
GONE = 3.0  # [s] for which nobody has listened on the master's port, after which it has ended


def master_pid(uri):
    """Process id of the master.

    Raises:
        rpc.ERRORS: it gave none.
    """
    with rpc.proxy(uri, ANSWER_LIMIT) as master:
        return master.getPid("/gazebo")[2]


class MasterWatch:
    """Asks the master for its process id; ends the simulation when it is gone or another one.

    A master that is silent but there, as when it is stopped or its machine has gone to sleep, is
    waited for without an end.

    Args:
        uri: of the master; None: that of this node.
        end: called once with the reason why the simulation has to end.
        warn: called with one line of text.
        ask: function of the URI -> process id.
        now: clock [s].

    Attributes:
        reason: why the simulation has to end; '' as long as it need not.
    """

    def __init__(self, end, uri=None, warn=rospy.logwarn, ask=master_pid, now=time.monotonic):
        self._uri = uri or rosgraph.get_master_uri()
        self._end, self._warn, self._ask, self._now = end, warn, ask, now
        self._pid = self._silent_since = self._refused_since = None
        self._said = False
        self._closed = threading.Event()
        self.reason = ""

    def start(self):
        """Start the thread."""
        threading.Thread(target=self._watch, name="master-watch", daemon=True).start()

    def close(self):
        """End the thread."""
        self._closed.set()

    def _watch(self):
        while not self._closed.wait(PERIOD) and not self.reason:
            self.check()

    def check(self):
        """Ask once."""
        try:
            pid = self._ask(self._uri)
        except ConnectionRefusedError:
            self._refused()
        except rpc.ERRORS:
            self._refused_since = None
            self._silent()
        else:
            self._answered(pid)

    def _answered(self, pid):
        self._silent_since = self._refused_since = None
        if self._said:
            self._said = False
            self._warn(f"the ROS master at {self._uri} answers again")
        if self._pid is None:
            self._pid = pid
        elif pid != self._pid:
            self._end_with(
                f"another ROS master runs at {self._uri} now, which does not know this simulation"
            )

    def _refused(self):
        if self._refused_since is None:
            self._refused_since = self._now()
        elif self._now() - self._refused_since >= GONE:
            self._end_with(f"the ROS master at {self._uri} is gone")

    def _silent(self):
        if self._silent_since is None:
            self._silent_since = self._now()
        elif not self._said and self._now() - self._silent_since >= SILENCE:
            self._said = True
            self._warn(
                f"the ROS master at {self._uri} does not answer; the simulation goes on, new nodes "
                "cannot connect meanwhile"
            )

    def _end_with(self, reason):
        if not self._closed.is_set():
            self.reason = reason
            self._end(f"{reason}: the simulation ends")

"""The ROS master: calls by XML-RPC, each with a time-out, and whether it is still there.

rospy does not notice a master that dies or is started anew. A node would go on for ever that no
subscriber, no service call and no roslaunch can reach.
"""

import http.client
import threading
import time
import xml.parsers.expat
import xmlrpc.client

# What a call raises when there is no answer, or none that is XML-RPC.
ERRORS = (
    OSError,
    ValueError,
    http.client.HTTPException,
    xmlrpc.client.Error,
    xml.parsers.expat.ExpatError,
)
PERIOD = 1.0  # [s] between two questions of a MasterMonitor


def proxy(uri, timeout):
    """Returns a proxy of an XML-RPC server, to be used in a with statement.

    Args:
        uri: The server's address, http://host:port.
        timeout: Longest wait for an answer [s].
    """
    return xmlrpc.client.ServerProxy(uri, transport=_Transport(timeout))


class _Transport(xmlrpc.client.Transport):
    """A transport with a time-out."""

    def __init__(self, timeout):
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection


class MasterMonitor:
    """Asks a ROS master once a second, in a thread, who it is.

    Args:
        uri: Its address, http://host:port.
        identity: Function of the URI -> what tells this master from another one at the address;
            raises one of ERRORS when there is no answer.
        then: Called in the thread after each question, without arguments.
        now: Clock [s].

    Attributes:
        uri: As given.
        replaced: Whether another master than the first one gave the last answer.
    """

    def __init__(self, uri, identity, then=None, now=time.monotonic):
        self.uri, self.replaced = uri, False
        self._identity, self._then, self._now = identity, then, now
        self._first, self._answered, self._refused_since = None, now(), None
        self._closed = threading.Event()

    @property
    def silent_for(self):
        """Time since the last answer, or since this was made [s]."""
        return self._now() - self._answered

    @property
    def refused_for(self):
        """Time for which nobody has listened on the master's port [s]; 0.0: somebody does."""
        since = self._refused_since
        return 0.0 if since is None else self._now() - since

    def start(self):
        """Starts the thread."""
        threading.Thread(target=self._run, name="master-monitor", daemon=True).start()

    def close(self):
        """Ends the thread; `then` is not called any more."""
        self._closed.set()

    def check(self):
        """Asks once."""
        try:
            identity = self._identity(self.uri)
        except ConnectionRefusedError:
            if self._refused_since is None:
                self._refused_since = self._now()
        except ERRORS:
            self._refused_since = None
        else:
            self._answered, self._refused_since = self._now(), None
            self._first = identity if self._first is None else self._first
            self.replaced = identity != self._first
        if self._then is not None and not self._closed.is_set():
            self._then()

    def _run(self):
        while not self._closed.is_set():
            self.check()
            self._closed.wait(PERIOD)

"""The ROS master: XML-RPC calls, each with a time-out, and whether it is still available.

rospy does not notice when the master dies or is restarted. The node would continue forever, out of
reach of subscribers, service calls and roslaunch.
"""

from __future__ import annotations

import http.client
import threading
import time
import xml.parsers.expat
import xmlrpc.client
from collections.abc import Callable
from typing import Any

from paddock_common.open_files import EXHAUSTED

# What a call raises when there is no response, or one that is not XML-RPC.
ERRORS = (
    OSError,
    ValueError,
    http.client.HTTPException,
    xmlrpc.client.Error,
    xml.parsers.expat.ExpatError,
)
PERIOD = 1.0  # [s] between two requests of a MasterMonitor


def proxy(uri: str, timeout: float) -> xmlrpc.client.ServerProxy:
    """Returns a proxy of an XML-RPC server, to be used in a with statement.

    Args:
        uri: The server's address, http://host:port.
        timeout: Longest wait for a response [s].
    """
    return xmlrpc.client.ServerProxy(uri, transport=_Transport(timeout))


class _Transport(xmlrpc.client.Transport):
    """A transport with a time-out."""

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection


def find_service(uri: str, caller: str, service: str, timeout: float) -> str | None:
    """Returns a service's address, rosrpc://host:port; None if it is not registered.

    Args:
        uri: The master's address.
        caller: Name of this node.
        timeout: Longest wait for the master's response [s]; None is returned without one.
    """
    master: Any
    try:
        with proxy(uri, timeout) as master:
            code, _, address = master.lookupService(caller, service)
    except ERRORS:
        return None
    return address if code == 1 else None


class MasterMonitor:
    """Requests a ROS master's identity once a second, in a thread.

    Args:
        uri: Its address, http://host:port.
        identity: Function of the URI -> value that distinguishes this master from another one at
            the same address; raises one of ERRORS when there is no response.
        then: Called in the thread after each request, without arguments.
        now: Clock [s].

    Attributes:
        uri: As passed.
        replaced: Whether the last response came from a different master than the first one.
    """

    def __init__(
        self,
        uri: str,
        identity: Callable[[str], Any],
        then: Callable[[], object] | None = None,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self.uri, self.replaced = uri, False
        self._identity, self._then, self._now = identity, then, now
        self._first: Any = None
        self._last_response = now()
        self._refused_since: float | None = None
        self._closed = threading.Event()

    @property
    def unresponsive_for(self) -> float:
        """Time since the last response, or since construction [s]."""
        return self._now() - self._last_response

    @property
    def refused_for(self) -> float:
        """Time for which the master's port has refused connections [s]; 0.0: it accepts them."""
        since = self._refused_since
        return 0.0 if since is None else self._now() - since

    def start(self) -> None:
        threading.Thread(target=self._run, name="master-monitor", daemon=True).start()

    def close(self) -> None:
        """Stops the thread; `then` is no longer called."""
        self._closed.set()

    def check(self) -> None:
        try:
            identity = self._identity(self.uri)
        except ConnectionRefusedError:
            if self._refused_since is None:
                self._refused_since = self._now()
        except ERRORS as error:
            self._refused_since = None
            if getattr(error, "errno", None) in EXHAUSTED:  # no file is left to ask it with
                self._last_response = self._now()
        else:
            self._last_response, self._refused_since = self._now(), None
            self._first = identity if self._first is None else self._first
            self.replaced = identity != self._first
        if self._then is not None and not self._closed.is_set():
            self._then()

    def _run(self) -> None:
        while not self._closed.is_set():
            self.check()
            self._closed.wait(PERIOD)

"""Monitors in a thread whether the ROS master responds."""

import threading
import time

from paddock_common import rpc


def run_id(uri, timeout=1.0):
    """Asks a ROS master for the id of its run.

    Args:
        uri: The master's address, http://host:port.
        timeout: How long to wait for an answer [s].

    Returns:
        The id ("" where the master has none), or None if the master does not answer.
    """
    try:
        with rpc.proxy(uri, timeout) as master:
            code, _, value = master.getParam("/paddock_teleop", "/run_id")
            return str(value) if code == 1 else ""
    except (*rpc.ERRORS, ValueError):
        return None


class MasterWatch:
    """Queries the master once a second in a thread."""

    def __init__(self, uri, period=1.0, clock=time.monotonic, ask=run_id):
        """Stores the run id of the present master; start() begins to monitor.

        Args:
            uri: The master's address.
            period: Time between two questions [s].
            clock: Function -> wall time [s].
            ask: Function (uri) -> run id or None.
        """
        self.uri = uri
        self._period, self._clock, self._ask = period, clock, ask
        self._first = None
        self._answered = clock()
        self._replaced = False
        self._stop = threading.Event()

    def start(self):
        """Starts the thread."""
        threading.Thread(target=self._watch, name="master-watch", daemon=True).start()

    def stop(self):
        """Ends the thread."""
        self._stop.set()

    def check(self):
        """Queries the master once."""
        identity = self._ask(self.uri)
        if identity is None:
            return
        if self._first is None:
            self._first = identity
        self._replaced = identity != self._first
        if not self._replaced:
            self._answered = self._clock()

    def problem(self, timeout):
        """Returns a sentence when the master is lost, else an empty string.

        Args:
            timeout: Time without a response after which it counts as lost [s].
        """
        silence = self._clock() - self._answered
        if self._replaced:
            return (
                f"Another ROS master now runs at {self.uri}; it does not know this window. "
                "Close the window and start it again."
            )
        if silence <= timeout:
            return ""
        return (
            f"The ROS master at {self.uri} has not answered for {silence:.0f} s. "
            "Stop still reaches a car that is connected. Start roscore and this window again."
        )

    def _watch(self):
        while not self._stop.is_set():
            self.check()
            self._stop.wait(self._period)

"""An observer that starts the page's node and looks at the world as a browser does."""

import re
import subprocess
import threading
import time

import websocket

from observers import graph

PATIENCE = 60.0  # for the first view [s]


class Page:
    """A page: acknowledges everything, counts views."""

    def __init__(self, url):
        self.views = 0
        self._socket = websocket.create_connection(
            url.replace("http:", "ws:") + "socket", origin="/".join(url.split("/")[:3])
        )
        self._thread = threading.Thread(target=self._receive, daemon=True)
        self._thread.start()

    def _receive(self):
        try:
            while message := self._socket.recv():
                self._socket.send('{"type": "ack"}')
                self.views += message.startswith('{"type": "view"')
        except (OSError, websocket.WebSocketException):
            pass  # closed

    def wait(self):
        """Waits for the first view, for which the node has made the scene."""
        end = time.monotonic() + PATIENCE
        while not self.views:
            if time.monotonic() > end:
                graph.fail(f"a page got no view within {PATIENCE:g} s")
            time.sleep(0.02)

    def close(self):
        self._socket.close()
        self._thread.join()


def start_node(*parameters):
    """Starts the page's node, which ends with this process; returns it and its address.

    Raises:
        OSError: it has ended without an address.
    """
    node = subprocess.Popen(
        ["setpriv", "--pdeathsig", "TERM", "rosrun", "bullet_web", "web", *parameters],
        stdout=subprocess.PIPE,
        text=True,
    )
    for line in node.stdout:
        if found := re.search(r"http://\S+/", line):
            return node, found[0]
    raise OSError(f"the page's node ended with {node.wait()} and without an address")


def look():
    """Answers the node's pid; then each line is a word: "open" (answered at its first view) and
    "close" a page, "count" its views, or "time", answered by the simulated time [s]."""
    graph.join()
    graph.wait_for_controllers()
    simulation = graph.Simulation()
    try:
        node, address = start_node()
    except OSError as error:
        graph.fail(str(error))
    graph.say(pid=node.pid)
    page = None
    while True:
        (word,) = graph.receive()
        if word == "open":
            page = Page(address)
            page.wait()
        elif word == "close":
            page.close()
        graph.say(views=page.views if page else 0, sim=simulation.time())

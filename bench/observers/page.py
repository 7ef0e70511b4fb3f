"""The page's node, and a page that looks at the world as a browser does."""

import re
import subprocess
import threading

import websocket


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

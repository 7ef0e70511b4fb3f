"""The node `web` as a process, and a page of it without a browser."""

import json
import re
import signal
import struct
import subprocess
import threading
import urllib.error
import urllib.request

import websocket
from sim_client import WALL_LIMIT, wait_until
from testing import executable

GRACE = 60.0  # wall time from SIGINT to the end [s]


class WebNode:
    """The node.

    Attributes:
        url: What a browser opens.
    """

    def __init__(self, *parameters, environ=None):
        """Starts it and reads its address."""
        self.process = subprocess.Popen(
            [executable("bullet_web", "web"), *parameters],
            stdout=subprocess.PIPE,
            text=True,
            env=environ,
        )
        self.url = next(
            found[0] for line in self.process.stdout if (found := re.search(r"http://\S+/", line))
        )

    def get(self, path):
        """Bytes of a file below the token."""
        with urllib.request.urlopen(self.url + path, timeout=WALL_LIMIT) as response:
            return response.read()

    def scene(self, number):
        """Fields of a scene; None: another one has come."""
        try:
            return json.loads(self.get(f"scene/{number}"))
        except urllib.error.HTTPError as error:
            if error.code != 404:
                raise
            return None

    def end(self, number=signal.SIGINT):
        """Ends it; gives its exit status."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        status = self.process.wait(GRACE)
        self.process.stdout.close()
        return status


class PageClient:
    """A page: acknowledges what it gets and keeps it.

    Attributes:
        views: fields of all views so far.
        status: the newest.
        notices: texts.
        binary: (head, payload) of all binary messages.
        contacts: the newest message with contact points; None: none yet.
    """

    def __init__(self, url):
        self.views, self.notices, self.binary, self.data = [], [], [], {}
        self.contacts = None
        self.status, self.scene, self.waiting = {}, 0, ""
        self._socket = websocket.create_connection(
            url.replace("http:", "ws:") + "socket",
            timeout=WALL_LIMIT,
            origin="/".join(url.split("/")[:3]),
        )
        self._thread = threading.Thread(target=self._receive, daemon=True)
        self._thread.start()
        wait_until(lambda: self.status, "the status of a page")

    def _receive(self):
        try:
            while True:
                message = self._socket.recv()
                if not message:
                    return
                self.send("ack")
                self._take(message)
        except (OSError, websocket.WebSocketException):
            pass

    def _take(self, message):
        if isinstance(message, bytes):
            (length,) = struct.unpack_from("<I", message)
            self.binary.append((json.loads(message[4 : 4 + length]), message[4 + length :]))
            return
        fields = json.loads(message)
        kind = fields["type"]
        if kind == "view":
            self.views.append(fields["view"])
        elif kind == "notice":
            self.notices.append(fields["text"])
        elif kind == "scene":
            self.scene = fields["number"]
        elif kind == "waiting":
            self.waiting = fields["text"]
        else:
            setattr(self, kind, fields)

    def send(self, kind, /, **fields):
        """Sends a message."""
        self._socket.send(json.dumps({"type": kind, **fields}))

    def act(self, action, /, **fields):
        """Asks for an action."""
        self.send("do", action=action, **fields)

    def row(self, key):
        """The newest row of a body: position, quaternion, joints; None while there is none."""
        if not self.views:
            return None
        return next((row[1:] for row in self.views[-1]["bodies"] if row[0] == key), None)

    def close(self):
        """Closes it as a browser does."""
        self._socket.close()
        self._thread.join(WALL_LIMIT)

"""A VNC client over a WebSocket, as small as tests need it (RFC 6143; raw pixels, no password)."""

import struct
import time

import numpy as np
from websocket import create_connection

LIMIT = 60.0  # longest wait for an answer [s]
LEFT_BUTTON = 1
# 32 bits, depth 24, little endian, true colour, 8 bits each, red << 16, green << 8, blue
PIXELS = struct.pack(">BBBBHHHBBBxxx", 32, 24, 0, 1, 255, 255, 255, 16, 8, 0)
STOP_RED = (0xB3, 0x26, 0x1E)  # letters of the window's Stop button
ROW = 44  # from a button of the window to the one below it [px]


class VncClient:
    """A viewer of a screen.

    Attributes:
        width, height: Of the screen [px].
    """

    def __init__(self, url):
        """Connects.

        Args:
            url: ws://HOST:PORT/PATH.

        Raises:
            websocket.WebSocketBadStatusException: The server refused.
        """
        self._web, self._data = create_connection(url, timeout=LIMIT), b""
        version = self._read(12)
        assert version == b"RFB 003.008\n", version
        self._web.send_binary(version)
        kinds = self._read(self._read(1)[0])
        assert kinds == b"\x01", f"security types {kinds}"  # none
        self._web.send_binary(b"\x01")
        assert self._read(4) == bytes(4)
        self._web.send_binary(b"\x01")  # shared
        self.width, self.height = struct.unpack(">HH", self._read(4))
        self._read(16)
        self._read(struct.unpack(">I", self._read(4))[0])
        self._web.send_binary(b"\x00\x00\x00\x00" + PIXELS)
        self._web.send_binary(struct.pack(">BxHi", 2, 1, 0))  # raw only

    def _read(self, count):
        while len(self._data) < count:
            part = self._web.recv()
            assert part, "the server has closed the connection"
            self._data += part
        taken, self._data = self._data[:count], self._data[count:]
        return taken

    def picture(self):
        """Asks for the whole screen.

        Returns:
            (H, W, 3) uint8 RGB.
        """
        self._web.send_binary(struct.pack(">BBHHHH", 3, 0, 0, 0, self.width, self.height))
        screen = np.zeros((self.height, self.width, 3), np.uint8)
        while True:
            kind = self._read(1)[0]
            if kind == 3:  # text of the clipboard
                self._read(struct.unpack(">xxxI", self._read(7))[0])
            elif kind == 0:
                break
        for _ in range(struct.unpack(">xH", self._read(3))[0]):
            x, y, width, height, _ = struct.unpack(">HHHHi", self._read(12))
            pixels = np.frombuffer(self._read(4 * width * height), np.uint8)
            screen[y : y + height, x : x + width] = pixels.reshape(height, width, 4)[..., 2::-1]
        return screen

    def pointer(self, x, y, buttons=0):
        """Moves the mouse, with buttons pressed or released."""
        self._web.send_binary(struct.pack(">BBHH", 5, buttons, int(x), int(y)))

    def click(self, x, y):
        """Clicks the left button."""
        self.pointer(x, y)
        self.pointer(x, y, LEFT_BUTTON)
        self.pointer(x, y)

    def close(self):
        """Ends the connection."""
        self._web.close()


def stop_button(picture, tolerance=0):
    """Finds the window's Stop button by its red letters.

    Args:
        picture: (H, W, 3) uint8 RGB.
        tolerance: How far a colour may be off, in steps of 8 bits.

    Returns:
        (x, y) of its middle [px]; None if it is not there.
    """
    off = abs(picture.astype(np.int16) - np.array(STOP_RED, np.int16))
    rows, columns = np.nonzero((off <= tolerance).all(axis=2))
    if len(rows) < 10:
        return None
    return float(columns.min() + columns.max()) / 2, float(rows.min() + rows.max()) / 2


def wait_for_window(client, limit=3 * LIMIT):
    """Waits until the teleop window is on the screen.

    Returns:
        (x, y) of its Stop button [px].
    """
    end = time.monotonic() + limit
    while time.monotonic() < end:
        place = stop_button(client.picture())
        if place:
            return place
        time.sleep(0.2)
    raise AssertionError(f"no window with a Stop button on the desk within {limit:g} s")

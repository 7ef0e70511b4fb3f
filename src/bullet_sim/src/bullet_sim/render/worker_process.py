"""The render process as its parent sees it: start, restart, shared memory."""

from __future__ import annotations

import mmap
import os
import pathlib
import pickle
import socket
import struct
import subprocess
import sys
from collections.abc import Iterable, Mapping
from multiprocessing.connection import Connection
from typing import Any, Optional, Tuple

import numpy as np

from bullet_sim.child import Child
from bullet_sim.errors import RenderError
from bullet_sim.pose import Array
from bullet_sim.render.request import DEFAULT, CameraRequest, Quality

Offsets = Tuple[Optional[int], ...]  # of the colors, distances and labels of an image [bytes]
ALIGNMENT = 64  # [bytes] of every array


class SharedMemory:
    """Anonymous shared memory that can grow.

    Args:
        fd: file descriptor from another process's SharedMemory; None: new memory.
    """

    def __init__(self, fd: int | None = None) -> None:
        self.fd = os.memfd_create("images") if fd is None else fd
        self._map: Any = None  # an mmap
        self._size = 0

    def grow(self, size: int) -> None:
        """Set its size [bytes]; existing arrays stay valid."""
        os.ftruncate(self.fd, size)

    def array(self, offset: int, shape: tuple[int, ...], dtype: Any) -> Array:
        """An array in it, at an offset [bytes]."""
        count = int(np.prod(shape))
        if offset + count * np.dtype(dtype).itemsize > self._size:
            self._size = os.fstat(self.fd).st_size
            self._map = mmap.mmap(self.fd, self._size)  # the old one is freed with its arrays
        return np.frombuffer(self._map, dtype, count, offset).reshape(shape)

    def images(self, request: CameraRequest, offsets: Offsets) -> list[Any]:
        """The arrays of a request's images.

        Returns:
            [(H, W, 3) uint8 colors, (H, W) float32 distances or None, (H, W) int32 labels or None]
        """
        size = request.height, request.width
        types: tuple[tuple[Any, tuple[int, ...]], ...]
        types = (np.uint8, (*size, 3)), (np.float32, size), (np.int32, size)
        return [
            None if offset is None else self.array(offset, shape, dtype)
            for offset, (dtype, shape) in zip(offsets, types)
        ]

    def close(self) -> None:
        """Close the file descriptor; the memory is freed with the last array."""
        if self.fd >= 0:
            os.close(self.fd)
        self.fd, self._map, self._size = -1, None, 0


def layout(requests: Iterable[CameraRequest]) -> tuple[list[Offsets], int]:
    """Layout of the images of some cameras in a buffer.

    Returns:
        List of (offset of the colors, of the distances or None, of the labels or None), and the
        buffer's size [bytes].
    """
    result: list[Offsets] = []
    end = 0
    for request in requests:
        pixels = request.width * request.height
        colors, end = end, _aligned(end + 3 * pixels)
        distances = labels = None
        if request.depth:
            distances, end = end, _aligned(end + 4 * pixels)
        if request.labels:
            labels, end = end, _aligned(end + 4 * pixels)
        result.append((colors, distances, labels))
    return result, end


def _aligned(size: int) -> int:
    return -(-size // ALIGNMENT) * ALIGNMENT


class BufferRing:
    """Buffers in a SharedMemory that are used in turn."""

    def __init__(self, memory: SharedMemory, count: int) -> None:
        self._memory, self._end = memory, 0
        self._buffers = [(0, 0)] * count  # (offset, size)

    def next_layout(self, requests: Iterable[CameraRequest]) -> list[Offsets]:
        """Layout of images in the next buffer.

        Returns:
            Offsets in the shared memory, as `layout` returns them.
        """
        offsets, size = layout(requests)
        (start, room), *others = self._buffers
        if size > room:  # a new buffer at the end, at least twice the size: few are abandoned
            start, room = self._end, max(size, 2 * room)
            self._end += room
            self._memory.grow(self._end)
        self._buffers = [*others, (start, room)]
        return [
            tuple(None if offset is None else start + offset for offset in of_request)
            for of_request in offsets
        ]


EXIT_TIMEOUT = 10.0  # [s] from the end of its connection to its own, on a busy machine
HANG_TIMEOUT = 2.5  # [s] of wall time without a reply or any use of a processor
HANG_CHECK = 0.25  # [s] between two checks; a debugger's stop of everything counts as one
START_TIMEOUT = 60.0  # [s] of wall time; a cold Mesa compiles shaders
NICENESS = 5  # lower priority than the physics and the user's nodes
AHEAD = 2  # jobs that it may have: it starts the next one without waiting for its parent
_HEADER = struct.Struct("!i")
COMMAND = (sys.executable, "-m", "bullet_sim.render.worker")
_ROOT = str(pathlib.Path(__file__).resolve().parents[2])


class Worker:
    """One render process and the socket to it.

    Args:
        renderer_type: 'gl' or 'tiny'.
        environment: variables added to the process's environment.
        timeout: for its start, [s] of wall time.

    Attributes:
        details: what renders, in a few words.
        connection: multiprocessing Connection to send to; see worker.py for the messages.
        memory: that it renders to.
        buffers: in it: one for the images that are passed on, the others for jobs that were sent.

    Raises:
        RenderError: it did not start; the message has the last line of its output.
    """

    def __init__(
        self,
        renderer_type: str,
        environment: Mapping[str, str],
        quality: Quality = DEFAULT,
        timeout: float = START_TIMEOUT,
    ) -> None:
        paths = [_ROOT, os.environ.get("PYTHONPATH", "")]
        variables = dict(os.environ, **environment)
        variables["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
        self.renderer_type = renderer_type
        self.memory = SharedMemory()
        self.buffers = BufferRing(self.memory, 1 + AHEAD)
        self._child = Child(
            f"the {renderer_type} renderer",
            COMMAND,
            (str(self.memory.fd), renderer_type, quality.shadows, quality.antialias),
            [self.memory.fd],
            variables,
            niceness=NICENESS,
        )
        self.process, replies = self._child.process, self._child.socket
        self.connection = Connection(os.dup(replies.fileno()))
        self._unread, self._hung = b"", ""
        try:
            if not self.connection.poll(timeout):
                raise RenderError(f"the {renderer_type} renderer is not ready after {timeout:g} s")
            _, self.details = self.connection.recv()
            replies.setsockopt(
                socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", 0, int(1e6 * HANG_CHECK))
            )
        except (EOFError, ConnectionError):
            reason = self.exit_reason()
            self.close()
            raise RenderError(reason) from None
        except RenderError:
            self.close(kill=True)
            raise

    def receive(self) -> Any:
        """The next message from it.

        Raises:
            EOFError, OSError: it exited, or was killed here because it hung: no reply for
                HANG_TIMEOUT and no processor time used meanwhile, as when it is stopped.
        """
        used: int | None = None
        idle = 0
        while not self._has_reply():
            try:
                # One system call: each gives up the GIL, for which the physics competes.
                data = self._child.socket.recv(65536)
            except BlockingIOError:  # nothing for HANG_CHECK
                before, (state, used) = used, self._stat()
                waits = before is None or used > before or state == "R"  # R: for a processor
                idle = 0 if waits else idle + 1
                if idle * HANG_CHECK >= HANG_TIMEOUT:
                    self._hung = (
                        f"{self._child.name} did nothing for {HANG_TIMEOUT:g} s and was killed"
                    )
                    self.process.kill()
                    raise EOFError(self._hung) from None
                continue
            if not data:
                raise EOFError("the renderer closed its connection")
            self._unread += data
        end = self._reply_end()
        reply, self._unread = self._unread[_HEADER.size : end], self._unread[end:]
        return pickle.loads(reply)

    def _reply_end(self) -> int:
        """Where the first reply among the received bytes ends, as Connection.send frames it."""
        return _HEADER.size + _HEADER.unpack_from(self._unread)[0]

    def _has_reply(self) -> bool:
        return len(self._unread) >= _HEADER.size and len(self._unread) >= self._reply_end()

    def _stat(self) -> tuple[str, int]:
        """State and processor time [ticks] of the process."""
        try:
            with open(f"/proc/{self.process.pid}/stat", encoding="ascii", errors="replace") as file:
                fields = file.read().rpartition(")")[2].split()
        except OSError:
            return "", 0
        return fields[0], int(fields[11]) + int(fields[12])

    def exit_reason(self) -> str:
        """The reason why the process exited, in one line."""
        if self._hung:
            return self._hung
        try:
            self.process.wait(EXIT_TIMEOUT)
        except subprocess.TimeoutExpired:
            return f"{self._child.name} closed its connection"
        return self._child.ending()

    def close(self, kill: bool = False) -> None:
        """Stop the process by closing its connection; kill: by SIGKILL."""
        self.connection.close()
        self._child.shut_down()
        if kill:
            self.process.kill()
        self._child.wait(3.0)
        self._child.close()
        self.memory.close()

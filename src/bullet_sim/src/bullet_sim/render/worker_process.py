"""The render process as its parent sees it: start, restart, shared memory."""

import mmap
import os
import pathlib
import pickle
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from bullet_sim.child import Child
from bullet_sim.errors import RenderError
from bullet_sim.pose import Array
from bullet_sim.render.request import DEFAULT, CameraRequest, Quality

Offsets = tuple[int | None, ...]  # of the colors, distances and labels of a picture [bytes]
ALIGNMENT = 64  # [bytes] of every array


class SharedMemory:
    """Anonymous shared memory that can grow.

    Args:
        fd: file descriptor from another process's SharedMemory; None: new memory.

    Attributes:
        fd: file descriptor.
    """

    def __init__(self, fd: int | None = None) -> None:
        self.fd = os.memfd_create("pictures") if fd is None else fd
        self._map: Any = None  # an mmap
        self._size = 0

    def grow(self, size: int) -> None:
        """Set its size [bytes]; existing arrays stay valid."""
        os.ftruncate(self.fd, size)

    def array(self, offset: int, shape: tuple[int, ...], kind: Any) -> Array:
        """An array in it.

        Args:
            offset: [bytes].
            shape, kind: of the array.
        """
        count = int(np.prod(shape))
        if offset + count * np.dtype(kind).itemsize > self._size:
            self._size = os.fstat(self.fd).st_size
            self._map = mmap.mmap(self.fd, self._size)  # the old one is freed with its arrays
        return np.frombuffer(self._map, kind, count, offset).reshape(shape)

    def pictures(self, request: CameraRequest, offsets: Offsets) -> list[Any]:
        """The arrays of a request's pictures.

        Args:
            offsets: as layout gives them.

        Returns:
            [(H, W, 3) uint8 colours, (H, W) float32 distances or None, (H, W) int32 labels or None]
        """
        size = request.height, request.width
        kinds: tuple[tuple[Any, tuple[int, ...]], ...]
        kinds = (np.uint8, (*size, 3)), (np.float32, size), (np.int32, size)
        return [
            None if offset is None else self.array(offset, shape, kind)
            for offset, (kind, shape) in zip(offsets, kinds)
        ]

    def close(self) -> None:
        """Close the file descriptor; the memory is freed with the last array."""
        if self.fd >= 0:
            os.close(self.fd)
        self.fd, self._map, self._size = -1, None, 0


def layout(requests: Iterable[CameraRequest]) -> tuple[list[Offsets], int]:
    """Layout of the pictures of some cameras in a buffer.

    Returns:
        List of (offset of the colours, of the distances or None, of the labels or None), and the
        buffer's size [bytes].
    """
    found: list[Offsets] = []
    end = 0
    for request in requests:
        pixels = request.width * request.height
        colours, end = end, _aligned(end + 3 * pixels)
        distances = labels = None
        if request.depth:
            distances, end = end, _aligned(end + 4 * pixels)
        if request.labels:
            labels, end = end, _aligned(end + 4 * pixels)
        found.append((colours, distances, labels))
    return found, end


def _aligned(size: int) -> int:
    return -(-size // ALIGNMENT) * ALIGNMENT


class BufferRing:
    """Buffers in a SharedMemory that are used in turn.

    Args:
        memory: SharedMemory of the parent.
        count: of the buffers.
    """

    def __init__(self, memory: SharedMemory, count: int) -> None:
        self._memory, self._end = memory, 0
        self._buffers = [(0, 0)] * count  # (offset, size)

    def next_layout(self, requests: Iterable[CameraRequest]) -> list[Offsets]:
        """Layout of pictures in the next buffer.

        Returns:
            Offsets in the shared memory, as `layout` gives them.
        """
        found, size = layout(requests)
        (start, room), *others = self._buffers
        if size > room:  # a new buffer at the end, at least twice the size: few are abandoned
            start, room = self._end, max(size, 2 * room)
            self._end += room
            self._memory.grow(self._end)
        self._buffers = [*others, (start, room)]
        return [
            tuple(None if offset is None else start + offset for offset in offsets)
            for offsets in found
        ]


HANG_TIMEOUT = 2.5  # [s] of wall time without an answer or any use of a processor
HANG_CHECK = 0.25  # [s] between two looks; a debugger's stop of everything counts as one
START_TIMEOUT = 60.0  # [s] of wall time; a cold Mesa compiles shaders
AHEAD = 2  # orders that it may have: it begins the next one without waiting for its parent
_HEADER = struct.Struct("!i")
COMMAND = (sys.executable, "-m", "bullet_sim.render.worker")
_ROOT = str(pathlib.Path(__file__).resolve().parents[2])


class Worker:
    """One render process and the socket to it.

    Args:
        kind: 'gl' or 'tiny'.
        environment: variables added to the process's environment.
        quality: Quality.
        timeout: for its start, [s] of wall time.

    Attributes:
        details: what draws, in a few words.
        connection: multiprocessing Connection to send to; see worker.py for the messages.
        memory: SharedMemory that it draws to.
        buffers: BufferRing in it: one for the pictures that are handed on, the others for orders
            that were sent.
        process: subprocess.Popen.

    Raises:
        RenderError: it did not start; the message has the end of its output.
    """

    def __init__(
        self,
        kind: str,
        environment: Mapping[str, str],
        quality: Quality = DEFAULT,
        timeout: float = START_TIMEOUT,
    ) -> None:
        paths = [_ROOT, os.environ.get("PYTHONPATH", "")]
        variables = dict(os.environ, **environment)
        variables["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
        self.kind = kind
        self.memory = SharedMemory()
        self.buffers = BufferRing(self.memory, 1 + AHEAD)
        self._child = Child(
            f"the {kind} renderer",
            COMMAND,
            (str(self.memory.fd), kind, quality.shadows, quality.antialias),
            [self.memory.fd],
            variables,
        )
        self.process, answers = self._child.process, self._child.socket
        self.connection = Connection(os.dup(answers.fileno()))
        self._unread, self._hung = b"", ""
        try:
            if not self.connection.poll(timeout):
                raise RenderError(f"the {kind} renderer is not ready after {timeout:g} s")
            _, self.details = self.connection.recv()
            answers.setsockopt(
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
            EOFError, OSError: it ended, or was killed here because it hung: no answer for
                HANG_TIMEOUT and no processor time used meanwhile, as when it is stopped.
        """
        used: int | None = None
        idle = 0
        while not self._has_answer():
            try:
                # One system call: each gives up the GIL, for which the physics competes.
                data = self._child.socket.recv(65536)
            except BlockingIOError:  # nothing for HANG_CHECK
                before, (state, used) = used, self._stat()
                waits = before is None or used > before or state == "R"  # R: for a processor
                idle = 0 if waits else idle + 1
                if idle * HANG_CHECK >= HANG_TIMEOUT:
                    self._hung = (
                        f"{self._child.name} did nothing for {HANG_TIMEOUT:g} s and was ended"
                    )
                    self.process.kill()
                    raise EOFError(self._hung) from None
                continue
            if not data:
                raise EOFError("the renderer closed its connection")
            self._unread += data
        end = self._answer_end()
        answer, self._unread = self._unread[_HEADER.size : end], self._unread[end:]
        return pickle.loads(answer)

    def _answer_end(self) -> int:
        """Where the first answer among the received bytes ends, as Connection.send frames it."""
        return _HEADER.size + _HEADER.unpack_from(self._unread)[0]

    def _has_answer(self) -> bool:
        return len(self._unread) >= _HEADER.size and len(self._unread) >= self._answer_end()

    def _stat(self) -> tuple[str, int]:
        """State and processor time [ticks] of the process."""
        try:
            with open(f"/proc/{self.process.pid}/stat", encoding="ascii", errors="replace") as file:
                words = file.read().rpartition(")")[2].split()
        except OSError:
            return "", 0
        return words[0], int(words[11]) + int(words[12])

    def exit_reason(self) -> str:
        """The reason why the process ended, in one line."""
        if self._hung:
            return self._hung
        try:
            self.process.wait(2.0)
        except subprocess.TimeoutExpired:
            return f"{self._child.name} closed its connection"
        return self._child.ending()

    def close(self, kill: bool = False) -> None:
        """End the process by closing its connection; kill: by SIGKILL."""
        self.connection.close()
        self._child.shut_down()
        if kill:
            self.process.kill()
        self._child.wait(3.0)
        self._child.close()
        self.memory.close()


MAX_RESTARTS = 3  # within ...
WINDOW = 60.0  # [s] ... of wall time: a worker that keeps dying is given up


class Restarts:
    """Starts workers in place of dead ones, at most MAX_RESTARTS within WINDOW.

    Args:
        environment: variables for the worker.
        quality: Quality.

    Attributes:
        count: of all restarts.
    """

    def __init__(self, environment: Mapping[str, str], quality: Quality) -> None:
        self._environment, self._quality = environment, quality
        self._last: list[float] = []  # times of the last restarts
        self.count = 0

    def replace(self, dead: Worker) -> tuple[Worker | None, str]:
        """Close a Worker that has died and start another one.

        Returns:
            The new Worker, or None; what has happened, one line.
        """
        text = dead.exit_reason()
        dead.close()
        now = time.monotonic()
        self._last = [moment for moment in self._last if now - moment < WINDOW]
        within = f"{MAX_RESTARTS} times within {WINDOW:g} s"
        if len(self._last) >= MAX_RESTARTS:
            return None, f"{text}; it is not started again after {within}"
        try:
            worker = Worker(dead.kind, self._environment, self._quality)
        except RenderError as error:
            return None, f"{text}; it could not be started again: {error}"
        self._last.append(now)
        self.count += 1
        return worker, f"{text}; started again (at most {within})"

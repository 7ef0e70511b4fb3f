"""Memory that the render process and its parent share, so that pictures travel without a copy."""

import mmap
import os

import numpy as np

ALIGNMENT = 64  # [bytes] of every array's beginning


class Arena:
    """A growing piece of anonymous shared memory.

    Args:
        fd: file descriptor that another process's Arena has passed on; None: a new one.

    Attributes:
        fd: file descriptor.
    """

    def __init__(self, fd=None):
        self.fd = os.memfd_create("pictures") if fd is None else fd
        self._map, self._size = None, 0

    def grow(self, size):
        """Make it `size` bytes large; arrays made before stay valid."""
        os.ftruncate(self.fd, size)

    def array(self, offset, shape, kind):
        """An array in it.

        Args:
            offset: of its beginning [bytes].
            shape, kind: of the array.
        """
        count = int(np.prod(shape))
        if offset + count * np.dtype(kind).itemsize > self._size:
            self._size = os.fstat(self.fd).st_size
            self._map = mmap.mmap(self.fd, self._size)  # the old one lives as long as its arrays
        return np.frombuffer(self._map, kind, count, offset).reshape(shape)

    def close(self):
        """Let go of the file descriptor; the memory is freed with the last array."""
        if self.fd >= 0:
            os.close(self.fd)
        self.fd, self._map, self._size = -1, None, 0


def places(requests):
    """Where in a bank the pictures of some cameras go.

    Args:
        requests: CameraRequests.

    Returns:
        List of (offset of the colours, offset of the distances or None), and the bank's size
        [bytes].
    """
    found, end = [], 0
    for request in requests:
        pixels = request.width * request.height
        colours, end = end, _aligned(end + 3 * pixels)
        distances = None
        if request.depth:
            distances, end = end, _aligned(end + 4 * pixels)
        found.append((colours, distances))
    return found, end


def _aligned(size):
    return -(-size // ALIGNMENT) * ALIGNMENT


class Banks:
    """Two parts of an Arena by turns: one is written while what is in the other is used.

    Args:
        arena: Arena of the parent.
    """

    def __init__(self, arena):
        self._arena, self._end = arena, 0
        self._banks = [(0, 0), (0, 0)]  # (offset, size)

    def take(self, requests):
        """Room for pictures in the bank whose turn it is.

        Returns:
            Offsets in the arena as `places` gives them.
        """
        found, size = places(requests)
        (start, room), other = self._banks
        if size > room:  # a new place at the end; twice the size, so that little is given up
            start, room = self._end, max(size, 2 * room)
            self._end += room
            self._arena.grow(self._end)
        self._banks = [other, (start, room)]
        return [
            (start + colours, distances if distances is None else start + distances)
            for colours, distances in found
        ]

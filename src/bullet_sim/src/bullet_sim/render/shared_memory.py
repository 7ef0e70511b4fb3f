"""Memory shared by the render process and its parent, so that pictures are not copied."""

import mmap
import os

import numpy as np

ALIGNMENT = 64  # [bytes] of every array


class SharedMemory:
    """Anonymous shared memory that can grow.

    Args:
        fd: file descriptor from another process's SharedMemory; None: new memory.

    Attributes:
        fd: file descriptor.
    """

    def __init__(self, fd=None):
        self.fd = os.memfd_create("pictures") if fd is None else fd
        self._map, self._size = None, 0

    def grow(self, size):
        """Set its size [bytes]; existing arrays stay valid."""
        os.ftruncate(self.fd, size)

    def array(self, offset, shape, kind):
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

    def pictures(self, request, offsets):
        """The arrays of a request's pictures.

        Args:
            request: CameraRequest.
            offsets: as layout gives them.

        Returns:
            [(H, W, 3) uint8 colours, (H, W) float32 distances or None, (H, W) int32 labels or None]
        """
        size = request.height, request.width
        kinds = (np.uint8, (*size, 3)), (np.float32, size), (np.int32, size)
        return [
            None if offset is None else self.array(offset, shape, kind)
            for offset, (kind, shape) in zip(offsets, kinds)
        ]

    def close(self):
        """Close the file descriptor; the memory is freed with the last array."""
        if self.fd >= 0:
            os.close(self.fd)
        self.fd, self._map, self._size = -1, None, 0


def layout(requests):
    """Layout of the pictures of some cameras in a buffer.

    Args:
        requests: CameraRequests.

    Returns:
        List of (offset of the colours, of the distances or None, of the labels or None), and the
        buffer's size [bytes].
    """
    found, end = [], 0
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


def _aligned(size):
    return -(-size // ALIGNMENT) * ALIGNMENT


class BufferRing:
    """Buffers in a SharedMemory that are used in turn.

    Args:
        memory: SharedMemory of the parent.
        count: of the buffers.
    """

    def __init__(self, memory, count):
        self._memory, self._end = memory, 0
        self._buffers = [(0, 0)] * count  # (offset, size)

    def next_layout(self, requests):
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

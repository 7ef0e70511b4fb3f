"""Shared memory for pictures."""

import os

import numpy as np
from bullet_sim.render.worker_process import ALIGNMENT, BufferRing, SharedMemory, layout
from test_render import request


def test_another_process_sees_what_is_written():
    first = SharedMemory()
    first.grow(4096)
    second = SharedMemory(os.dup(first.fd))
    first.array(128, (2, 3), np.uint8)[:] = [[1, 2, 3], [4, 5, 6]]
    np.testing.assert_array_equal(second.array(128, (2, 3), np.uint8), [[1, 2, 3], [4, 5, 6]])
    second.close()
    first.close()
    first.close()


def test_arrays_outlive_growth_and_end():
    memory = SharedMemory()
    memory.grow(64)
    old = memory.array(0, (16,), np.float32)
    memory.grow(1 << 20)
    new = memory.array((1 << 20) - 64, (16,), np.float32)
    old[:], new[:] = 1.0, 2.0
    np.testing.assert_array_equal(memory.array(0, (16,), np.float32), 1.0)
    memory.close()
    assert (old == 1.0).all() and (new == 2.0).all()


def test_layouts_do_not_overlap():
    cameras = [
        request("a", 3, 5, depth=True, labels=True),
        request("b", 7, 1),
        request("c", 2, 2, depth=True),
        request("d", 5, 3, labels=True),
    ]
    found, size = layout(cameras)
    parts = []
    for camera, (colours, *others) in zip(cameras, found):
        pixels = camera.width * camera.height
        parts.append((colours, 3 * pixels))
        assert [part is not None for part in others] == [camera.depth, camera.labels]
        parts += [(start, 4 * pixels) for start in others if start is not None]
    assert all(start % ALIGNMENT == 0 for start, _ in parts)
    for (start, length), following in zip(parts, [start for start, _ in parts[1:]] + [size]):
        assert start + length <= following


def test_buffers_take_turns_and_do_not_overlap():
    memory = SharedMemory()
    buffers = BufferRing(memory, 3)
    written = {}
    orders = [
        [request("a", 8, 8)],
        [request("a", 8, 8), request("b", 64, 64)],
        [request("b", 64, 64)],
        [request("a", 8, 8)],
    ] * 6
    kept = []
    for number, cameras in enumerate(orders):
        found = buffers.next_layout(cameras)
        for camera, (offset, *_) in zip(cameras, found):
            memory.array(offset, (camera.height, camera.width, 3), np.uint8)[:] = number
        for array, value in sum(kept, []):  # the pictures of the last two orders are complete
            assert (array == value).all()
        now = [
            (memory.array(offset, (camera.height, camera.width, 3), np.uint8), number)
            for camera, (offset, *_) in zip(cameras, found)
        ]
        kept = [*kept[-1:], now]
        written[number] = os.fstat(memory.fd).st_size
    assert written[11] == written[23], "as much memory as the largest orders need, no more"
    memory.close()

"""Framebuffers of the pictures' sizes, and their way into memory."""

import cv2
import numpy as np

KEPT = 8  # sizes that are kept


class Target:
    """A framebuffer of one size.

    Args:
        context: Context.
        width, height: [px].
        samples: a pixel; 0: one.

    Attributes:
        draw: Framebuffer to draw to.
    """

    def __init__(self, context, width, height, samples):
        gl, size = context.gl, (width, height)
        self._calls, self.size = context.calls, size
        depth = gl.depth_renderbuffer(size, samples=samples)
        context.calls.make_depth_float(depth)
        self.draw = gl.framebuffer([gl.renderbuffer(size, 4, samples=samples)], depth)
        self._flat = gl.framebuffer([gl.renderbuffer(size, 4)]) if samples else self.draw
        self._rgba = np.empty((height, width, 4), np.uint8)

    def colors(self, out=None):
        """The colours, (H, W, 3) uint8, in `out` or a new array."""
        if self._flat is not self.draw:
            self._calls.resolve(self.draw, self._flat)
        self._flat.read_into(self._rgba, components=4)
        return cv2.cvtColor(self._rgba, cv2.COLOR_RGBA2RGB, dst=out)

    def labels(self):
        """The numbers that the label program draws, (H, W) int32; of targets with one sample."""
        self._flat.read_into(self._rgba, components=4)
        return (self._rgba.view("<u4")[:, :, 0] & 0xFFFFFF).astype(np.int32)

    def depth(self):
        """The depth buffer, (H, W) float32; of targets with one sample a pixel."""
        found = np.empty(self.size[::-1], np.float32)
        self.draw.read_into(found, attachment=-1, dtype="f4", components=1)
        return found


class Targets:
    """Targets by size, the least recently used ones dropped."""

    def __init__(self, context):
        self._context, self._kept = context, {}

    def get(self, width, height, samples):
        """The Target of a size."""
        key = (width, height, samples)
        target = self._kept.pop(key, None) or Target(self._context, *key)
        self._kept[key] = target
        if len(self._kept) > KEPT:
            del self._kept[next(iter(self._kept))]
        return target

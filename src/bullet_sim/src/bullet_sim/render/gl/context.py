"""The OpenGL context, its framebuffers, and calls that moderngl does not have."""

from __future__ import annotations

import ctypes
import os
from typing import Any

import cv2
import numpy as np

from bullet_sim.errors import RenderError
from bullet_sim.pose import Array

LOWER_LEFT, ZERO_TO_ONE = 0x8CA1, 0x935F
RENDERBUFFER, DEPTH_COMPONENT32F = 0x8D41, 0x8CAC
READ_FRAMEBUFFER, DRAW_FRAMEBUFFER = 0x8CA8, 0x8CA9
COLOR_BUFFER_BIT, NEAREST = 0x4000, 0x2600


def _function(name: str, *types: Any) -> Any:
    """A function of the current context.

    Raises:
        OSError: the driver has none of that name.
    """
    address_of = ctypes.CDLL("libEGL.so.1").eglGetProcAddress
    address_of.restype, address_of.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
    address = address_of(name.encode())
    if not address:
        raise OSError(f"the OpenGL driver has no {name}")
    return ctypes.CFUNCTYPE(None, *types)(address)


SOFTWARE = ("llvmpipe", "softpipe", "swrast", "SWR")
MIN_VERSION = 330


class Context:
    """A new context, current in the calling thread.

    Attributes:
        gl: moderngl.Context.
        device: the driver's name for what renders.
        software: whether that is the processor.

    Raises:
        RenderError: none can be made; the message has the reason.
    """

    def __init__(self) -> None:
        try:
            import moderngl

            create_context: Any = moderngl.create_context  # its type hint is wrong
        except ImportError as error:
            raise RenderError(f"the Python package moderngl is missing: {error}") from error
        try:
            self.gl = create_context(
                require=MIN_VERSION,
                standalone=True,
                backend="egl",
                libgl="libGL.so.1",
                libegl="libEGL.so.1",
                device_index=int(os.environ.get("EGL_VISIBLE_DEVICES", "0") or 0),
            )
            self._bind_functions()
        except Exception as error:  # pylint: disable=broad-except  # glcontext raises Exception
            raise RenderError(f"no OpenGL context by EGL: {error}") from error
        self._id = self._current()
        self._closed = False
        self.device = self.gl.info["GL_RENDERER"]
        self.software = any(word in self.device for word in SOFTWARE)
        # clip z to 0..w, for a reversed depth buffer that is as precise far away as near by
        self._clip_control(LOWER_LEFT, ZERO_TO_ONE)
        self.gl.gc_mode = "context_gc"

    def _bind_functions(self) -> None:
        unsigned, signed = ctypes.c_uint, ctypes.c_int
        self._current = ctypes.CDLL("libEGL.so.1").eglGetCurrentContext
        self._current.restype, self._current.argtypes = ctypes.c_void_p, []
        self._clip_control = _function("glClipControl", unsigned, unsigned)
        self._bind_renderbuffer = _function("glBindRenderbuffer", unsigned, unsigned)
        self._storage = _function(
            "glRenderbufferStorageMultisample", unsigned, signed, unsigned, signed, signed
        )
        self._bind_framebuffer = _function("glBindFramebuffer", unsigned, unsigned)
        self._blit = _function("glBlitFramebuffer", *[signed] * 8, unsigned, unsigned)

    def make_depth_float(self, renderbuffer: Any) -> None:
        """Change the 24 bits of a depth Renderbuffer of moderngl to a 32 bit float."""
        self._bind_renderbuffer(RENDERBUFFER, renderbuffer.glo)
        width, height = renderbuffer.size
        self._storage(RENDERBUFFER, renderbuffer.samples, DEPTH_COMPONENT32F, width, height)
        self._bind_renderbuffer(RENDERBUFFER, 0)

    def resolve(self, source: Any, target: Any) -> None:
        """Copy the colors of a Framebuffer with several samples a pixel to one with one."""
        size = (0, 0, *source.size)
        self._bind_framebuffer(READ_FRAMEBUFFER, source.glo)
        self._bind_framebuffer(DRAW_FRAMEBUFFER, target.glo)
        self._blit(*size, *size, COLOR_BUFFER_BIT, NEAREST)

    def use(self) -> None:
        """Make it current in the calling thread, where another one may be."""
        if self._current() != self._id:
            self.gl.__enter__()

    def collect(self) -> None:
        """Free what is not referenced any more."""
        self.gl.gc()

    def close(self) -> None:
        """Release it with what was made in it; idempotent."""
        if self._closed:
            return
        self._closed = True
        self.use()
        self.gl.gc()
        self.gl.release()


MAX_TARGETS = 8  # sizes that are stored


class Target:
    """A framebuffer of one size.

    Args:
        width, height: [px].
        samples: a pixel; 0: one.
    """

    def __init__(self, context: Context, width: int, height: int, samples: int) -> None:
        gl, size = context.gl, (width, height)
        self._context, self.size = context, size
        depth = gl.depth_renderbuffer(size, samples=samples)
        context.make_depth_float(depth)
        self.framebuffer = gl.framebuffer([gl.renderbuffer(size, 4, samples=samples)], depth)
        self._flat = gl.framebuffer([gl.renderbuffer(size, 4)]) if samples else self.framebuffer
        self._rgba = np.empty((height, width, 4), np.uint8)

    def colors(self, out: Array | None = None) -> Array:
        """The colors, (H, W, 3) uint8, in `out` or a new array."""
        if self._flat is not self.framebuffer:
            self._context.resolve(self.framebuffer, self._flat)
        self._flat.read_into(self._rgba, components=4)
        return cv2.cvtColor(self._rgba, cv2.COLOR_RGBA2RGB, dst=out)

    def labels(self) -> Array:
        """The numbers that the label program renders, (H, W) int32; of targets with one sample."""
        self._flat.read_into(self._rgba, components=4)
        return (self._rgba.view("<u4")[:, :, 0] & 0xFFFFFF).astype(np.int32)

    def depth(self) -> Array:
        """The depth buffer, (H, W) float32; of targets with one sample a pixel."""
        buffer = np.empty(self.size[::-1], np.float32)
        self.framebuffer.read_into(buffer, attachment=-1, dtype="f4", components=1)
        return buffer


class Targets:
    """Targets by size, the least recently used ones dropped."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._targets: dict[tuple[int, int, int], Target] = {}

    def get(self, width: int, height: int, samples: int) -> Target:
        """The Target of a size."""
        key = (width, height, samples)
        target = self._targets.pop(key, None) or Target(self._context, *key)
        self._targets[key] = target
        if len(self._targets) > MAX_TARGETS:
            del self._targets[next(iter(self._targets))]
        return target

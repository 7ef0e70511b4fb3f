"""The few OpenGL functions that moderngl does not have, through ctypes."""

import ctypes

LOWER_LEFT, ZERO_TO_ONE = 0x8CA1, 0x935F
RENDERBUFFER, DEPTH_COMPONENT32F = 0x8D41, 0x8CAC
READ_FRAMEBUFFER, DRAW_FRAMEBUFFER = 0x8CA8, 0x8CA9
COLOR_BUFFER_BIT, NEAREST = 0x4000, 0x2600


def _function(name, *kinds):
    """A function of the current context.

    Raises:
        OSError: the driver has none of that name.
    """
    address_of = ctypes.CDLL("libEGL.so.1").eglGetProcAddress
    address_of.restype, address_of.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
    address = address_of(name.encode())
    if not address:
        raise OSError(f"the OpenGL driver has no {name}")
    return ctypes.CFUNCTYPE(None, *kinds)(address)


class Calls:
    """The functions, bound to the current context.

    Raises:
        OSError: one of them is missing.
    """

    def __init__(self):
        number, whole = ctypes.c_uint, ctypes.c_int
        self._clip_control = _function("glClipControl", number, number)
        self._bind_renderbuffer = _function("glBindRenderbuffer", number, number)
        self._storage = _function(
            "glRenderbufferStorageMultisample", number, whole, number, whole, whole
        )
        self._bind_framebuffer = _function("glBindFramebuffer", number, number)
        self._blit = _function("glBlitFramebuffer", *[whole] * 8, number, number)

    def depth_from_zero_to_one(self):
        """Clip z to 0..w, for a reversed depth buffer that is as precise far away as near by."""
        self._clip_control(LOWER_LEFT, ZERO_TO_ONE)

    def make_depth_float(self, renderbuffer):
        """Give a depth Renderbuffer of moderngl, which has 24 bits, 32 floating-point ones."""
        self._bind_renderbuffer(RENDERBUFFER, renderbuffer.glo)
        width, height = renderbuffer.size
        self._storage(RENDERBUFFER, renderbuffer.samples, DEPTH_COMPONENT32F, width, height)
        self._bind_renderbuffer(RENDERBUFFER, 0)

    def resolve(self, source, target):
        """Copy the colours of a Framebuffer with several samples a pixel to one with one."""
        size = (0, 0, *source.size)
        self._bind_framebuffer(READ_FRAMEBUFFER, source.glo)
        self._bind_framebuffer(DRAW_FRAMEBUFFER, target.glo)
        self._blit(*size, *size, COLOR_BUFFER_BIT, NEAREST)

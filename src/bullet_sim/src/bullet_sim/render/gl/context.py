"""An OpenGL context without a display, through EGL."""

import os

from bullet_sim.errors import RenderError
from bullet_sim.render.gl.calls import Calls

SOFTWARE = ("llvmpipe", "softpipe", "swrast", "SWR")
LEAST_VERSION = 330


class Context:
    """A new context, current in the calling thread.

    Attributes:
        gl: moderngl.Context.
        calls: Calls.
        device: the driver's name for what draws.
        software: whether that is the processor.

    Raises:
        RenderError: none can be made; the message says why.
    """

    _current = None

    def __init__(self):
        try:
            import moderngl
        except ImportError as error:
            raise RenderError(f"the Python package moderngl is missing: {error}") from error
        try:
            self.gl = moderngl.create_context(
                require=LEAST_VERSION,
                standalone=True,
                backend="egl",
                libgl="libGL.so.1",
                libegl="libEGL.so.1",
                device_index=int(os.environ.get("EGL_VISIBLE_DEVICES", "0") or 0),
            )
            self.calls = Calls()
        except Exception as error:  # pylint: disable=broad-except  # glcontext raises Exception
            raise RenderError(f"no OpenGL context by EGL: {error}") from error
        Context._current = self
        self._closed = False
        self.device = self.gl.info["GL_RENDERER"]
        self.software = any(word in self.device for word in SOFTWARE)
        self.calls.depth_from_zero_to_one()
        self.gl.gc_mode = "context_gc"

    def use(self):
        """Make it current in the calling thread, where another one may be."""
        if Context._current is not self:
            self.gl.__enter__()
            Context._current = self

    def collect(self):
        """Free what is not referenced any more."""
        self.gl.gc()

    def close(self):
        """Release it; what was made in it goes with it. Again: nothing."""
        if self._closed:
            return
        self._closed = True
        self.use()
        self.gl.gc()
        Context._current = None
        self.gl.release()

"""Pictures by PyBullet's own renderers."""

import importlib.util

import cv2
import numpy as np

from bullet_sim.engine.client import Client
from bullet_sim.engine.library import p
from bullet_sim.errors import RenderError
from bullet_sim.files import silenced


class Pictures(Client):
    """Colours and depth as a camera anywhere sees them."""

    _plugin = -1

    def start_renderer(self, kind="auto"):
        """Choose the renderer: 'egl' (GPU or Mesa), 'tiny' (in PyBullet), 'auto': EGL if it works.

        Bodies that were loaded before are not drawn.

        Returns:
            'egl' or 'tiny'.

        Raises:
            RenderError: unknown kind, or EGL was asked for and does not work.
        """
        if kind not in ("auto", "egl", "tiny"):
            raise RenderError(f"renderer is '{kind}', must be auto, egl or tiny")
        if kind != "tiny" and self._plugin < 0:
            found = importlib.util.find_spec("eglRenderer")
            if found:
                with silenced():
                    self._plugin = p.loadPlugin(
                        found.origin, "_eglRendererPlugin", physicsClientId=self._client
                    )
            if self._plugin < 0 and kind == "egl":
                raise RenderError("the EGL renderer does not load: is libegl1 installed?")
        self._renderer = "egl" if kind != "tiny" and self._plugin >= 0 else "tiny"
        return self._renderer

    def render(self, width, height, view, projection, shadow=False):
        """Take a picture.

        Args:
            view, projection: column-major 4x4 matrices, 16 numbers each.

        Returns:
            (H, W, 3) uint8 RGB.
        """
        rgb, _ = self.render_with_depth(width, height, view, projection, shadow)
        return rgb

    def bodies_seen(self, width, height, view, projection):
        """Which body each pixel shows, as render: (H, W) int, -1 where nothing is."""
        picture = p.getCameraImage(
            width,
            height,
            viewMatrix=view,
            projectionMatrix=projection,
            renderer=p.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        return np.asarray(picture[4], dtype=np.int64).reshape(height, width)

    def render_with_depth(self, width, height, view, projection, shadow=False, out=None):
        """As render, with the depth buffer (H, W) float32 in 0..1 (1 = nothing there).

        Args:
            out: (H, W, 3) uint8 array that takes the colours; None: a new one.
        """
        kind = p.ER_TINY_RENDERER if self._renderer != "egl" else p.ER_BULLET_HARDWARE_OPENGL
        picture = p.getCameraImage(
            width,
            height,
            viewMatrix=view,
            projectionMatrix=projection,
            shadow=int(shadow),
            lightDirection=(0.5, 0.4, 1.0),
            renderer=kind,
            flags=p.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
        rgba = np.asarray(picture[2], dtype=np.uint8).reshape(height, width, 4)
        depth = np.asarray(picture[3], dtype=np.float32).reshape(height, width)
        return cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB, dst=out), depth  # 30 times as fast as slicing

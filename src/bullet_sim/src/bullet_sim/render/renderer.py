"""What both renderers share: images of a request, the sources of models, the sky."""

from __future__ import annotations

import zlib
from collections.abc import Collection, Iterable
from functools import lru_cache

import cv2
import numpy as np

from bullet_sim.description.world import Scene
from bullet_sim.errors import RenderError
from bullet_sim.pose import Array
from bullet_sim.render import lenses
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors import camera
from bullet_sim.sensors.camera import FAR_DEPTH
from bullet_sim.snapshot import BodySource, Snapshot

ZENITH = (110, 160, 220)
HORIZON = (205, 222, 240)


def gradient(height: int) -> Array:
    """Sky colors of one image column, (H, 1, 3) uint8: ZENITH on top, HORIZON from the center
    down (in image rows: it does not tilt with the camera)."""
    mix = np.minimum(np.arange(height) / max(height / 2.0, 1.0), 1.0)[:, None, None]
    return np.rint((1 - mix) * np.array(ZENITH) + mix * np.array(HORIZON)).astype(np.uint8)


@lru_cache(maxsize=16)
def _sky(height: int, width: int) -> Array:
    return np.ascontiguousarray(np.broadcast_to(gradient(height), (height, width, 3)))


def paint_sky(rgb: Array, depth: Array) -> Array:
    """Replace pixels where nothing was rendered.

    Args:
        rgb: (H, W, 3) uint8, contiguous, changed in place.
        depth: (H, W) float32 OpenGL depth buffer, 0 near ... 1 nothing.

    Returns:
        rgb.
    """
    empty = (depth >= FAR_DEPTH).view(np.uint8)
    return cv2.copyTo(_sky(*rgb.shape[:2]), empty, rgb)  # 20 times as fast as numpy's masks


class Renderer:
    """Renders the bodies of the last sync_sources() at the poses of the last apply()."""

    def sync_sources(self, sources: Iterable[BodySource], scene: Scene | None = None) -> None:
        """Show these bodies.

        Args:
            sources: the complete list.
            scene: with the lights; None: as before.

        Raises:
            RenderError: what cannot be rendered, all in one message; the rest is rendered.
        """
        raise NotImplementedError

    def apply(self, snapshot: Snapshot) -> None:
        """Put every body where a Snapshot has it; bodies without a state stay."""
        raise NotImplementedError

    def image(
        self, request: CameraRequest, rgb: Array | None = None, depth: Array | None = None
    ) -> tuple[Array, Array | None]:
        """What a camera sees of the applied snapshot, without noise.

        Args:
            rgb, depth: arrays of the right shape and type that take the result; None: new ones.

        Returns:
            (H, W, 3) uint8 RGB and (H, W) float32 [m] along the optical axis (far where nothing
            is), None unless requested; top row first, C-contiguous.

        Raises:
            RenderError: the camera's body or link does not exist.
        """
        raise NotImplementedError

    def label_image(self, request: CameraRequest) -> Array:
        """Which body a pinhole camera sees in each pixel of the applied snapshot.

        Returns:
            (H, W) int32, BodySource.key, 0 where nothing is.

        Raises:
            RenderError: the camera's body or link does not exist.
        """
        raise NotImplementedError

    def labels(self, request: CameraRequest, out: Array | None = None) -> Array:
        """A label image through the camera's lens; labels of neighbors are never mixed.

        Args:
            out: (H, W) int32 that takes the result; None: a new one.

        Returns, Raises:
            As label_image().
        """
        if out is None:
            out = np.empty((request.height, request.width), np.int32)
        if request.lens is not None or request.distortion is not None:
            out[:] = lenses.warped_labels(self.label_image, request)
        else:
            out[:] = self.label_image(request)
        return out

    def render(self, request: CameraRequest, step: int = 0) -> Array:
        """As render_with_depth, without the distances."""
        return self.render_with_depth(request, step)[0]

    def render_with_depth(
        self,
        request: CameraRequest,
        step: int = 0,
        rgb: Array | None = None,
        depth: Array | None = None,
    ) -> tuple[Array, Array | None]:
        """Render one camera's view, with its noise.

        Args:
            step: physics step of the applied snapshot; chooses the noise.
            rgb, depth: as of image().

        Returns:
            As image(). The noise is on the colors alone.

        Raises:
            RenderError: the camera's body or link does not exist.
            ValueError: the camera's size, angle or clip distances make no image.
        """
        camera.check(
            request.width, request.height, request.horizontal_fov, request.near, request.far
        )
        if request.lens is not None or request.distortion is not None:
            rgb, depth = lenses.warped_image(self.image, request, rgb, depth)
        else:
            rgb, depth = self.image(request, rgb, depth)
        if request.noise_stddev > 0.0 or request.noise_mean:
            # the same for a seed, a camera's name and a step, however many frames were skipped
            rng = np.random.default_rng([request.seed, zlib.crc32(request.name.encode()), step])
            rgb[:] = camera.add_noise(rgb, request.noise_stddev, rng, request.noise_mean)
        return rgb, depth

    def close(self) -> None:
        """Release what it has."""
        raise NotImplementedError


def check_body(request: CameraRequest, loaded: Collection[int]) -> None:
    """Raise RenderError when the body of a request's camera is not among the loaded keys."""
    if request.key not in loaded:
        raise RenderError(
            f"camera {request.name}: body {request.key} is not loaded, loaded are {sorted(loaded)}"
        )


def check_link(request: CameraRequest, count: int) -> None:
    """Raise RenderError when a request's body has only `count` links."""
    if not 0 <= request.link_index < count:
        raise RenderError(
            f"camera {request.name}: link index {request.link_index}, body "
            f"{request.key} has 0 to {count - 1}"
        )

"""What every renderer's pictures have in common: checks and noise."""

import zlib

import numpy as np

from bullet_sim.errors import RenderError
from bullet_sim.render.lenses import plumb_bob, wide_angle
from bullet_sim.sensors import camera


class Pictures:
    """A renderer: what draws implements `picture` and `label_picture`."""

    def picture(self, request, rgb=None, depth=None):
        """What a camera sees of the applied snapshot, without noise.

        Args:
            request: CameraRequest.
            rgb, depth: arrays of the right shape and type that take the result; None: new ones.

        Returns:
            (H, W, 3) uint8 RGB and (H, W) float32 [m] along the optical axis (far where nothing
            is), None unless the request asks for it; top row first, C-contiguous.

        Raises:
            RenderError: the camera's body or link is not there.
        """
        raise NotImplementedError

    def label_picture(self, request):
        """Which body a pinhole camera sees in each pixel of the applied snapshot.

        Args:
            request: CameraRequest.

        Returns:
            (H, W) int32, BodySource.key, 0 where nothing is.

        Raises:
            RenderError: the camera's body or link is not there.
        """
        raise NotImplementedError

    def labels(self, request, out=None):
        """A label image through the camera's lens; labels of neighbours are never mixed.

        Args:
            request: CameraRequest.
            out: (H, W) int32 that takes the result; None: a new one.

        Returns, Raises:
            As label_picture().
        """
        if out is None:
            out = np.empty((request.height, request.width), np.int32)
        if request.lens is not None:
            out[:] = wide_angle.labels(self.label_picture, request)
        elif request.distortion:
            out[:] = plumb_bob.labels(self.label_picture, request)
        else:
            out[:] = self.label_picture(request)
        return out

    def render(self, request, step=0):
        """Draw one camera's view; as render_with_depth, without the distances."""
        return self.render_with_depth(request, step)[0]

    def render_with_depth(self, request, step=0, rgb=None, depth=None):
        """Draw one camera's view, with its noise.

        Args:
            request: CameraRequest.
            step: physics step of the applied snapshot; chooses the noise.
            rgb, depth: as of picture().

        Returns:
            As picture(). The noise is on the colours alone.

        Raises:
            RenderError: the camera's body or link is not there.
            ValueError: the camera's size, angle or clip distances make no picture.
        """
        camera.check(
            request.width, request.height, request.horizontal_fov, request.near, request.far
        )
        if request.lens is not None:
            rgb, depth = wide_angle.picture(self.picture, request, rgb), None
        elif request.distortion:
            rgb, depth = plumb_bob.picture(self.picture, request, rgb, depth)
        else:
            rgb, depth = self.picture(request, rgb, depth)
        if request.noise_stddev > 0.0 or request.noise_mean:
            rgb[:] = camera.add_noise(
                rgb, request.noise_stddev, noise_generator(request, step), request.noise_mean
            )
        return rgb, depth


def check_body(request, loaded):
    """Raise RenderError when the body of a request's camera is not among the loaded keys."""
    if request.key not in loaded:
        raise RenderError(
            f"camera {request.name}: body {request.key} is not loaded, loaded are {sorted(loaded)}"
        )


def check_link(request, count):
    """Raise RenderError when a request's body has only `count` links."""
    if not 0 <= request.link_index < count:
        raise RenderError(
            f"camera {request.name}: link index {request.link_index}, body "
            f"{request.key} has 0 to {count - 1}"
        )


def noise_generator(request, step):
    """Generator of one frame's noise: the same for the same seed, camera name and step,
    however many frames were left out before.

    Args:
        request: CameraRequest.
        step: physics step, >= 0.

    Returns:
        numpy.random.Generator.
    """
    return np.random.default_rng([request.seed, zlib.crc32(request.name.encode()), step])

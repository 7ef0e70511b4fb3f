"""What every renderer's pictures have in common: checks and noise."""

import zlib

import numpy as np

from bullet_sim.sensors import camera


class Pictures:
    """A renderer: what draws implements `picture`."""

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
        rgb, depth = self.picture(request, rgb, depth)
        if request.noise_stddev > 0.0 or request.noise_mean:
            rgb[:] = camera.add_noise(
                rgb, request.noise_stddev, noise_generator(request, step), request.noise_mean
            )
        return rgb, depth


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

"""A copy of the world for rendering: shapes and poses only."""

import math
import zlib

import numpy as np

from bullet_sim.errors import RenderError
from bullet_sim.render.sky import paint_sky
from bullet_sim.sensors import camera
from bullet_sim.sensors.frames import sensor_in_world

# TinyRenderer's rasteriser puts everything this far right and down [px]; OpenGL's does not.
RASTER_OFFSET = {"tiny": (0.5, -0.5), "egl": (0.0, 0.0)}
# EGL's depth buffer is coarse (16 bits with Mesa): with clip distances of 0.05 and 100 m its error
# is up to 3 cm at 10 m. For depths, two pictures with a smaller ratio of clip distances each are
# combined.
COARSE_RATIO = 20.0


class Mirror:
    """Holds the bodies of the newest source list at the poses of the newest snapshot.

    Args:
        engine: an Engine of its own with start_renderer() done. It is never stepped.
        kind: what start_renderer() returned, 'egl' or 'tiny'.
    """

    def __init__(self, engine, kind):
        self.engine = engine
        self._offset = RASTER_OFFSET[kind]
        self._coarse = kind == "egl"
        self._sources = {}
        self._bodies = {}
        self._states = {}

    def sync_sources(self, sources):
        """Load new bodies, remove missing ones, reload those that changed under the same key.

        A body that cannot be loaded is left out until its source changes; the others are loaded.

        Args:
            sources: iterable of BodySource.

        Raises:
            RenderError: bodies that could not be loaded, all in one message.
        """
        wanted = {source.key: source for source in sources}
        for key in [key for key, source in self._sources.items() if wanted.get(key) != source]:
            del self._sources[key]
            self._states.pop(key, None)
            if key in self._bodies:
                self.engine.remove(self._bodies.pop(key))
        failures = []
        for key in sorted(wanted.keys() - self._sources.keys()):
            source = wanted[key]
            self._sources[key] = source
            try:
                self._bodies[key] = self.engine.load(
                    source.path, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), fixed_base=source.fixed_base
                )
            except Exception as error:  # pylint: disable=broad-except
                failures.append(f"body {key} ({source.path}): {error}")
        if failures:
            raise RenderError("not drawn: " + "; ".join(failures))

    def apply(self, snapshot):
        """Set every body to its state in the snapshot; bodies without one stay.

        Args:
            snapshot: Snapshot; states of keys that are not loaded are ignored.
        """
        for state in snapshot.bodies:
            body = self._bodies.get(state.key)
            if body is None or self._states.get(state.key) == state:
                continue
            self.engine.set_base_pose(body, state.position, state.orientation)
            if len(state.joints):
                self.engine.set_joint_positions(body, state.joints)
            self._states[state.key] = state

    def render(self, request, step=0):
        """Draw one camera's view; as render_with_depth, without the distances."""
        return self.render_with_depth(request, step)[0]

    def render_with_depth(self, request, step=0, rgb=None, depth=None):
        """Draw one camera's view.

        Args:
            request: CameraRequest.
            step: physics step of the applied snapshot; chooses the noise.
            rgb, depth: arrays of the right shape and type that take the result; None: new ones.

        Returns:
            (H, W, 3) uint8 RGB and (H, W) float32 [m] along the optical axis (far where nothing
            is), None unless the request asks for it; top row first, C-contiguous. The noise is on
            the colours alone.

        Raises:
            RenderError: the camera's body or link is not there.
            ValueError: the camera's size, angle or clip distances make no picture.
        """
        camera.check(
            request.width, request.height, request.horizontal_fov, request.near, request.far
        )
        position, rotation = self._camera_pose(request)
        view = camera.view_matrix(position, rotation)
        if request.depth and self._coarse and request.far > COARSE_RATIO * request.near:
            middle = math.sqrt(request.near * request.far)
            rgb, metres = self._draw(request, view, middle, request.far, rgb)
            close_rgb, close = self._draw(request, view, request.near, middle)
            seen = close < middle
            rgb[seen], metres[seen] = close_rgb[seen], close[seen]
        else:
            rgb, metres = self._draw(request, view, request.near, request.far, rgb)
        if request.noise_stddev > 0.0 or request.noise_mean:
            rgb[:] = camera.add_noise(
                rgb, request.noise_stddev, noise_generator(request, step), request.noise_mean
            )
        if depth is None or metres is None:
            return rgb, metres
        depth[:] = metres
        return rgb, depth

    def _draw(self, request, view, near, far, out=None):
        """Colours and, if requested, distances [m] between two clip distances."""
        projection = camera.projection_matrix(
            request.horizontal_fov,
            request.width / request.height,
            near,
            far,
            shift=(-self._offset[0] / request.width, -self._offset[1] / request.height),
        )
        rgb, buffer = self.engine.render_with_depth(
            request.width, request.height, view, projection, out=out
        )
        metres = camera.metres_from_buffer(buffer, near, far) if request.depth else None
        return paint_sky(rgb, buffer), metres

    def _camera_pose(self, request):
        body = self._bodies.get(request.key)
        if body is None:
            raise RenderError(
                f"camera {request.name}: body {request.key} is not loaded, "
                f"loaded are {sorted(self._bodies)}"
            )
        positions, orientations = self.engine.link_poses(body)
        if not 0 <= request.link_index < len(positions):
            raise RenderError(
                f"camera {request.name}: link index {request.link_index}, body "
                f"{request.key} has 0 to {len(positions) - 1}"
            )
        return sensor_in_world(
            positions[request.link_index], orientations[request.link_index], request.pose
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

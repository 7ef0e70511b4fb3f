"""A copy of the world in PyBullet, whose renderers render it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

import numpy as np

from bullet_sim.description.world import Scene
from bullet_sim.engine.bullet.camera import PyBulletCamera
from bullet_sim.engine.bullet.client import Client
from bullet_sim.engine.bullet.urdf import visual_urdf
from bullet_sim.errors import RenderError
from bullet_sim.pose import Array, Pose, sensor_in_world
from bullet_sim.render.renderer import Renderer, check_body, check_link, paint_sky
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors import camera
from bullet_sim.snapshot import BodySource, BodyState, Snapshot


class PyBulletRenderer(Renderer):
    """A Renderer by PyBullet's TinyRenderer.

    Attributes:
        offset: how far right and down its rasteriser puts everything [px].
    """

    camera: ClassVar[type[PyBulletCamera]] = PyBulletCamera
    offset: ClassVar[tuple[float, float]] = (0.5, -0.5)

    def __init__(self) -> None:
        self._client = Client(draw=True)  # never stepped
        self._camera = self.camera(self._client)
        self._sources: dict[int, BodySource] = {}
        self._states: dict[int, BodyState] = {}

    def sync_sources(self, sources: Iterable[BodySource], scene: Scene | None = None) -> None:
        """Load new bodies, remove missing ones, reload those that changed under the same key.

        A body that cannot be loaded is skipped until its source changes. The scene is ignored:
        PyBullet's renderers have a light of their own.

        Raises:
            RenderError: as Renderer's.
        """
        current = {source.key: source for source in sources}
        for key in [key for key, source in self._sources.items() if current.get(key) != source]:
            del self._sources[key]
            self._states.pop(key, None)
            if key in self._client.bodies:
                self._client.remove(key)
        failures = []
        for key in sorted(current.keys() - self._sources.keys()):
            source = current[key]
            self._sources[key] = source
            shapes = source.converted or [link.shapes for link in source.links]
            try:
                text = visual_urdf(source.links, shapes)
                self._client.load_text(key, text, "0", fixed_base=source.fixed_base)
            except Exception as error:  # pylint: disable=broad-except
                failures.append(f"body {key}: {error}")
        if failures:
            raise RenderError("not rendered: " + "; ".join(failures))

    def apply(self, snapshot: Snapshot) -> None:
        """See Renderer; states of keys that are not loaded are ignored."""
        for state in snapshot.bodies:
            known = state.key in self._client.bodies
            if not known or self._states.get(state.key) == state:
                continue
            self._client.put(state.key, Pose(state.position, state.orientation), True)
            links = enumerate(self._sources[state.key].links)
            rows = [f"{row}" for row, link in links if link.kind != "fixed"]
            states = {row: (position, 0.0) for row, position in zip(rows, state.joints)}
            self._client.set_joints(state.key, states)
            self._states[state.key] = state

    def image(
        self, request: CameraRequest, rgb: Array | None = None, depth: Array | None = None
    ) -> tuple[Array, Array | None]:
        """See Renderer."""
        view, projection = (
            camera.view_matrix(*self._camera_pose(request)),
            self._projection(request),
        )
        rgb, buffer = self._camera.render(request.width, request.height, view, projection, out=rgb)
        rgb = paint_sky(rgb, buffer)
        if not request.depth:
            return rgb, None
        meters = camera.meters_from_buffer(buffer, request.near, request.far)
        if depth is None:
            return rgb, meters
        depth[:] = meters
        return rgb, depth

    def label_image(self, request: CameraRequest) -> Array:
        """See Renderer."""
        view = camera.view_matrix(*self._camera_pose(request))
        projection = self._projection(request)
        bodies = self._camera.bodies_seen(request.width, request.height, view, projection)
        labels = np.zeros(bodies.shape, np.int32)
        for key, loaded in self._client.bodies.items():
            labels[bodies == loaded.uid] = key
        return labels

    def _projection(self, request: CameraRequest) -> tuple[float, ...]:
        size = request.width, request.height
        shown = camera.shown_intrinsics(*size, request.horizontal_fov, request.intrinsics)
        return camera.projection_matrix(
            request.horizontal_fov,
            request.width / request.height,
            request.near,
            request.far,
            shift=(-self.offset[0] / request.width, -self.offset[1] / request.height),
            shown=None if request.intrinsics is None else shown / np.array([size]).T,
        )

    def _camera_pose(self, request: CameraRequest) -> tuple[Array, Array]:
        if request.key is None:
            return sensor_in_world((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), request.pose)
        check_body(request, self._client.bodies)
        check_link(request, len(self._sources[request.key].links))
        frame = self._client.link_frame((request.key, f"{request.link_index}"))
        return sensor_in_world(*frame, request.pose)

    def close(self) -> None:
        """Close the client."""
        self._client.close()

"""Pictures from the render worker, as Qt signals."""

import threading

from bullet_sim.errors import RenderError
from bullet_sim.render.client import RenderClient
from bullet_sim.render.request import DEFAULT, CameraRequest
from PyQt5.QtCore import QObject, pyqtSignal


class Painter(QObject):
    """Renders one picture at a time in its own render worker.

    Args:
        kind: renderer: auto, gl or tiny.
        quality: Quality of the OpenGL renderer.
    """

    started = pyqtSignal(str)  # which renderer
    drawn = pyqtSignal(object)  # Frame
    failed = pyqtSignal(str)

    def __init__(self, kind, quality=DEFAULT):
        super().__init__()
        self._client = RenderClient(
            on_frame=self.drawn.emit, on_error=self.failed.emit, quality=quality
        )
        self._starter = threading.Thread(target=self._start, args=(kind,), daemon=True)

    def start(self):
        """Start the worker; the signal `started` or `failed` follows."""
        self._starter.start()

    def _start(self, kind):
        try:
            self.started.emit(self._client.start(kind).kind)
        except RenderError as error:
            self.failed.emit(f"no pictures: {error}")

    def set_sources(self, sources, scene=None):
        """Set the bodies, and the Scene with the lights."""
        self._client.set_sources(sources, scene)

    def draw(self, snapshot, camera, width, height, labels=False):
        """Request a picture; the signal `drawn` or `failed` follows.

        Args:
            snapshot: Snapshot.
            camera: OrbitCamera.
            width, height: [px].
            labels: whether the Frame also tells which body each pixel shows.
        """
        near, far = camera.clip
        self._client.submit(
            snapshot,
            [
                CameraRequest(
                    "viewer",
                    None,  # its pose is in the world
                    0,
                    camera.pose,
                    width,
                    height,
                    camera.horizontal_fov,
                    near,
                    far,
                    labels=labels,
                )
            ],
        )

    def close(self):
        """End the worker."""
        if self._starter.is_alive():
            self._starter.join(10.0)
        self._client.close()

"""The viewer's window."""

import threading
import time

import numpy as np
from bullet_sim.errors import RenderError
from bullet_sim.render.client import RenderClient
from bullet_sim.render.request import DEFAULT, CameraRequest
from PyQt5.QtCore import QObject, QTimer, pyqtSignal
from PyQt5.QtWidgets import QCheckBox, QComboBox, QLabel, QMainWindow, QPushButton, QSpinBox

from bullet_viewer.view import Overlay, RealTimeFactor, View


class Renderer(QObject):
    """Renders one image at a time in its render worker.

    Args:
        renderer_type: auto, gl or tiny.
        quality: Quality of the OpenGL renderer.
    """

    started = pyqtSignal(str)  # which renderer
    rendered = pyqtSignal(object)  # Frame
    failed = pyqtSignal(str)

    def __init__(self, renderer_type, quality=DEFAULT):
        super().__init__()
        self._client = RenderClient(
            on_frame=self.rendered.emit, on_error=self.failed.emit, quality=quality
        )
        self._starter = threading.Thread(target=self._start, args=(renderer_type,), daemon=True)

    def start(self):
        """Start the worker; the signal `started` or `failed` follows."""
        self._starter.start()

    def _start(self, renderer_type):
        try:
            self.started.emit(self._client.start(renderer_type).kind)
        except RenderError as error:
            self.failed.emit(f"no images: {error}")

    def set_sources(self, sources, scene=None):
        """Set the bodies, and the Scene with the lights."""
        self._client.set_sources(sources, scene)

    def render(self, snapshot, camera, width, height, labels=False):
        """Request an image; the signal `rendered` or `failed` follows.

        Args:
            width, height: [px].
            labels: whether the Frame also has the body of each pixel.
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
        if self._starter.is_alive():
            self._starter.join(10.0)
        self._client.close()


PERIOD = 60  # wall time between two views of the world [ms]: at most 17 a second
MAX_PIXELS = 1280 * 800  # of an image; a larger window shows it enlarged
ERROR_DURATION = 10000  # [ms]
RENDER_TIMEOUT = 10.0  # wall time after which a requested image counts as failed [s]
FREE = "free camera"
FIRST_DISTANCE = 2.0  # distance of the camera from the first model that can move [m]


class ViewerWindow(QMainWindow):
    """Requests views of the world from the feed and shows their images."""

    def __init__(self, feed, renderer):
        super().__init__()
        self.setWindowTitle("Paddock viewer")
        self._feed, self._renderer = feed, renderer
        self._factor = RealTimeFactor()
        self._view_requested = False  # a view was requested and has not arrived
        self._rendering = None  # Overlay, pose, field of view of the image in progress
        self._keys = {}  # body in the newest view -> name of its model
        self._clicked = None  # where, until the image with labels
        self.selected = ""  # name of a model
        self._requested_at = 0.0  # when the image was requested [s]
        self._ready = False  # the render worker runs
        self._displayed = None  # state in the newest image; it is not rendered again
        self._followed = None  # last position of the followed model (3,)
        self._found_movable = False
        self.paused = None
        self.view = View(self)
        self.view.show_message("starting the renderer")
        self.setCentralWidget(self.view)
        self.view.clicked.connect(self._click)
        self._add_tools()
        feed.viewed.connect(self._show_view)
        feed.failed.connect(self._render_failed)
        renderer.started.connect(self._start)
        renderer.rendered.connect(self._show)
        renderer.failed.connect(self._render_failed)
        self._ticker = QTimer(self, interval=PERIOD, timeout=self._tick)
        self._ticker.start()

    def _add_tools(self):
        bar = self.addToolBar("time")
        bar.setMovable(False)
        self.pause_button = QPushButton("Pause", clicked=self._toggle)
        self.step_button = QPushButton(
            "Step", clicked=lambda: self._feed.send("step", self.steps.value())
        )
        self.steps = QSpinBox(minimum=1, maximum=100000, value=1, prefix="by ")
        self.reset_button = QPushButton("Reset", clicked=lambda: self._feed.send("reset"))
        self.follow = QComboBox()
        self.follow.addItem(FREE)
        self.follow.activated.connect(self._start_following)
        self.rays_box = QCheckBox("Lidar rays", checked=True)
        self.contacts_box = QCheckBox("Contacts", toggled=self._send_options)
        for widget in (
            self.pause_button,
            self.step_button,
            self.steps,
            self.reset_button,
            QLabel("  Follow "),
            self.follow,
            self.rays_box,
            self.contacts_box,
        ):
            bar.addWidget(widget)
        self.clock_label = QLabel("-")
        self.selected_label = QLabel("")
        self.renderer_label = QLabel("")
        self.statusBar().addPermanentWidget(self.clock_label, 1)
        self.statusBar().addPermanentWidget(self.selected_label)
        self.statusBar().addPermanentWidget(self.renderer_label)

    def closeEvent(self, event):
        """Close connection and renderer with the window."""
        self._ticker.stop()
        self._feed.close()
        self._renderer.close()
        super().closeEvent(event)

    # time -------------------------------------------------------------------------------------
    def _toggle(self):
        self._feed.send("unpause" if self.paused else "pause")

    def _tick(self):
        if self._rendering is not None and time.monotonic() > self._requested_at + RENDER_TIMEOUT:
            self._render_failed(f"no image within {RENDER_TIMEOUT:g} s, trying again")
        if (
            self._ready
            and not self._view_requested
            and self._rendering is None
            and self.isVisible()
            and not self.isMinimized()
        ):
            self._view_requested = True
            self._feed.send("view")

    def _start(self, renderer_type):
        self._ready = True
        self.renderer_label.setText(f"renderer: {renderer_type}")
        self.view.show_message("rendering the first image")

    # the world --------------------------------------------------------------------------------
    def _show_view(self, world_view):
        """Process a WorldView and request its image."""
        self._view_requested = False
        if world_view.sources is not None:
            self._renderer.set_sources(world_view.sources, world_view.scene)
            self._displayed = None
        self._show_time(world_view)
        self._show_names([entry.name for entry in world_view.models])
        self._aim(world_view)
        self._show_selected(world_view)
        width, height = self._image_size()
        overlay = Overlay(
            world_view.rays if self.rays_box.isChecked() else (),
            world_view.contacts,
            world_view.frames,
        )
        options = (
            bool(overlay.rays),
            world_view.contacts is None,
            world_view.frames and world_view.frames.names,
        )
        requested = (world_view.snapshot, self.view.camera.pose, width, height, *options)
        if requested == self._displayed and self._clicked is None:
            return
        self._displayed = requested
        self._rendering = (overlay, self.view.camera.pose, self.view.camera.horizontal_fov)
        self._requested_at = time.monotonic()
        self._renderer.render(
            world_view.snapshot, self.view.camera, width, height, labels=self._clicked is not None
        )

    def _show(self, frame):
        if frame.labels is not None and self._clicked is not None:
            self._pick(frame.labels)
        if self._rendering is not None:
            rendering, self._rendering = self._rendering, None
            self.view.show_message("")
            self.view.show_image(frame.rgb, *rendering)

    def _render_failed(self, text):
        """Cancel the requested image and show the reason."""
        self._rendering = self._displayed = self._clicked = None
        self._view_requested = False
        self.view.show_message(text)
        self.statusBar().showMessage(text, ERROR_DURATION)

    def _image_size(self):
        width, height = self.view.width(), self.view.height()
        shrink = min(1.0, (MAX_PIXELS / (width * height)) ** 0.5)
        return max(1, round(width * shrink)), max(1, round(height * shrink))

    def _show_time(self, world_view):
        factor = self._factor.update(world_view.snapshot.time)
        if world_view.paused != self.paused:
            self.paused = world_view.paused
            self.pause_button.setText("Resume" if world_view.paused else "Pause")
        text = (
            "paused"
            if world_view.paused
            else f"real time x {factor:.2f}"
            if factor is not None
            else ""
        )
        self.clock_label.setText(f"{world_view.snapshot.time:.3f} s   {text}")

    # selection --------------------------------------------------------------------------------
    def _click(self, right, down):
        self._clicked = right, down

    def _pick(self, labels):
        """Select the model that was clicked on; none for the background."""
        (right, down), self._clicked = self._clicked, None
        height, width = labels.shape
        label = labels[min(int(down * height), height - 1), min(int(right * width), width - 1)]
        self._select(self._keys.get(int(label), ""))

    def _select(self, name):
        self.selected = name
        self._send_options()

    def _send_options(self, *_):
        """Request the selected content of views from the bridge."""
        self._feed.send("show", self.selected, self.contacts_box.isChecked())

    def _show_selected(self, world_view):
        """Show the name and the position of the selected model."""
        self._keys = {entry.key: entry.name for entry in world_view.models}
        if self.selected and self.selected not in self._keys.values():
            self._select("")  # it was deleted
        text = ""
        for state in world_view.snapshot.bodies:
            if self.selected and self._keys.get(state.key) == self.selected:
                x, y, z = state.position
                text = f"{self.selected}: x {x:.3f}  y {y:.3f}  z {z:.3f} m  "
        self.selected_label.setText(text)

    # camera -----------------------------------------------------------------------------------
    def _show_names(self, names):
        box = self.follow
        requested = [FREE, *names]
        if requested == [box.itemText(i) for i in range(box.count())]:
            return
        selected = box.currentText()
        box.clear()
        box.addItems(requested)
        box.setCurrentIndex(requested.index(selected) if selected in requested else 0)

    def _start_following(self, *_):
        self._followed = None

    def _aim(self, world_view):
        """Move the target with the followed model; at the start to the first movable model."""
        camera = self.view.camera
        positions = {state.key: np.array(state.position) for state in world_view.snapshot.bodies}
        by_name = {entry.name: positions.get(entry.key) for entry in world_view.models}
        position = by_name.get(self.follow.currentText())
        if position is not None:
            camera.target = (
                position if self._followed is None else camera.target + position - self._followed
            )
        self._followed = position
        if self._found_movable:
            return
        movable = [
            positions[entry.key]
            for entry in world_view.models
            if not entry.static and entry.key in positions
        ]
        if movable:
            self._found_movable = True
            camera.target = movable[0]
            camera.distance = FIRST_DISTANCE

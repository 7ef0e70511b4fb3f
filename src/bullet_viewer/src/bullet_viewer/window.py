"""The viewer's window."""

import threading
import time

import numpy as np
from bullet_sim.errors import RenderError
from bullet_sim.render.client import RenderClient
from bullet_sim.render.request import DEFAULT, CameraRequest
from PyQt5.QtCore import QObject, QTimer, pyqtSignal
from PyQt5.QtWidgets import QCheckBox, QComboBox, QLabel, QMainWindow, QPushButton, QSpinBox

from bullet_viewer.view import Overlay, Pace, View


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


PERIOD = 60  # wall time between two views of the world [ms]: at most 17 a second
MAX_PIXELS = 1280 * 800  # of a drawn picture; a larger window shows it enlarged
TROUBLE_SHOWN = 10000  # [ms]
DRAWING_LIMIT = 10.0  # wall time after which a requested picture counts as failed [s]
FREE = "free camera"
FIRST_LOOK = 2.0  # distance of the camera from the first model that can move [m]


class ViewerWindow(QMainWindow):
    """Requests views of the world from the feed and shows their pictures.

    Args:
        feed: Feed.
        painter: Painter.
    """

    def __init__(self, feed, painter):
        super().__init__()
        self.setWindowTitle("Paddock viewer")
        self._feed, self._painter = feed, painter
        self._pace = Pace()
        self._asked = False  # a view was requested and has not arrived
        self._drawing = None  # Overlay, pose, field of view of the picture that is drawn
        self._keys = {}  # of the bodies in the newest view -> names of their models
        self._clicked = None  # where, until the picture that tells what is there
        self.selected = ""  # name of a model
        self._ordered = 0.0  # when it was requested [s]
        self._ready = False  # the render worker runs
        self._shown = None  # state shown in the newest picture; the same state is not drawn again
        self._followed = None  # where the followed model was (3,)
        self._seen_moving = False
        self.paused = None
        self.view = View(self)
        self.view.show_message("starting the renderer")
        self.setCentralWidget(self.view)
        self.view.clicked.connect(self._click)
        self._add_tools()
        feed.viewed.connect(self._show_view)
        feed.failed.connect(self._drawing_failed)
        painter.started.connect(self._start)
        painter.drawn.connect(self._show)
        painter.failed.connect(self._drawing_failed)
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
        self.contacts_box = QCheckBox("Contacts", toggled=self._ask)
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
        """End with the window."""
        self._ticker.stop()
        self._feed.close()
        self._painter.close()
        super().closeEvent(event)

    # time -------------------------------------------------------------------------------------
    def _toggle(self):
        self._feed.send("unpause" if self.paused else "pause")

    def _tick(self):
        if self._drawing is not None and time.monotonic() > self._ordered + DRAWING_LIMIT:
            self._drawing_failed(f"no picture within {DRAWING_LIMIT:g} s, trying again")
        if (
            self._ready
            and not self._asked
            and self._drawing is None
            and self.isVisible()
            and not self.isMinimized()
        ):
            self._asked = True
            self._feed.send("view")

    def _start(self, kind):
        self._ready = True
        self.renderer_label.setText(f"renderer: {kind}")
        self.view.show_message("drawing the first picture")

    # the world --------------------------------------------------------------------------------
    def _show_view(self, seen):
        """Process a WorldView and request its picture."""
        self._asked = False
        if seen.sources is not None:
            self._painter.set_sources(seen.sources, seen.scene)
            self._shown = None
        self._show_time(seen)
        self._show_names([entry.name for entry in seen.models])
        self._aim(seen)
        self._show_selected(seen)
        width, height = self._picture_size()
        overlay = Overlay(
            seen.rays if self.rays_box.isChecked() else (), seen.contacts, seen.frames
        )
        shown = bool(overlay.rays), seen.contacts is None, seen.frames and seen.frames.names
        wanted = (seen.snapshot, self.view.camera.pose, width, height, *shown)
        if wanted == self._shown and self._clicked is None:
            return
        self._shown = wanted
        self._drawing = (overlay, self.view.camera.pose, self.view.camera.horizontal_fov)
        self._ordered = time.monotonic()
        self._painter.draw(
            seen.snapshot, self.view.camera, width, height, labels=self._clicked is not None
        )

    def _show(self, frame):
        """Show a finished Frame."""
        if frame.labels is not None and self._clicked is not None:
            self._pick(frame.labels)
        if self._drawing is not None:
            drawing, self._drawing = self._drawing, None
            self.view.show_message("")
            self.view.show_picture(frame.rgb, *drawing)

    def _drawing_failed(self, text):
        """Give up the requested picture and show the reason."""
        self._drawing, self._shown, self._asked, self._clicked = None, None, False, None
        self.view.show_message(text)
        self.statusBar().showMessage(text, TROUBLE_SHOWN)

    def _picture_size(self):
        width, height = self.view.width(), self.view.height()
        shrink = min(1.0, (MAX_PIXELS / (width * height)) ** 0.5)
        return max(1, round(width * shrink)), max(1, round(height * shrink))

    def _show_time(self, seen):
        factor = self._pace.update(seen.snapshot.time)
        if seen.paused != self.paused:
            self.paused = seen.paused
            self.pause_button.setText("Resume" if seen.paused else "Pause")
        pace = (
            "paused" if seen.paused else f"real time x {factor:.2f}" if factor is not None else ""
        )
        self.clock_label.setText(f"{seen.snapshot.time:.3f} s   {pace}")

    # selection --------------------------------------------------------------------------------
    def _click(self, right, down):
        self._clicked = right, down

    def _pick(self, labels):
        """Select the model that was clicked on, none beside all of them."""
        (right, down), self._clicked = self._clicked, None
        height, width = labels.shape
        label = labels[min(int(down * height), height - 1), min(int(right * width), width - 1)]
        self._select(self._keys.get(int(label), ""))

    def _select(self, name):
        self.selected = name
        self._ask()

    def _ask(self, *_):
        """Ask the bridge for what the views shall have."""
        self._feed.send("show", self.selected, self.contacts_box.isChecked())

    def _show_selected(self, seen):
        """Show the name and the place of the selected model."""
        self._keys = {entry.key: entry.name for entry in seen.models}
        if self.selected and self.selected not in self._keys.values():
            self._select("")  # it was deleted
        text = ""
        for state in seen.snapshot.bodies:
            if self.selected and self._keys.get(state.key) == self.selected:
                x, y, z = state.position
                text = f"{self.selected}: x {x:.3f}  y {y:.3f}  z {z:.3f} m  "
        self.selected_label.setText(text)

    # camera -----------------------------------------------------------------------------------
    def _show_names(self, names):
        box = self.follow
        wanted = [FREE, *names]
        if wanted == [box.itemText(i) for i in range(box.count())]:
            return
        chosen = box.currentText()
        box.clear()
        box.addItems(wanted)
        box.setCurrentIndex(wanted.index(chosen) if chosen in wanted else 0)

    def _start_following(self, *_):
        self._followed = None

    def _aim(self, seen):
        """Move the target along with the followed model; at first to the first movable model."""
        camera = self.view.camera
        places = {state.key: np.array(state.position) for state in seen.snapshot.bodies}
        by_name = {entry.name: places.get(entry.key) for entry in seen.models}
        place = by_name.get(self.follow.currentText())
        if place is not None:
            camera.target = (
                place if self._followed is None else camera.target + place - self._followed
            )
        self._followed = place
        if self._seen_moving:
            return
        moving = [
            places[entry.key] for entry in seen.models if not entry.static and entry.key in places
        ]
        if moving:
            self._seen_moving = True
            camera.target = moving[0]
            camera.distance = FIRST_LOOK

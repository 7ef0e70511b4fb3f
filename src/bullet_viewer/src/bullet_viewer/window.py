"""The viewer's window: picture, buttons of time, a model to follow, clock and pace."""

import time
from collections import deque

import numpy as np
from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QCheckBox, QComboBox, QLabel, QMainWindow, QPushButton, QSpinBox

from bullet_viewer.view import View

PERIOD = 60  # wall time between two views of the world [ms]: at most 17 a second
MAX_PIXELS = 1280 * 800  # of a drawn picture; a larger window shows it enlarged
PACE_WINDOW = 1.0  # wall time over which the real-time factor is taken [s]
TROUBLE_SHOWN = 10000  # [ms]
DRAWING_LIMIT = 10.0  # wall time after which a requested picture counts as failed [s]
FREE = "free camera"
FIRST_LOOK = 2.0  # distance of the camera from the first model that can move [m]


class Pace:
    """Simulated seconds per second of wall time, over the last PACE_WINDOW."""

    def __init__(self, clock=time.monotonic):
        self._clock, self._samples = clock, deque()

    def update(self, simulated):
        """Update with the simulated time [s]; returns the factor or None while unknown."""
        samples, now = self._samples, self._clock()
        if samples and simulated < samples[-1][1]:  # a reset
            samples.clear()
        samples.append((now, simulated))
        while len(samples) > 2 and now - samples[1][0] >= PACE_WINDOW:
            samples.popleft()
        span = now - samples[0][0]
        return (simulated - samples[0][1]) / span if span >= 0.5 * PACE_WINDOW else None


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
        self._drawing = None  # rays, pose, field of view of the picture that is drawn
        self._ordered = 0.0  # when it was requested [s]
        self._ready = False  # the render worker runs
        self._shown = None  # state shown in the newest picture; the same state is not drawn again
        self._followed = None  # where the followed model was (3,)
        self._seen_moving = False
        self.paused = None
        self.view = View(self)
        self.view.show_message("starting the renderer")
        self.setCentralWidget(self.view)
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
        for widget in (
            self.pause_button,
            self.step_button,
            self.steps,
            self.reset_button,
            QLabel("  Follow "),
            self.follow,
            self.rays_box,
        ):
            bar.addWidget(widget)
        self.clock_label = QLabel("-")
        self.renderer_label = QLabel("")
        self.statusBar().addPermanentWidget(self.clock_label, 1)
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
        width, height = self._picture_size()
        rays = seen.rays if self.rays_box.isChecked() else ()
        wanted = (seen.snapshot, self.view.camera.pose, width, height, bool(rays))
        if wanted == self._shown:
            return
        self._shown = wanted
        self._drawing = (rays, self.view.camera.pose, self.view.camera.horizontal_fov)
        self._ordered = time.monotonic()
        self._painter.draw(seen.snapshot, self.view.camera, width, height)

    def _show(self, frame):
        """Show a finished Frame."""
        if self._drawing is not None:
            drawing, self._drawing = self._drawing, None
            self.view.show_message("")
            self.view.show_picture(frame.rgb, *drawing)

    def _drawing_failed(self, text):
        """Give up the requested picture and show the reason."""
        self._drawing, self._shown, self._asked = None, None, False
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

"""The window's widgets: layout and style."""

from PyQt5.QtCore import QCoreApplication, QEvent, Qt, QTimer
from PyQt5.QtGui import QColor, QGuiApplication, QPalette
from PyQt5.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QSlider,
    QWidget,
)

from deepracer_teleop.camera import CameraView

RED = {"light": "#b3261e", "dark": "#ff8a80"}  # of text on a button
RECORDING = {"light": "#9a1c14", "dark": "#ff8a80"}  # of text on the window


def prepare_scaling():
    """Makes Qt follow the screen's scale; call it before the QApplication is constructed.

    From a scale of 1.75 on everything is doubled; below, only fonts grow, and widgets with them.
    """
    QCoreApplication.setAttribute(Qt.AA_EnableHighDpiScaling)
    QCoreApplication.setAttribute(Qt.AA_UseHighDpiPixmaps)
    QGuiApplication.setHighDpiScaleFactorRoundingPolicy(
        Qt.HighDpiScaleFactorRoundingPolicy.RoundPreferFloor
    )


def shade(palette):
    """Returns "dark" if a QPalette's windows are darker than their text, else "light"."""
    window, text = (palette.color(role) for role in (QPalette.Window, QPalette.WindowText))
    return "dark" if window.lightness() < text.lightness() else "light"


def outlined(name):
    """Returns a QPalette for slider and checkbox: Fusion's ticks and outlines are too dark."""
    palette = QPalette()
    if name == "dark":
        palette.setColor(QPalette.Window, QColor("#a0a0a0"))
    return palette


class Mover:
    """Publishes commands, stops timed moves and repeats a moving car's command.

    It never blocks: a timer has to call tick() while `active` is true.

    Args:
        publish: Function (linear, angular), called for each command.
        clock: Function that returns the ROS time [s].
        repeat_rate: Repetitions of a moving command [Hz].
    """

    def __init__(self, publish, clock, repeat_rate=10.0):
        self._publish = publish
        self._clock = clock
        self._period = 1.0 / repeat_rate
        self._since = 0.0  # start of the running move [s]
        self._duration = None  # of the running timed move [s]; None: no timed move
        self._sent = 0.0  # when the command was sent last [s]
        self.command = (0.0, 0.0)

    @property
    def active(self):
        """Whether tick() is needed: a timed move runs or the commanded speed is not 0."""
        return self._duration is not None or self.command[0] != 0.0

    def move(self, linear, angular, duration):
        """Commands for a time, then zero.

        Args:
            linear, angular: linear.x and angular.z of the command.
            duration: ROS time [s] after which zero is sent.
        """
        self._since, self._duration = self._clock(), duration
        self._send(linear, angular)

    def hold(self, linear, angular):
        """Commands until the next command; a running timed move is stopped."""
        self._duration = None
        self._send(linear, angular)

    def stop(self):
        """Commands zero once, immediately, and nothing after it."""
        self.hold(0.0, 0.0)

    def tick(self):
        """Stops a timed move after its duration, and repeats the command when that is due.

        A clock that jumps backwards (the simulation was reset) stops a timed move, too.
        """
        if not self.active:
            return
        now = self._clock()
        if self._duration is not None and not 0.0 <= now - self._since < self._duration - 1e-9:
            self.stop()
        elif not 0.0 <= now - self._sent < self._period - 1e-9:
            self._send(*self.command)

    def _send(self, linear, angular):
        self.command = (linear, angular)
        self._sent = self._clock()
        self._publish(linear, angular)


TITLE = "Teleop Interface"
DISPLAY_WIDTH, DISPLAY_HEIGHT = 640, 480  # of the camera [px]; shown at half size
# name, row, column, hint
BUTTONS = (
    ("Forward", 0, 1, "forward for {0.linear_wait:g} s; hold ↑ or W to drive on"),
    ("Left", 1, 0, "turn left for {0.turn_wait:g} s; hold ← or A to steer"),
    ("Stop", 1, 1, "stop immediately; Space, too"),
    ("Right", 1, 2, "turn right for {0.turn_wait:g} s; hold → or D to steer"),
    ("Backwards", 2, 1, "backwards for {0.linear_wait:g} s; hold ↓ or S to drive on"),
)


class Layout(QWidget):
    """A window of six buttons, a checkbox, a slider, the camera and four labels.

    Attributes:
        buttons: Name -> QPushButton.
        cruise: The QCheckBox of cruise control.
        slider: The steering QSlider.
        cameraLabel: CameraView.
        commandLabel: Read-out of the command.
        troubleLabel: Line for errors, hidden.
        recordButton: The checkable QPushButton that records.
        recordLabel: Line about the recording, hidden.
        statusLabel: Line about the simulation.
    """

    def __init__(self, settings):
        super().__init__()
        self.settings = settings
        self._shade = ""  # "light" or "dark"
        self.setWindowTitle(TITLE)
        self.setFocusPolicy(Qt.ClickFocus)  # a click next to the slider returns the keys to the car
        self.grid = QGridLayout(self)
        self.grid.setContentsMargins(14, 14, 14, 14)
        self.grid.setSpacing(10)

    def addButtons(self):
        """Adds the five buttons and the cruise checkbox."""
        self.buttons = {}
        for name, row, column, hint in BUTTONS:
            button = QPushButton(name, self)
            button.setMinimumSize(96, 34)
            button.setToolTip(hint.format(self.settings))
            self.grid.addWidget(button, row, column)
            self.buttons[name] = button
        self.cruise = QCheckBox("Cruise Control", self)
        self.cruise.setToolTip("keep driving; steer with the slider")
        self.grid.addWidget(self.cruise, 1, 3)

    def addSliders(self):
        """Adds the steering slider."""
        limit = int(self.settings.slider_limit)
        self.slider = QSlider(Qt.Horizontal, self)
        self.slider.setRange(-limit, limit)
        self.slider.setValue(0)
        self.slider.setTickPosition(QSlider.TicksBelow)
        self.slider.setTickInterval(1)
        self.slider.setMinimumWidth(210)
        self.slider.setToolTip("steering, right is positive")
        self.grid.addWidget(self.slider, 2, 3)

    def addImages(self):
        """Adds the camera, the command's read-out next to it and the line for errors below."""
        self.cameraLabel = CameraView(DISPLAY_WIDTH // 2, DISPLAY_HEIGHT // 2, self)
        self.grid.addWidget(self.cameraLabel, 3, 1, 1, 3)
        self.commandLabel = QLabel(self)
        self.commandLabel.setAlignment(Qt.AlignTop | Qt.AlignLeft)
        self.grid.addWidget(self.commandLabel, 3, 0)
        self.troubleLabel = QLabel(self)
        self.troubleLabel.setObjectName("trouble")
        self.troubleLabel.setWordWrap(True)
        self.troubleLabel.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Minimum)
        self.troubleLabel.setStyleSheet(
            "#trouble { background: #b3261e; color: white; padding: 8px; border-radius: 6px; }"
        )
        self.troubleLabel.hide()
        self.grid.addWidget(self.troubleLabel, 4, 0, 1, 4)
        self.grid.setRowStretch(3, 1)
        self.grid.setColumnStretch(3, 1)

    def addLines(self):
        """Adds the record button, and the lines about recording and simulation at the bottom."""
        self.recordButton = QPushButton("Record", self)
        self.recordButton.setCheckable(True)
        self.recordButton.setMinimumSize(96, 34)
        self.recordButton.setToolTip(f"bag and film into {self.settings.record_dir}")
        self.grid.addWidget(self.recordButton, 0, 3, Qt.AlignRight)
        self.recordLabel, self.statusLabel = QLabel(self), QLabel(self)
        for row, label in enumerate((self.recordLabel, self.statusLabel), start=5):
            label.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Minimum)
            label.setTextInteractionFlags(Qt.TextSelectableByMouse)
            self.grid.addWidget(label, row, 0, 1, 4)
            font = label.font()
            font.setPointSizeF(0.85 * font.pointSizeF())
            label.setFont(font)
        self.recordLabel.setWordWrap(True)
        self.recordLabel.hide()
        self.applyColors()

    def applyColors(self):
        """Sets text colors that are readable on the current palette, light or dark."""
        name = shade(self.palette())
        if name != self._shade:
            self._shade = name
            self.buttons["Stop"].setStyleSheet(
                f"QPushButton {{ color: {RED[name]}; font-weight: bold; }}"
            )
            self.recordLabel.setStyleSheet(f"color: {RECORDING[name]};")
            for widget in (self.slider, self.cruise):
                widget.setPalette(outlined(name))

    def changeEvent(self, event):
        """Follows a change of the palette."""
        super().changeEvent(event)
        if event.type() == QEvent.PaletteChange and self._shade:
            self.applyColors()

    def every(self, period, handler, timer_type=Qt.CoarseTimer) -> QTimer:
        """Calls a handler periodically.

        Args:
            period: Wall time [ms].
        """
        timer = QTimer(self)
        timer.setTimerType(timer_type)
        timer.timeout.connect(handler)
        timer.start(period)
        return timer

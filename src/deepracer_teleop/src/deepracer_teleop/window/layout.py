"""The widgets of the teleop window and their places; InterfaceWindow connects them."""

from PyQt5.QtCore import Qt, QTimer
from PyQt5.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QSlider,
    QWidget,
)

from deepracer_teleop.window.camera_view import CameraView

TITLE = "Teleop Interface"
DISPLAY_WIDTH, DISPLAY_HEIGHT = 640, 480  # of the camera [px]; shown at half size
# name, row, column, hint
BUTTONS = (
    ("Forward", 0, 1, "forward for {0.linear_wait:g} s"),
    ("Left", 1, 0, "turn left for {0.turn_wait:g} s"),
    ("Stop", 1, 1, "stop at once"),
    ("Right", 1, 2, "turn right for {0.turn_wait:g} s"),
    ("Backwards", 2, 1, "backwards for {0.linear_wait:g} s"),
)


class Layout(QWidget):
    """A window of five buttons, a checkbox, a slider, the camera and two labels.

    Attributes:
        settings: Settings.
        buttons: Name -> QPushButton.
        cruise: The QCheckBox of cruise control.
        slider: The steering QSlider.
        cameraLabel: CameraView.
        commandLabel: Read-out of the command.
        troubleLabel: Line for trouble, hidden.
    """

    def __init__(self, settings):
        """Makes an empty grid.

        Args:
            settings: Settings.
        """
        super().__init__()
        self.settings = settings
        self.setWindowTitle(TITLE)
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
        self.buttons["Stop"].setStyleSheet("QPushButton { color: #b3261e; font-weight: bold; }")
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
        """Adds the camera, the command's read-out beside it and the line for trouble below."""
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

    def every(self, period, handler, kind=Qt.CoarseTimer):
        """Calls a handler periodically.

        Args:
            period: Wall time [ms].
            handler: Function without arguments.
            kind: Qt.TimerType.

        Returns:
            QTimer.
        """
        timer = QTimer(self)
        timer.setTimerType(kind)
        timer.timeout.connect(handler)
        timer.start(period)
        return timer

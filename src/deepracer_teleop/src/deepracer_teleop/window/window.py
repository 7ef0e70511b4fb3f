"""The teleop window: buttons, a slider and the camera; it commands /cmd_vel.

Widgets change only in Qt's thread: the camera's subscriber stores the latest frame and sends a Qt
signal. Handlers never block: timed moves are stopped by a timer that checks the ROS time.
The camelCase names are public interface.
"""

import sys

import rospy
from deepracer_control.topics import COMMANDED_DATA_TOPIC
from geometry_msgs.msg import Twist
from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QApplication

from deepracer_teleop.camera import CameraFeed, to_pixmap
from deepracer_teleop.input_devices import InputDevices
from deepracer_teleop.recording import RecordButton
from deepracer_teleop.window.layout import Layout, Mover, prepare_scaling
from deepracer_teleop.window.settings import Settings
from deepracer_teleop.window.status import Status, master_problem

TICK_MS = 5  # period of the timer that stops timed moves [ms]
HEALTH_MS = 250  # period of the checks of camera and master [ms]

movementPublisher = None  # rospy.Publisher of COMMANDED_DATA_TOPIC
directionalSlider = None  # the QSlider
sliderControl = False  # whether cruise control is on
_settings = Settings()


def _publish(linear, angular):
    """Publishes one command; does nothing before the publisher exists."""
    if movementPublisher is None:
        return
    message = Twist()
    message.linear.x, message.angular.z = float(linear), float(angular)
    try:
        movementPublisher.publish(message)
    except rospy.ROSException as error:
        print(f"teleop: command not sent: {error}", file=sys.stderr)


def _new_mover():
    return Mover(_publish, lambda: rospy.get_time(), _settings.repeat_rate)


_mover = _new_mover()


def fwdFunct():
    """Drives forward for linear_wait."""
    _mover.move(_settings.default_speed, 0.0, _settings.linear_wait)


def bwdFunct():
    """Drives backwards for linear_wait."""
    _mover.move(-_settings.default_speed, 0.0, _settings.linear_wait)


def leftFunct():
    """Drives a left turn for turn_wait."""
    _turn(-1.0)


def rightFunct():
    """Drives a right turn for turn_wait."""
    _turn(1.0)


def _turn(side):
    angular = side * _settings.angular_sign * _settings.default_angular_speed
    _mover.move(_settings.default_speed, angular, _settings.turn_wait)


def stopFunct():
    """Stops immediately, also during a timed move."""
    _mover.stop()


def ccFunct(butt):
    """Switches cruise control according to a QCheckBox; takes effect immediately."""
    global sliderControl
    sliderControl = butt.isChecked()
    _follow_slider(0 if directionalSlider is None else directionalSlider.value())


def _follow_slider(value):
    _mover.hold(
        _settings.default_speed if sliderControl else 0.0, _settings.slider_to_angular(value)
    )


def _drive_by_input(speed, steering):
    """Drives by held keys or the gamepad.

    Args:
        speed: -1..1 of default_speed; 0: by cruise control.
        steering: -1..1, right is positive; 0: by the slider under cruise control.
    """
    if not (speed or steering):
        if sliderControl:
            _follow_slider(directionalSlider.value())
        else:
            _mover.stop()
        return
    linear, angular = speed * _settings.default_speed, 0.0
    if sliderControl:
        linear = linear or _settings.default_speed
        angular = _settings.slider_to_angular(directionalSlider.value())
    if steering:
        max_angular = _settings.key_steering * _settings.default_angular_speed
        angular = steering * _settings.angular_sign * max_angular
    _mover.hold(linear, angular)


def convertCVtoQT(window, cv_img):
    """Returns a QPixmap for the window's camera label from an image (H, W, 3) uint8 BGR."""
    return to_pixmap(cv_img, *window.cameraLabel.available_size())


class InterfaceWindow(Layout):
    """The teleop window.

    Args:
        settings: Settings; by default the original's values.
        monitor: MasterMonitor by run_id, or None.
        geometry: WindowGeometry that stores position and size, or None.
    """

    closeRequested = pyqtSignal()  # from rospy's shutdown to Qt's

    def __init__(self, settings=None, monitor=None, geometry=None):
        global _settings, _mover, sliderControl
        if QApplication.instance() is None:
            prepare_scaling()
        self.app = QApplication.instance() or QApplication(sys.argv[:1])
        self.app.setStyle("Fusion")
        _settings = settings or Settings()
        _mover = _new_mover()
        sliderControl = False
        super().__init__(_settings)
        self.exitCode = 0
        self._monitor, self._geometry = monitor, geometry
        self._finished = False
        self.addButtons()
        self.addSliders()
        self.addImages()
        self.addLines()
        self._camera = CameraFeed(self.cameraLabel, self.settings.camera_timeout)
        self.closeRequested.connect(self.close)
        self._ticker = self.every(TICK_MS, self._tick, Qt.PreciseTimer)
        self._health = self.every(HEALTH_MS, self._check_health)
        if geometry is not None:
            geometry.restore(self)
        self._tick()
        self._check_health()

    def addButtons(self):
        """Adds the five buttons and the cruise checkbox."""
        super().addButtons()
        handlers = {  # evaluated when clicked
            "Forward": lambda: fwdFunct(),
            "Left": lambda: leftFunct(),
            "Stop": lambda: stopFunct(),
            "Right": lambda: rightFunct(),
            "Backwards": lambda: bwdFunct(),
        }
        for name, handler in handlers.items():
            self.buttons[name].clicked.connect(handler)
        self.cruise.toggled.connect(lambda: ccFunct(self.cruise))

    def addLines(self):
        """Adds the record button and the lines at the bottom; connects keys and gamepad."""
        super().addLines()
        self._record = RecordButton(self.recordButton, self.recordLabel, self.settings.record_dir)
        self._status = Status()
        self._inputs = InputDevices(self)
        self._inputs.moved.connect(_drive_by_input)
        self._inputs.stopped.connect(lambda: stopFunct())
        self.buttons["Stop"].clicked.connect(self._inputs.clear)

    def addSliders(self):
        """Adds the steering slider."""
        global directionalSlider
        super().addSliders()
        directionalSlider = self.slider
        directionalSlider.valueChanged.connect(self.treatValue)

    def treatValue(self, value):
        """Follows the slider's value; right is positive."""
        _follow_slider(value)

    def start(self):
        """Shows the window and connects it to ROS; returns immediately."""
        global movementPublisher
        if movementPublisher is None:
            movementPublisher = rospy.Publisher(COMMANDED_DATA_TOPIC, Twist, queue_size=10)
        self._camera.start()
        self._status.start()
        self._inputs.pad.start()
        if self._monitor is not None:
            self._monitor.start()
        rospy.on_shutdown(self._on_ros_shutdown)
        self.show()
        self.setFocus()

    def executeInterface(self):
        """Runs the window until it is closed.

        Returns:
            Exit code: 0, or 1 if the ROS master was unavailable.
        """
        self.start()
        self.app.exec_()
        self.finish()
        return self.exitCode

    def isMoving(self):
        """Returns whether a timed move runs or the commanded speed is not 0."""
        return _mover.active

    def publisher(self):
        """Returns the rospy.Publisher of the commands, or None before start()."""
        return movementPublisher

    def lastPicture(self):
        """Returns the newest camera frame as received, (H, W, 3) uint8 BGR, or None."""
        return self._camera.image

    def pictureTime(self):
        """Returns the ROS time [s] at which the newest camera frame was shown, or None."""
        return self._camera.time

    def imageCb(self, message):
        """Stores a camera frame; runs in the subscriber's thread, so it does not change widgets."""
        self._camera.callback(message)

    def closeEvent(self, event):
        """Stops the car when the window closes."""
        self.finish()
        if self._geometry is not None:
            self.setEnabled(False)  # saving processes events: none of the user's may drive the car
            self._geometry.save(self)
        super().closeEvent(event)

    def finish(self):
        """Publishes one zero command and stops timers and threads; a second call does nothing."""
        if self._finished:
            return
        self._finished = True
        self._ticker.stop()
        self._health.stop()
        if self._monitor is not None:
            self._monitor.close()
        self._camera.stop()
        self._status.stop()
        self._inputs.pad.stop()
        _mover.stop()
        self._record.finish()

    def _on_ros_shutdown(self):
        """Stops the car while topics are still open; called by rospy in some thread."""
        if self._finished:
            return
        _publish(0.0, 0.0)
        try:
            self.closeRequested.emit()
        except RuntimeError:  # the Qt object is deleted already
            pass

    def _tick(self):
        _mover.tick()
        linear, angular = _mover.command
        text = f"Command\nlinear {linear:+.2f}\nangular {angular:+.2f}"
        if text != self.commandLabel.text():
            self.commandLabel.setText(text)

    def _check_health(self):
        self._camera.check()
        self._inputs.pad.check()
        text = self._status.text() + (" · pad" if self._inputs.pad.present else "")
        if text != self.statusLabel.text():
            self.statusLabel.setText(text)
        self._record.check()
        problem = ""
        if self._monitor is not None:
            problem = master_problem(self._monitor, self.settings.master_timeout)
        if bool(problem) != bool(self.exitCode):
            print(f"teleop: {problem or 'the ROS master responds again'}", file=sys.stderr)
        self.exitCode = 1 if problem else 0
        self.troubleLabel.setText(problem)
        self.troubleLabel.setVisible(bool(problem))

"""The teleop window: buttons, a slider and the camera; it commands /cmd_vel.

Widgets change only in Qt's thread: the camera's subscriber stores the latest frame and sends a Qt
signal. Handlers never block: timed moves are ended by a timer that checks the ROS time.
The camelCase names are public interface.
"""

import sys

import rospy
from deepracer_control.topics import COMMANDED_DATA_TOPIC
from geometry_msgs.msg import Twist
from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QApplication

from deepracer_teleop.camera import CameraFeed, to_pixmap
from deepracer_teleop.hand import Hand
from deepracer_teleop.recording import RecordButton
from deepracer_teleop.window.layout import Layout, Mover, prepare_scaling
from deepracer_teleop.window.settings import Settings
from deepracer_teleop.window.status import Status, master_problem

TICK_MS = 5  # period of the timer that ends timed moves [ms]
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
    """Drives forward for a while."""
    _mover.move(_settings.default_speed, 0.0, _settings.linear_wait)


def bwdFunct():
    """Drives backwards for a while."""
    _mover.move(-_settings.default_speed, 0.0, _settings.linear_wait)


def leftFunct():
    """Turns left, driving, for a while."""
    _turn(-1.0)


def rightFunct():
    """Turns right, driving, for a while."""
    _turn(1.0)


def _turn(side):
    angular = side * _settings.angular_sign * _settings.default_angular_speed
    _mover.move(_settings.default_speed, angular, _settings.turn_wait)


def stopFunct():
    """Stops at once, also during a timed move."""
    _mover.stop()


def ccFunct(butt):
    """Switches cruise control as the checkbox says; takes effect at once.

    Args:
        butt: The QCheckBox.
    """
    global sliderControl
    sliderControl = butt.isChecked()
    _follow_slider(0 if directionalSlider is None else directionalSlider.value())


def _follow_slider(value):
    _mover.hold(
        _settings.default_speed if sliderControl else 0.0, _settings.slider_to_angular(value)
    )


def _drive_by_hand(speed, steering):
    """Drives as held keys or the pad say.

    Args:
        speed: -1..1 of default_speed; 0: as cruise control says.
        steering: -1..1, right is positive; 0: as the slider says under cruise control.
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
        most = _settings.key_steering * _settings.default_angular_speed
        angular = steering * _settings.angular_sign * most
    _mover.hold(linear, angular)


def convertCVtoQT(window, cv_img):
    """Returns a QPixmap for the window's camera label of a picture (H, W, 3) uint8 BGR."""
    return to_pixmap(cv_img, *window.cameraLabel.room())


class InterfaceWindow(Layout):
    """The teleop window."""

    closeAsked = pyqtSignal()  # from rospy's shutdown to Qt's

    def __init__(self, settings=None, monitor=None, memory=None):
        """Builds the widgets; executeInterface() runs them.

        Args:
            settings: Settings; by default the original's values.
            monitor: MasterMonitor by run_id, or None.
            memory: Memory of place and size, or None.
        """
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
        self._monitor, self._memory = monitor, memory
        self._finished = False
        self.addButtons()
        self.addSliders()
        self.addImages()
        self.addLines()
        self._camera = CameraFeed(self.cameraLabel, self.settings.camera_timeout)
        self.closeAsked.connect(self.close)
        self._ticker = self.every(TICK_MS, self._tick, Qt.PreciseTimer)
        self._health = self.every(HEALTH_MS, self._check_health)
        if memory is not None:
            memory.restore(self)
        self._tick()
        self._check_health()

    def addButtons(self):
        """Adds the five buttons and the cruise checkbox."""
        super().addButtons()
        handlers = {  # looked up when clicked
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
        """Adds the record button and the lines at the bottom; takes keys and pad."""
        super().addLines()
        self._record = RecordButton(self.recordButton, self.recordLabel, self.settings.record_dir)
        self._status = Status()
        self._hand = Hand(self)
        self._hand.moved.connect(_drive_by_hand)
        self._hand.stopped.connect(lambda: stopFunct())
        self.buttons["Stop"].clicked.connect(self._hand.clear)

    def addSliders(self):
        """Adds the steering slider."""
        global directionalSlider
        super().addSliders()
        directionalSlider = self.slider
        directionalSlider.valueChanged.connect(self.treatValue)

    def treatValue(self, value):
        """Follows the slider.

        Args:
            value: The slider's value, right is positive.
        """
        _follow_slider(value)

    def start(self):
        """Shows the window and connects it to ROS; returns at once."""
        global movementPublisher
        if movementPublisher is None:
            movementPublisher = rospy.Publisher(COMMANDED_DATA_TOPIC, Twist, queue_size=10)
        self._camera.start()
        self._status.start()
        self._hand.pad.start()
        if self._monitor is not None:
            self._monitor.start()
        rospy.on_shutdown(self._on_ros_shutdown)
        self.show()
        self.setFocus()

    def executeInterface(self):
        """Runs the window until it is closed.

        Returns:
            Exit code: 0, or 1 if the ROS master was lost.
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
        """Returns the newest camera frame as it came, (H, W, 3) uint8 BGR, or None."""
        return self._camera.picture

    def pictureTime(self):
        """Returns the ROS time [s] at which the newest camera frame was shown, or None."""
        return self._camera.time

    def imageCb(self, message):
        """Stores a camera frame; runs in the subscriber's thread, so it changes no widget."""
        self._camera.callback(message)

    def closeEvent(self, event):
        """Stops the car when the window closes."""
        if self._memory is not None:
            self._memory.keep(self)
        self.finish()
        super().closeEvent(event)

    def finish(self):
        """Publishes one zero and ends timers and threads; a second call does nothing."""
        if self._finished:
            return
        self._finished = True
        self._ticker.stop()
        self._health.stop()
        if self._monitor is not None:
            self._monitor.close()
        self._camera.stop()
        self._status.stop()
        self._hand.pad.stop()
        _mover.stop()
        self._record.finish()

    def _on_ros_shutdown(self):
        """Stops the car while topics are still open; called by rospy in some thread."""
        if self._finished:
            return
        _publish(0.0, 0.0)
        try:
            self.closeAsked.emit()
        except RuntimeError:  # the Qt object is deleted already
            pass

    def _tick(self):
        _mover.tick()
        linear, angular = _mover.command
        words = f"Command\nlinear {linear:+.2f}\nangular {angular:+.2f}"
        if words != self.commandLabel.text():
            self.commandLabel.setText(words)

    def _check_health(self):
        self._camera.check()
        self._hand.pad.check()
        words = self._status.words() + (" · pad" if self._hand.pad.present else "")
        if words != self.statusLabel.text():
            self.statusLabel.setText(words)
        self._record.check()
        problem = ""
        if self._monitor is not None:
            problem = master_problem(self._monitor, self.settings.master_timeout)
        if bool(problem) != bool(self.exitCode):
            print(f"teleop: {problem or 'the ROS master answers again'}", file=sys.stderr)
        self.exitCode = 1 if problem else 0
        self.troubleLabel.setText(problem)
        self.troubleLabel.setVisible(bool(problem))

"""The node `teleop`: a window with buttons, a slider and the camera that commands /cmd_vel.

Widgets change only in Qt's thread: the camera's subscriber stores the latest frame and sends a Qt
signal. Handlers never block: timed moves are ended by a timer that checks the ROS time.
The camelCase names are public interface.
"""

import signal
import sys
import time

import cv2
import rosgraph
import rospy
from cv_bridge import CvBridge, CvBridgeError
from deepracer_control.topics import CAMERA_TOPIC, COMMANDED_DATA_TOPIC
from geometry_msgs.msg import Twist
from paddock_common.settings import read
from PyQt5.QtCore import Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QImage, QPixmap
from PyQt5.QtWidgets import (
    QApplication,
    QCheckBox,
    QGridLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QSlider,
    QWidget,
)
from sensor_msgs.msg import Image

from deepracer_teleop.window.camera_view import CameraView, FrameRate, LatestValue, draw_frame_rate
from deepracer_teleop.window.master_watch import MasterWatch, run_id
from deepracer_teleop.window.mover import Mover
from deepracer_teleop.window.settings import Settings

TITLE = "Teleop Interface"
DISPLAY_WIDTH, DISPLAY_HEIGHT = 640, 480  # of the camera [px]; shown at half size
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
    _mover.move(
        _settings.default_speed,
        -_settings.angular_sign * _settings.default_angular_speed,
        _settings.turn_wait,
    )


def rightFunct():
    """Turns right, driving, for a while."""
    _mover.move(
        _settings.default_speed,
        _settings.angular_sign * _settings.default_angular_speed,
        _settings.turn_wait,
    )


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


def convertCVtoQT(window, cv_img):
    """Turns an OpenCV picture into one for the window's camera label.

    Args:
        window: The InterfaceWindow.
        cv_img: (H, W, 3) uint8 BGR.

    Returns:
        QPixmap, as large as fits the label, aspect kept.
    """
    rgb = cv2.cvtColor(cv_img, cv2.COLOR_BGR2RGB)
    height, width, channels = rgb.shape
    image = QImage(rgb.data, width, height, channels * width, QImage.Format_RGB888)
    return QPixmap.fromImage(
        image.scaled(
            window.cameraLabel.contentsRect().size(), Qt.KeepAspectRatio, Qt.SmoothTransformation
        )
    )


class InterfaceWindow(QWidget):
    """The teleop window."""

    frameArrived = pyqtSignal()  # from the subscriber's thread to Qt's
    closeAsked = pyqtSignal()  # from rospy's shutdown to Qt's

    def __init__(self, settings=None, watch=None):
        """Builds the widgets; executeInterface() runs them.

        Args:
            settings: Settings; by default the original's values.
            watch: MasterWatch or None.
        """
        global _settings, _mover, sliderControl
        self.app = QApplication.instance() or QApplication(sys.argv[:1])
        self.app.setStyle("Fusion")
        super().__init__()
        _settings = settings or Settings()
        _mover = _new_mover()
        sliderControl = False
        self.settings = _settings
        self.exitCode = 0
        self._watch = watch
        self._finished = False
        self._subscriber = None
        self._bridge = CvBridge()
        self._latest_frame = LatestValue()
        self._frame_rate = FrameRate()
        self._picture = None  # newest camera frame as it came, (H, W, 3) uint8 BGR
        self._last_frame = None  # (wall time, ROS time, words) of the newest picture
        self._started = time.monotonic()
        self.setWindowTitle(TITLE)
        self.grid = QGridLayout(self)
        self.grid.setContentsMargins(14, 14, 14, 14)
        self.grid.setSpacing(10)
        self.addButtons()
        self.addSliders()
        self.addImages()
        self.frameArrived.connect(self._show_frame, Qt.QueuedConnection)
        self.closeAsked.connect(self.close)
        self._ticker = self._timer(TICK_MS, self._tick, Qt.PreciseTimer)
        self._health = self._timer(HEALTH_MS, self._check_health, Qt.CoarseTimer)
        self._tick()
        self._check_health()

    def addButtons(self):
        """Adds the five buttons and the cruise checkbox."""
        # name, row, column, handler, hint; the handler is looked up when clicked
        table = (
            ("Forward", 0, 1, lambda: fwdFunct(), "forward for {0.linear_wait:g} s"),
            ("Left", 1, 0, lambda: leftFunct(), "turn left for {0.turn_wait:g} s"),
            ("Stop", 1, 1, lambda: stopFunct(), "stop at once"),
            ("Right", 1, 2, lambda: rightFunct(), "turn right for {0.turn_wait:g} s"),
            ("Backwards", 2, 1, lambda: bwdFunct(), "backwards for {0.linear_wait:g} s"),
        )
        self.buttons = {}
        for name, row, column, handler, hint in table:
            button = QPushButton(name, self)
            button.setMinimumSize(96, 34)
            button.setToolTip(hint.format(self.settings))
            button.clicked.connect(handler)
            self.grid.addWidget(button, row, column)
            self.buttons[name] = button
        self.buttons["Stop"].setStyleSheet("QPushButton { color: #b3261e; font-weight: bold; }")
        self.cruise = QCheckBox("Cruise Control", self)
        self.cruise.setToolTip("keep driving; steer with the slider")
        self.cruise.toggled.connect(lambda: ccFunct(self.cruise))
        self.grid.addWidget(self.cruise, 1, 3)

    def addSliders(self):
        """Adds the steering slider."""
        global directionalSlider
        limit = int(self.settings.slider_limit)
        directionalSlider = QSlider(Qt.Horizontal, self)
        directionalSlider.setRange(-limit, limit)
        directionalSlider.setValue(0)
        directionalSlider.setTickPosition(QSlider.TicksBelow)
        directionalSlider.setTickInterval(1)
        directionalSlider.setMinimumWidth(210)
        directionalSlider.setToolTip("steering, right is positive")
        directionalSlider.valueChanged.connect(self.treatValue)
        self.slider = directionalSlider
        self.grid.addWidget(self.slider, 2, 3)

    def addImages(self):
        """Adds the camera, the command's read-out next to it and the error line below."""
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
        self._started = time.monotonic()
        self._subscriber = rospy.Subscriber(
            CAMERA_TOPIC, Image, self.imageCb, queue_size=1, buff_size=2**24
        )
        if self._watch is not None:
            self._watch.start()
        rospy.on_shutdown(self._on_ros_shutdown)
        self.show()

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
        return self._picture

    def pictureTime(self):
        """Returns the ROS time [s] at which the newest camera frame was shown, or None."""
        return None if self._last_frame is None else self._last_frame[1]

    def imageCb(self, message):
        """Stores a camera frame; runs in the subscriber's thread, so it changes no widget."""
        if self._latest_frame.put(message):
            self.frameArrived.emit()

    def closeEvent(self, event):
        """Stops the car when the window closes."""
        self.finish()
        super().closeEvent(event)

    def finish(self):
        """Publishes one zero and ends timers and threads; a second call does nothing."""
        if self._finished:
            return
        self._finished = True
        self._ticker.stop()
        self._health.stop()
        if self._watch is not None:
            self._watch.stop()
        if self._subscriber is not None:
            self._subscriber.unregister()
        _mover.stop()

    def _on_ros_shutdown(self):
        """Stops the car while topics are still open; called by rospy in some thread."""
        if self._finished:
            return
        _publish(0.0, 0.0)
        try:
            self.closeAsked.emit()
        except RuntimeError:  # the Qt object is deleted already
            pass

    def _timer(self, period, handler, kind):
        timer = QTimer(self)
        timer.setTimerType(kind)
        timer.timeout.connect(handler)
        timer.start(period)
        return timer

    def _tick(self):
        _mover.tick()
        linear, angular = _mover.command
        words = f"Command\nlinear {linear:+.2f}\nangular {angular:+.2f}"
        if words != self.commandLabel.text():
            self.commandLabel.setText(words)

    def _show_frame(self):
        message = self._latest_frame.take()
        if message is None or self._finished:
            return
        now = rospy.get_time()
        self._last_frame = (time.monotonic(), now, f"{now:.1f} s ({time.strftime('%H:%M:%S')})")
        rate = self._frame_rate.update(message.header.stamp.to_sec() or now)
        try:
            self._picture = self._bridge.imgmsg_to_cv2(message, "bgr8")
            shown = draw_frame_rate(self._picture.copy(), rate)
            self.cameraLabel.show_picture(convertCVtoQT(self, shown))
        except (CvBridgeError, cv2.error, ValueError, TypeError) as error:
            self.cameraLabel.show_message(
                f"A picture on {CAMERA_TOPIC} cannot be shown (encoding {message.encoding!r}, "
                f"{message.width}x{message.height}): {error}"
            )

    def _check_health(self):
        now = time.monotonic()
        if self._last_frame is None:
            if now - self._started > self.settings.camera_timeout:
                self.cameraLabel.show_message(
                    f"No camera: nothing has come on {CAMERA_TOPIC}.\n"
                    "Does the simulator (or the car) run?"
                )
            else:
                self.cameraLabel.show_message(f"Waiting for {CAMERA_TOPIC} ...")
        elif now - self._last_frame[0] > self.settings.camera_timeout:
            paused = abs(rospy.get_time() - self._last_frame[1]) < 0.1
            self.cameraLabel.show_message(
                f"The camera has stopped: no picture since "
                f"{self._last_frame[2]}." + ("\nThe clock stands still, too." if paused else "")
            )
        problem = "" if self._watch is None else self._watch.problem(self.settings.master_timeout)
        if bool(problem) != bool(self.exitCode):
            print(f"teleop: {problem or 'the ROS master answers again'}", file=sys.stderr)
        self.exitCode = 1 if problem else 0
        self.troubleLabel.setText(problem)
        self.troubleLabel.setVisible(bool(problem))


def connect(name):
    """Starts the ROS node and builds the window with the node's private parameters.

    Args:
        name: The node's name.

    Returns:
        InterfaceWindow.

    Raises:
        ConnectionError: No ROS master answers.
        ValueError: A parameter is wrong; the message names it.
    """
    uri = rosgraph.get_master_uri()
    if run_id(uri, 5.0) is None:
        raise ConnectionError(
            f"no ROS master answers at {uri}; start roscore (or a launch file), "
            "or set ROS_MASTER_URI"
        )
    rospy.init_node(name, disable_signals=True)
    window = InterfaceWindow(read(Settings, rospy.get_param), MasterWatch(uri))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: window.close())
    return window


def main():
    """Runs the node `teleop`; returns its exit code."""
    try:
        window = connect("teleop")
    except (ConnectionError, ValueError) as error:
        print(f"teleop cannot start: {error}", file=sys.stderr)
        return 1
    code = window.executeInterface()
    time.sleep(0.1)  # rospy sends from a thread
    rospy.signal_shutdown("the window was closed")
    return code


if __name__ == "__main__":
    sys.exit(main())

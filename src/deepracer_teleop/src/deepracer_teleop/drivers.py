"""Drivers that use the real window: by buttons, by slider.

Drivers that operate the teleop window by mouse events, from the camera image in it alone.
`slider_driver` moves the steering slider with cruise control on; `buttons_driver` roams with the
five buttons.
"""

import math
import os
import sys

import rospy
from deepracer_control.ackermann import Geometry
from deepracer_control.control import DEGREES_PER_UNIT
from deepracer_control.drivers.commands import Units
from deepracer_control.drivers.line_vision import vision_from
from deepracer_control.drivers.pursuit import arc_curvature
from paddock_common.settings import Number, parameter
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt, QTimer
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QStyle
from sensor_msgs.msg import CameraInfo

from deepracer_teleop.window.node import connect, leave


class Mouse:
    """A mouse on one window.

    Args:
        window: InterfaceWindow, shown.
    """

    def __init__(self, window):
        self._window = window

    def click(self, name):
        """Clicks a button by its name."""
        QTest.mouseClick(self._window.buttons[name], Qt.LeftButton)

    def toggle_cruise(self):
        """Clicks the cruise checkbox."""
        box = self._window.cruise
        QTest.mouseClick(box, Qt.LeftButton, pos=QPoint(8, box.height() // 2))

    def slider_pixel(self, value):
        """Returns the pixel of the slider's handle for a value."""
        slider = self._window.slider
        handle = slider.style().pixelMetric(QStyle.PM_SliderLength, None, slider)
        span = slider.width() - handle
        x = QStyle.sliderPositionFromValue(slider.minimum(), slider.maximum(), round(value), span)
        return QPoint(x + handle // 2, slider.height() // 3)

    def grab_slider(self):
        """Presses the mouse on the slider's handle."""
        QTest.mousePress(
            self._window.slider, Qt.LeftButton, pos=self.slider_pixel(self._window.slider.value())
        )

    def pull_slider(self, value):
        """Moves the pressed mouse to a value's pixel."""
        slider, position = self._window.slider, QPointF(self.slider_pixel(value))
        QApplication.sendEvent(
            slider,
            QMouseEvent(
                QEvent.MouseMove,
                position,
                QPointF(slider.mapToGlobal(position.toPoint())),
                Qt.NoButton,
                Qt.LeftButton,
                Qt.NoModifier,
            ),
        )

    def release_slider(self):
        """Releases the slider."""
        QTest.mouseRelease(
            self._window.slider, Qt.LeftButton, pos=self.slider_pixel(self._window.slider.value())
        )

    def slider_value(self, curvature, geometry=Geometry()):
        """Returns the slider's value for a curvature [1/m, left positive]; right is positive.

        The car's control has to run in the original mode: steps of 15 degrees to the right.
        """
        angle = Units(geometry=geometry).steering(curvature)
        settings = self._window.settings
        value = -math.degrees(angle) / DEGREES_PER_UNIT * settings.slider_scale
        return max(-settings.slider_limit, min(settings.slider_limit, value))


PERIOD_MS = 20  # of the driver [ms]
LINE_TIMEOUT = 1.5  # ROS time without a line after which it stops [s]


class LineDetector:
    """Detects the line in the window's image."""

    def __init__(self, window):
        self._window = window
        self._vision = vision_from(rospy.get_param, lookahead=0.5)
        self._matrix, self._last = None, None
        rospy.Subscriber("camera_info", CameraInfo, self._on_camera_info, queue_size=1)

    def _on_camera_info(self, message):
        self._matrix = tuple(message.K)

    def ready(self):
        """Returns whether there is an image and its camera_info."""
        return self._matrix is not None and self._window.lastPicture() is not None

    def has_new_image(self):
        """Returns whether there is an image that was not processed yet."""
        return self.ready() and self._window.pictureTime() != self._last

    def find_goal(self):
        """Returns the goal point (x ahead, y left) [m] in the newest image, or None."""
        self._last = self._window.pictureTime()
        return self._vision.find_goal(self._window.lastPicture(), self._matrix)

    def restart(self):
        """Resets the detection after a reset of the simulation."""
        self._last = None
        self._vision.restart()


class SliderDriver:
    """Steers by the slider with cruise control on, at most five changes a second."""

    name = "slider_driver"

    def __init__(self, window):
        self._window, self._mouse, self._detector = window, Mouse(window), LineDetector(window)
        rate = Number(above=0.0, max=5.0, unit="1/s")  # as a human operator's
        self._rate = parameter(rospy.get_param, "changes_per_second", 5.0, rate)
        self._changed = self._detected = -math.inf
        self._driving = False

    def spin_once(self):
        """Moves the slider when the next change is due and the line requires it."""
        now = rospy.get_time()
        if now < max(self._changed, self._detected):  # the simulation was reset
            self._changed, self._detected = -math.inf, now
            self._detector.restart()
        if now - self._changed < 1.0 / self._rate:
            return
        goal = self._detector.find_goal() if self._detector.has_new_image() else None
        if goal is None:
            if self._driving and now - self._detected > LINE_TIMEOUT:
                print("slider_driver: no line detected, stop", file=sys.stderr)
                self.stop()
            return
        self._detected = now
        if not self._driving:
            self._mouse.toggle_cruise()
            self._mouse.grab_slider()
            self._driving = True
        value = round(self._mouse.slider_value(arc_curvature(*goal)))
        if value != self._window.slider.value():
            self._mouse.pull_slider(value)
            self._changed = now

    def stop(self):
        """Releases the slider, switches cruise control off, clicks Stop."""
        if self._driving:
            self._mouse.release_slider()
            self._mouse.toggle_cruise()
            self._mouse.click("Stop")
            self._driving = False


class ButtonsDriver:
    """Roams with the buttons: one click, then it waits until the move is finished."""

    name = "buttons_driver"

    def __init__(self, window):
        self._window, self._mouse, self._detector = window, Mouse(window), LineDetector(window)
        self._wide = math.radians(
            parameter(rospy.get_param, "wide_angle", 22.0, Number(unit="degrees"))
        )
        self._idle_until = 0.0

    def spin_once(self):
        """Clicks the button that leads towards the line, when the last move is finished."""
        now = rospy.get_time()
        if self._window.isMoving():
            self._idle_until = now + 0.3  # until the car has stopped and the image is new
            return
        if self._idle_until - 1.0 < now < self._idle_until or not self._detector.has_new_image():
            return
        goal = self._detector.find_goal()
        if goal is None:
            self._mouse.click("Backwards")
            return
        bearing = math.atan2(goal[1], goal[0])
        self._mouse.click(
            "Forward" if abs(bearing) < self._wide else "Left" if bearing > 0.0 else "Right"
        )

    def stop(self):
        """Clicks Stop."""
        self._mouse.click("Stop")


def run(driver_type):
    """Runs a driver's node until the window is closed; returns its exit code."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    try:
        window = connect(driver_type.name)
        driver = driver_type(window)
    except (ConnectionError, ValueError) as error:
        print(f"{driver_type.name} cannot start: {error}", file=sys.stderr)
        return 1
    timer = QTimer(window)
    timer.timeout.connect(driver.spin_once)
    timer.start(PERIOD_MS)
    code = window.executeInterface()
    timer.stop()
    driver.stop()
    leave(window)
    return code

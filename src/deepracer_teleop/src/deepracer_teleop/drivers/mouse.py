"""Operates the window's widgets with mouse events."""

import math

from deepracer_control.ackermann import Geometry
from deepracer_control.control import DEGREES_PER_UNIT
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QStyle


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
        slider, place = self._window.slider, QPointF(self.slider_pixel(value))
        QApplication.sendEvent(
            slider,
            QMouseEvent(
                QEvent.MouseMove,
                place,
                QPointF(slider.mapToGlobal(place.toPoint())),
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
        angle = math.atan(geometry.wheelbase * curvature)
        angle = max(-geometry.max_steering, min(geometry.max_steering, angle))
        settings = self._window.settings
        value = -math.degrees(angle) / DEGREES_PER_UNIT * settings.slider_scale
        return max(-settings.slider_limit, min(settings.slider_limit, value))

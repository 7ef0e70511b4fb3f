"""Qt without a screen, a fake publisher and a fake clock for the window's tests."""

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
import rospy
from deepracer_teleop.window import window as window_module
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication


class WindowFixture:
    """A window with a fake publisher and a clock set by the test [s]."""

    def __init__(self):
        self.now = 100.0
        self.sent = []

    def publish(self, message):
        self.sent.append((message.linear.x, message.angular.z))

    def build(self, **settings):
        self.window = window_module.InterfaceWindow(window_module.Settings(**settings))
        self.window.resize(self.window.sizeHint())
        self.window.show()
        self.window.setFocus()  # as start() does
        self.window._ticker.stop()  # the tests call it
        QApplication.processEvents()
        return self.window

    def click(self, name):
        QTest.mouseClick(self.window.buttons[name], Qt.LeftButton)

    def toggle_cruise(self):
        box = self.window.cruise
        QTest.mouseClick(box, Qt.LeftButton, pos=QPoint(8, box.height() // 2))

    def advance(self, seconds, step=0.01):
        """Advances the time in steps, as the window's timer does."""
        for _ in range(round(seconds / step)):
            self.now = round(self.now + step, 6)
            self.window._tick()

    def take(self):
        sent, self.sent = self.sent, []
        return sent

    def drag(self, slider, pixels, steps=10):
        """Drags the slider's handle (at 0, in the center) sideways."""
        start = QPoint(slider.width() // 2, slider.height() // 3)
        QTest.mousePress(slider, Qt.LeftButton, pos=start)
        for index in range(1, steps + 1):
            position = start + QPoint(round(pixels * index / steps), 0)
            QApplication.sendEvent(
                slider,
                QMouseEvent(
                    QEvent.MouseMove,
                    QPointF(position),
                    QPointF(slider.mapToGlobal(position)),
                    Qt.NoButton,
                    Qt.LeftButton,
                    Qt.NoModifier,
                ),
            )
        QTest.mouseRelease(slider, Qt.LeftButton, pos=start + QPoint(pixels, 0))


@pytest.fixture
def teleop(monkeypatch):
    teleop = WindowFixture()
    monkeypatch.setattr(rospy, "get_time", lambda: teleop.now)
    monkeypatch.setattr(window_module, "movementPublisher", teleop)
    yield teleop
    if hasattr(teleop, "window"):
        teleop.window.close()
        teleop.window.deleteLater()
        QApplication.processEvents()

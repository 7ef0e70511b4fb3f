"""Input devices of the window: keys and gamepad, combined to one source of commands."""

import math

import rospy
from deepracer_control.topics import PAD_TOPIC
from PyQt5.QtCore import QEvent, QObject, Qt, QTimer, pyqtSignal
from PyQt5.QtWidgets import QAbstractButton, QSlider, QWidget
from sensor_msgs.msg import Joy

from deepracer_teleop.camera import LatestValue

# key -> (speed, steering), right is positive
BINDINGS = {
    Qt.Key_Up: (1, 0),
    Qt.Key_W: (1, 0),
    Qt.Key_Down: (-1, 0),
    Qt.Key_S: (-1, 0),
    Qt.Key_Left: (0, -1),
    Qt.Key_A: (0, -1),
    Qt.Key_Right: (0, 1),
    Qt.Key_D: (0, 1),
}
ARROWS = (Qt.Key_Up, Qt.Key_Down, Qt.Key_Left, Qt.Key_Right)
STOP = Qt.Key_Space
CLICK = (Qt.Key_Return, Qt.Key_Enter)  # act on a focused button as Space does elsewhere
# X servers repeat a held key as pairs of release and press, which Qt cannot always distinguish.
RELEASE_MS = 30  # a key that is pressed again within this time was not released [ms]
OTHERS = Qt.ControlModifier | Qt.AltModifier | Qt.MetaModifier  # with these a key is a shortcut


class Keys(QObject):
    """Filters the key events of a window and its widgets.

    A slider that has the keyboard focus keeps its arrow keys; WASD drives even then.

    Args:
        window: QWidget with all its widgets.
    """

    moved = pyqtSignal(float, float)  # speed, steering: -1, 0 or 1; when they change
    stopped = pyqtSignal()

    def __init__(self, window):
        super().__init__(window)
        self._window, self._held, self._deflections = window, set(), (0, 0)
        self._releases = {}  # held key -> QTimer that completes its release
        for widget in (window, *window.findChildren(QWidget)):
            widget.installEventFilter(self)

    def clear(self):
        """Clears the held keys: each has to be pressed again. Emits nothing."""
        self._clear_held()
        self._deflections = (0, 0)

    def _clear_held(self):
        self._held.clear()
        for key in tuple(self._releases):
            self._cancel_release(key)

    def eventFilter(self, widget, event):
        """Handles the keys of the car; other events are passed to their widget."""
        event_type = event.type()
        if event_type in (QEvent.WindowDeactivate, QEvent.Hide):
            if widget is self._window and self._held:
                self._clear_held()
                self._update()
        elif event_type == QEvent.KeyPress:
            return self._press(widget, event)
        elif event_type == QEvent.KeyRelease:
            return self._release(event)
        return False

    def _press(self, widget, event):
        key = event.key()
        if event.modifiers() & OTHERS or (isinstance(widget, QSlider) and key in ARROWS):
            return False
        if key in BINDINGS:
            if key in self._releases:
                self._cancel_release(key)
            elif not event.isAutoRepeat():
                self._held.add(key)
                self._update()
        elif key == STOP:
            if not event.isAutoRepeat():
                self.clear()
                self.stopped.emit()
        elif key in CLICK and isinstance(widget, QAbstractButton):
            if not event.isAutoRepeat():
                widget.click()
        else:
            return False
        return True

    def _release(self, event):
        key = event.key()
        if key in self._held:
            if not event.isAutoRepeat() and key not in self._releases:
                timer = QTimer(self, singleShot=True, timerType=Qt.PreciseTimer)
                timer.timeout.connect(lambda: self._complete_release(key))
                timer.start(RELEASE_MS)
                self._releases[key] = timer
            return True
        return key == STOP  # else it clicks the focused button

    def _cancel_release(self, key):
        """Cancels the release of a key."""
        timer = self._releases.pop(key)
        timer.stop()
        timer.deleteLater()

    def _complete_release(self, key):
        """Completes a release: the key was not pressed again."""
        self._cancel_release(key)
        self._held.discard(key)
        self._update()

    def _update(self):
        # two keys of one direction count once
        directions = {BINDINGS[key] for key in self._held}
        deflections = tuple(sum(values) for values in zip((0, 0), *directions))
        if deflections != self._deflections:
            self._deflections = deflections
            self.moved.emit(*deflections)


STEERING_AXIS, SPEED_AXIS = 0, 1  # left and up are positive
DEAD_ZONE = 0.1  # fraction of the stick's range that counts as its center


def deflection(value):
    """Returns -1..1 from an axis, 0 in the dead zone; the rest of the range is scaled.

    A value that is not a finite number counts as 0.
    """
    if not math.isfinite(value):
        return 0.0
    size = max(0.0, min(1.0, abs(value)) - DEAD_ZONE) / (1.0 - DEAD_ZONE)
    return size if value > 0.0 else -size


class Pad(QObject):
    """Follows the gamepad, if there is one; start() subscribes.

    Attributes:
        present: Whether PAD_TOPIC has a publisher.
    """

    moved = pyqtSignal(float, float)  # speed, steering: -1..1, right is positive; on a change
    stopped = pyqtSignal()
    _arrived = pyqtSignal()  # from the subscriber's thread to Qt's

    def __init__(self, parent):
        super().__init__(parent)
        self.present = False
        self._latest, self._subscriber = LatestValue(), None
        self._deflections, self._pressed, self._latched = (0.0, 0.0), False, False
        self._arrived.connect(self._follow, Qt.QueuedConnection)

    def start(self):
        """Subscribes."""
        self._subscriber = rospy.Subscriber(PAD_TOPIC, Joy, self.callback, queue_size=5)

    def stop(self):
        """Unsubscribes."""
        if self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None

    def clear(self):
        """Ignores the stick until it was in its center. Emits nothing."""
        self._latched = self._latched or self._deflections != (0.0, 0.0)
        self._deflections = (0.0, 0.0)

    def check(self):
        """Releases the stick when there is no publisher any more."""
        self.present = self._subscriber is not None and self._subscriber.get_num_connections() > 0
        if not self.present:
            self._move((0.0, 0.0))

    def callback(self, message):
        """Stores a Joy message; runs in the subscriber's thread."""
        if self._latest.put(message):
            self._arrived.emit()

    def _follow(self):
        message = self._latest.take()
        if message is None or len(message.axes) <= max(STEERING_AXIS, SPEED_AXIS):
            return
        pressed = any(message.buttons)
        if pressed and not self._pressed:
            self.clear()
            self.stopped.emit()
        self._pressed = pressed
        self._move((deflection(message.axes[SPEED_AXIS]), deflection(-message.axes[STEERING_AXIS])))

    def _move(self, deflections):
        if self._latched:
            self._latched = deflections != (0.0, 0.0)
        elif deflections != self._deflections:
            self._deflections = deflections
            self.moved.emit(*deflections)


class InputDevices(QObject):
    """Adds the deflections of a window's keys and of the gamepad."""

    moved = pyqtSignal(float, float)  # speed, steering: -1..1, right is positive
    stopped = pyqtSignal()

    def __init__(self, window):
        super().__init__(window)
        self.keys, self.pad = Keys(window), Pad(self)
        self._deflections = {}
        for source in (self.keys, self.pad):
            source.moved.connect(lambda *pair, source=source: self._move(source, pair))
            source.stopped.connect(self._stop)

    def clear(self):
        """Ignores what is held now until it is released. Emits nothing."""
        self._deflections.clear()
        self.keys.clear()
        self.pad.clear()

    def _move(self, source, deflections):
        self._deflections[source] = deflections
        sums = (sum(pair) for pair in zip(*self._deflections.values()))
        self.moved.emit(*(max(-1.0, min(1.0, value)) for value in sums))

    def _stop(self):
        self.clear()
        self.stopped.emit()

"""Arrow keys and WASD, held: speed and steering; Space: stop."""

from PyQt5.QtCore import QEvent, QObject, Qt, QTimer, pyqtSignal
from PyQt5.QtWidgets import QAbstractButton, QSlider, QWidget

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
CLICK = (Qt.Key_Return, Qt.Key_Enter)  # what Space does to a focused button elsewhere
# X servers repeat a held key as pairs of release and press, which Qt cannot always tell apart.
RELEASE_MS = 30  # a key that is pressed again within this time was held [ms]
OTHERS = Qt.ControlModifier | Qt.AltModifier | Qt.MetaModifier  # with these a key is a shortcut


class Keys(QObject):
    """Filters the key events of a window and its widgets.

    A slider that has the keyboard focus keeps its arrow keys; WASD drives even then.
    """

    moved = pyqtSignal(float, float)  # speed, steering: -1, 0 or 1; when they change
    stopped = pyqtSignal()

    def __init__(self, window):
        """Starts to filter.

        Args:
            window: QWidget with all its widgets.
        """
        super().__init__(window)
        self._window, self._held, self._shares = window, set(), (0, 0)
        self._going = {}  # held key -> QTimer that ends its release
        for widget in (window, *window.findChildren(QWidget)):
            widget.installEventFilter(self)

    def clear(self):
        """Forgets the held keys: each has to be pressed anew. Emits nothing."""
        self._drop_all()
        self._shares = (0, 0)

    def _drop_all(self):
        self._held.clear()
        for key in tuple(self._going):
            self._keep(key)

    def eventFilter(self, widget, event):
        """Takes the keys of the car; everything else goes on to its widget."""
        kind = event.type()
        if kind in (QEvent.WindowDeactivate, QEvent.Hide):
            if widget is self._window and self._held:
                self._drop_all()
                self._update()
        elif kind == QEvent.KeyPress:
            return self._press(widget, event)
        elif kind == QEvent.KeyRelease:
            return self._release(event)
        return False

    def _press(self, widget, event):
        key = event.key()
        if event.modifiers() & OTHERS or (isinstance(widget, QSlider) and key in ARROWS):
            return False
        if key in BINDINGS:
            if key in self._going:
                self._keep(key)
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
            if not event.isAutoRepeat() and key not in self._going:
                timer = QTimer(self, singleShot=True, timerType=Qt.PreciseTimer)
                timer.timeout.connect(lambda: self._let_go(key))
                timer.start(RELEASE_MS)
                self._going[key] = timer
            return True
        return key == STOP  # else it clicks the focused button

    def _keep(self, key):
        """Forgets the release of a key."""
        timer = self._going.pop(key)
        timer.stop()
        timer.deleteLater()

    def _let_go(self, key):
        """Ends a release: the key was not pressed again."""
        self._keep(key)
        self._held.discard(key)
        self._update()

    def _update(self):
        ways = {BINDINGS[key] for key in self._held}  # two keys of one way count once
        shares = sum(way[0] for way in ways), sum(way[1] for way in ways)
        if shares != self._shares:
            self._shares = shares
            self.moved.emit(*shares)

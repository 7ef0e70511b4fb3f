"""Driving by hand: keys and pad together."""

from PyQt5.QtCore import QObject, pyqtSignal

from deepracer_teleop.hand.keys import Keys
from deepracer_teleop.hand.pad import Pad


class Hand(QObject):
    """Adds up what keys and pad say.

    Attributes:
        keys: Keys.
        pad: Pad.
    """

    moved = pyqtSignal(float, float)  # speed, steering: -1..1, right is positive
    stopped = pyqtSignal()

    def __init__(self, window):
        """Follows the keys of a window; start() subscribes to the pad.

        Args:
            window: QWidget with all its widgets.
        """
        super().__init__(window)
        self.keys, self.pad = Keys(window), Pad(self)
        self._shares = {}
        for source in (self.keys, self.pad):
            source.moved.connect(lambda *shares, source=source: self._move(source, shares))
            source.stopped.connect(self._stop)

    def clear(self):
        """Lets nothing that is held now count any more. Emits nothing."""
        self._shares.clear()
        self.keys.clear()
        self.pad.clear()

    def _move(self, source, shares):
        self._shares[source] = shares
        sums = (sum(pair) for pair in zip(*self._shares.values()))
        self.moved.emit(*(max(-1.0, min(1.0, value)) for value in sums))

    def _stop(self):
        self.clear()
        self.stopped.emit()

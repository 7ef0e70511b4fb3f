"""The latest value that another thread has set."""

import threading


class LatestValue:
    """Stores the latest value set by another thread; older ones are dropped."""

    def __init__(self):
        self._lock = threading.Lock()
        self._item = None

    def put(self, item):
        """Stores an item; returns whether there was none (the owner then has to be notified)."""
        with self._lock:
            empty, self._item = self._item is None, item
            return empty

    def take(self):
        """Returns the latest item and removes it; None if there is none."""
        with self._lock:
            item, self._item = self._item, None
            return item

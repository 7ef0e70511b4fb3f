"""Times of messages: at once for a button, after an interval for an axis, and autorepeat."""


class PublishTimer:
    """Decides when to publish. All times are wall time: a hand does not move in simulated time.

    Args:
        autorepeat_rate: messages per second while nothing changes [Hz]; 0: none.
        coalesce_interval: wait for more movement after the first [s].
    """

    def __init__(self, autorepeat_rate=0.0, coalesce_interval=0.001):
        for name, value in (
            ("autorepeat_rate", autorepeat_rate),
            ("coalesce_interval", coalesce_interval),
        ):
            if not 0.0 <= value < float("inf"):
                raise ValueError(f"{name} is {value!r}, must be 0 or more")
        if autorepeat_rate and coalesce_interval > 1.0 / autorepeat_rate:
            raise ValueError(
                f"coalesce_interval is {coalesce_interval:g} s, must be at most "
                f"{1.0 / autorepeat_rate:g} s, one period of autorepeat_rate"
            )
        self._repeat = 1.0 / autorepeat_rate if autorepeat_rate else float("inf")
        self._coalesce = coalesce_interval
        self._due, self._last = float("inf"), float("-inf")

    def input_changed(self, now, axis, button):
        """An axis or a button changed at wall time [s]."""
        if button:
            self._due = now
        elif axis:
            self._due = min(self._due, now + self._coalesce)

    def due(self, now):
        """Whether to publish now; if so, it counts as published."""
        if now < self._due and now - self._last < self._repeat:
            return False
        self._due, self._last = float("inf"), now
        return True

    def stop(self):
        """Publish nothing until an input changes."""
        self._due, self._last = float("inf"), float("inf")

    def start(self, now):
        """Restart autorepeat."""
        self._due, self._last = float("inf"), now

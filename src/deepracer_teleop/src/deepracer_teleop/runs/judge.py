"""The referee's status during one start."""

import threading

import numpy as np


class Judge:
    """Stores LapStatus messages, in a subscriber's thread, up to the finish of a lap."""

    def __init__(self):
        self._lock = threading.Lock()
        self._status, self._errors, self._stale = None, [], False

    @property
    def status(self):
        """The newest LapStatus of this start, or None."""
        return self._status

    def restart(self):
        """Starts anew; to be called right before the referee is restarted."""
        with self._lock:
            self._status, self._errors, self._stale = None, [], True

    def callback(self, status):
        """Stores a LapStatus."""
        with self._lock:
            if self._stale and (status.laps or status.running):
                return  # it was sent before the referee was restarted
            self._stale = False
            if self._status is not None and self._status.laps:
                return  # what comes after the finish does not count
            self._status = status
            if status.running:
                self._errors.append(abs(status.lateral_error))

    def result(self):
        """Returns the figures of the start: lap time and penalty [s], lateral errors [m]."""
        with self._lock:
            status, errors = self._status, np.array(self._errors or [0.0])
        return {
            "lap_time": round(status.last_lap_time, 4),
            "penalty": status.penalty,
            "mean_lateral_error": round(float(errors.mean()), 4),
            "max_lateral_error": round(float(errors.max()), 4),
        }

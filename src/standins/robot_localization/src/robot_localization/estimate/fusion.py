"""Measurements in the order of their times, late ones included."""

import heapq
import itertools
from collections import deque

SAME_TIME = 1e-9  # [s]


class Fusion:
    """A queue in front of a filter.

    Args:
        ekf: Ekf.
        sensor_timeout: Silence after which the state is predicted without a measurement [s].
        to_now: Whether to predict up to the present each time.
        history: How far back a late measurement may reach [s]; None: late ones correct the present
            state. With a history the filter goes back and takes all since then again.
    """

    def __init__(self, ekf, sensor_timeout, to_now=False, history=None):
        self.ekf = ekf
        self._timeout, self._to_now, self._length = sensor_timeout, to_now, history
        self._count = itertools.count()
        self._outliers = 0
        self.clear()

    def clear(self):
        """Forgets what waits and what was."""
        self._queue = []
        self._states, self._taken = deque(), deque()

    def add(self, measurement):
        """Puts a measurement into the queue."""
        heapq.heappush(self._queue, (measurement.time, next(self._count), measurement))

    def outliers(self):
        """How many measurements were outliers since the last call."""
        count, self._outliers = self._outliers, 0
        return count

    def advance(self, now):
        """Takes all measurements up to now [s], and predicts where that is due."""
        ekf, due = self.ekf, self._to_now
        if self._queue:
            if self._length is not None and self._queue[0][0] < ekf.time and ekf.initialized:
                self._go_back(self._queue[0][0])
            while self._queue and self._queue[0][0] <= now:
                self._take(heapq.heappop(self._queue)[2])
        elif ekf.initialized and now - ekf.time >= self._timeout:
            due = True
        if ekf.initialized and due and now > ekf.time:
            ekf.predict(now - ekf.time)
            ekf.time = now
        if self._length is not None:
            self._forget(ekf.time - self._length)

    def _take(self, measurement):
        if not self.ekf.process(measurement):
            self._outliers += 1
        if self._length is None:
            return
        self._taken.append(measurement)
        if not self._queue or abs(self._queue[0][0] - self.ekf.time) > SAME_TIME:
            ekf = self.ekf
            self._states.append((ekf.time, ekf.state.copy(), ekf.covariance.copy()))

    def _go_back(self, time):
        """Back to the last state before a time, or the oldest; what came since waits again."""
        oldest = None
        while self._states and self._states[-1][0] > time - SAME_TIME:
            oldest = self._states.pop()
        if self._states:
            oldest = self._states[-1]
        elif oldest is not None:
            self._states.append(oldest)
        else:
            return
        ekf = self.ekf
        ekf.time, ekf.state, ekf.covariance = oldest[0], oldest[1].copy(), oldest[2].copy()
        while self._taken and self._taken[-1].time > ekf.time + SAME_TIME:
            self.add(self._taken.pop())

    def _forget(self, time):
        while self._taken and self._taken[0].time < time:
            self._taken.popleft()
        while self._states and self._states[0][0] < time:
            self._states.popleft()

"""The real-time factor that the window shows."""

import time
from collections import deque

PACE_WINDOW = 1.0  # wall time over which it is taken [s]


class Pace:
    """Simulated seconds per second of wall time, over the last PACE_WINDOW."""

    def __init__(self, clock=time.monotonic):
        self._clock, self._samples = clock, deque()

    def update(self, simulated):
        """Update with the simulated time [s]; returns the factor or None while unknown."""
        samples, now = self._samples, self._clock()
        if samples and simulated < samples[-1][1]:  # a reset
            samples.clear()
        samples.append((now, simulated))
        while len(samples) > 2 and now - samples[1][0] >= PACE_WINDOW:
            samples.popleft()
        span = now - samples[0][0]
        return (simulated - samples[0][1]) / span if span >= 0.5 * PACE_WINDOW else None

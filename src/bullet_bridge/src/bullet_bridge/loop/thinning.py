"""/clock while the simulation runs free: messages at least CLOCK_GAP of wall time apart."""

CLOCK_GAP = 0.002  # [s] least wall time between two messages on /clock when running free ...
CLOCK_STRIDE = 0.05  # [s] ... and most simulated time


class Thinning:
    """Skips due times of a clock at the present speed of the simulation.

    Args:
        clock: SimClock.
        now: function that gives wall time [s].
        step: physics step at which it begins.

    Attributes:
        waits: whether messages are further apart than a batch; then the clock is published at the
            end of a batch, which it does not cut short.
    """

    def __init__(self, clock, now, step):
        self._clock, self._now = clock, now
        self._mark, self.waits = (now(), step), False
        self._batch = self._stride = 1

    def set_batch(self, batch, time_step):
        """Set the longest batch [steps] and the physics step [s]."""
        self._batch, self._stride = batch, round(CLOCK_STRIDE / time_step)

    def skip(self, step):
        """After a message: skip the due times that lie within CLOCK_GAP."""
        now, (before, last_step) = self._now(), self._mark
        self._mark = now, step
        passed = max(now - before, 1e-6)
        steps = min(int((step - last_step) * CLOCK_GAP / passed), self._stride)
        self.waits = steps > self._batch
        self._clock.skip(min(steps, self._stride - self._batch) if self.waits else steps)

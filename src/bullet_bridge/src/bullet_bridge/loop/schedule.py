"""Schedules of periodic messages, counted in physics steps, without drift."""

import math


class Schedule:
    """Due times k / rate, each rounded to the nearest physics step.

    A rate that does not divide the step rate (30 Hz at 1 ms) keeps its mean exactly; single
    periods differ by one step.

    Args:
        rate: [Hz] of simulated time.
        time_step: physics step [s].
        start: step after which it starts.

    Raises:
        ValueError: the rate is not above 0 or higher than the step rate.
    """

    def __init__(self, rate, time_step, start=0):
        if not (math.isfinite(rate) and 0 < rate <= 1.0001 / time_step):
            raise ValueError(
                f"rate is {rate} Hz, must be above 0 and at most "
                f"{1 / time_step:g} Hz, one per physics step"
            )
        self._ratio = 1.0 / (rate * time_step)
        self.restart(start)

    def restart(self, step):
        """Count on from a step: the first due step after it that is k periods from 0."""
        self._count = math.floor(step / self._ratio + 1e-9) + 1
        self.next = round(self._count * self._ratio)

    def skip(self, steps):
        """Skip due steps that are less than `steps` after the last one before `next`."""
        first = round((self._count - 1) * self._ratio) + steps
        self._count = max(self._count, math.ceil(first / self._ratio - 1e-9))
        self.next = round(self._count * self._ratio)

    def due(self, step):
        """Whether it is due at this step; then the next due step is set."""
        if step < self.next:
            return False
        self._count = max(self._count + 1, math.floor(step / self._ratio + 1e-9) + 1)
        self.next = round(self._count * self._ratio)
        return True


class SubscribedSchedule(Schedule):
    """A Schedule that is due only while there are subscribers.

    Without subscribers it ends no batch of steps, but its due times continue: a later subscriber
    gets messages of the same times as if there had been one from the start.

    Args:
        rate, time_step, start: see Schedule.
        has_subscribers: function -> whether the topic has subscribers.

    Attributes:
        subscribed: whether there were subscribers at the last check.
    """

    def __init__(self, rate, time_step, start, has_subscribers):
        super().__init__(rate, time_step, start)
        self._has_subscribers, self.subscribed = has_subscribers, False

    def check_subscribers(self, step):
        """Check after a step whether there are subscribers, and return it."""
        subscribed = bool(self._has_subscribers())
        if subscribed and not self.subscribed:
            super().due(step)  # skip what was due without a subscriber
        self.subscribed = subscribed
        return subscribed

    def next_due_subscribed(self, step, check=True):
        """Step after which a message with subscribers is due, or infinity.

        Args:
            step: the last one.
            check: check for subscribers; False: as at the last check.
        """
        subscribed = self.check_subscribers(step) if check else self.subscribed
        return self.next if subscribed else math.inf

    def due(self, step):
        """As Schedule's; False without subscribers at the last check."""
        return self.subscribed and step >= self.next and super().due(step)

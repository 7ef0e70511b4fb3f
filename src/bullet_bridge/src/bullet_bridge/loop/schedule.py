"""When something is due, counted in physics steps, without drift."""

import math


class Schedule:
    """Due times k / rate, each rounded to the nearest physics step.

    A rate that does not divide the step rate (30 Hz at 1 ms) keeps its mean exactly; single
    periods differ by one step.

    Args:
        rate: [Hz] of simulated time.
        time_step: physics step [s].
        start: step after which it runs.

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
        """Leave out due steps that are less than `steps` after the last one before `next`."""
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


class HeardSchedule(Schedule):
    """A Schedule that counts while somebody subscribes.

    While nobody does, it goes on silently: what is due to nobody holds up no batch of steps, and
    who subscribes later gets messages of the same times as if there had always been somebody.

    Args:
        rate, time_step, start: see Schedule.
        heard: function that tells whether somebody subscribes.

    Attributes:
        heard: whether somebody did at the last look.
    """

    def __init__(self, rate, time_step, start, heard):
        super().__init__(rate, time_step, start)
        self._ask, self.heard = heard, False

    def look(self, step):
        """Look, after a step, whether somebody subscribes; returns it."""
        heard = bool(self._ask())
        if heard and not self.heard:
            super().due(step)  # what was due to nobody is over
        self.heard = heard
        return heard

    def next_heard(self, step, look=True):
        """Step after which a message is due that somebody hears, or infinity.

        Args:
            step: the last one.
            look: look anew who subscribes.
        """
        return self.next if (self.look(step) if look else self.heard) else math.inf

    def due(self, step):
        """As Schedule's; False for what nobody subscribed to at the last look."""
        return step >= self.next and super().due(step) and self.heard

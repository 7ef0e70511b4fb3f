"""Due times of what is measured, in physics steps."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any, ClassVar

from bullet_sim.component import Stateful

COUNTED = 600  # periods over which a mean is taken
NANOSECOND = 1e-9  # [s]
NEVER: Any = math.inf  # a physics step that is not reached
RAREST = 1e-15  # messages a step: one in 30,000 years of steps of 1 ms


def _raised(rate: float, time_step: float) -> float:
    """A rate [Hz] whose period has a number of steps, however low it was."""
    return max(rate, RAREST / time_step)


def whole_rate(
    rate: float, time_step: float, passed: Callable[[float, float], bool] = operator.ge
) -> float:
    """Rate [Hz] of messages that count each period from the step of the message before.

    So do some of Gazebo's plugins: 30 Hz become 29.4 Hz with steps of 1 ms, 34 each.

    Args:
        rate: [Hz]; time_step: [s].
        passed: compares the time since the message before with the period.
    """
    rate = _raised(rate, time_step)
    nanoseconds, steps = round(1e9 * time_step), max(1, int(1.0 / (rate * time_step)) - 1)
    while not passed(_seconds(steps * nanoseconds), 1.0 / rate):
        steps += 1
    return 1.0 / (steps * time_step)


def is_late_enough(since: float, limit: float) -> bool:
    """Whether the time [s] since the last message is a period of a limit [Hz], as rounded."""
    return since >= 1.0 / limit - NANOSECOND


def passed_rate(rate: float, limit: float, time_step: float) -> float:
    """Mean rate [Hz] of what is left of messages when those are left out that come too soon.

    Of 30 Hz with steps of 1 ms a limit of 30 Hz leaves 20 Hz: each third period is 34 ms, and the
    others are shorter than 1/30 s.

    Args:
        rate: [Hz] of a Schedule; limit: [Hz]: they are 1 / limit apart; time_step: [s].
    """
    passed, last, rate = 0, -math.inf, _raised(rate, time_step)
    for k in range(COUNTED):
        time = round(k / (rate * time_step)) * time_step
        if is_late_enough(time - last, limit):
            passed, last = passed + 1, time
    return passed * rate / COUNTED


def _seconds(nanoseconds: int) -> float:
    """As Gazebo's common::Time rounds it."""
    whole, rest = divmod(nanoseconds, 10**9)
    return whole + rest * 1e-9


class Schedule(Stateful):
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

    STATE: ClassVar[tuple[str, ...]] = ("_count", "next", "_ratio", "_time_step")

    def __init__(self, rate: float, time_step: float, start: int = 0) -> None:
        self.set_step(time_step, rate, start)

    def set_rate(self, rate: float, step: int) -> None:
        """Continue after a step with another rate [Hz].

        Raises:
            ValueError: as of the class.
        """
        time_step = self._time_step
        if not (math.isfinite(rate) and 0 < rate <= 1.0001 / time_step):
            raise ValueError(
                f"rate is {rate} Hz, must be above 0 and at most "
                f"{1 / time_step:g} Hz, one per physics step"
            )
        self._ratio = 1.0 / (_raised(rate, time_step) * time_step)
        self.restart(step)

    def set_step(self, time_step: float, rate: float, step: int) -> None:
        """Continue after a step with another physics step [s], at a rate [Hz].

        Raises:
            ValueError: as of the class.
        """
        self._time_step = time_step
        self.set_rate(rate, step)

    def restart(self, step: int) -> None:
        """Count on from a step: the first due step after it that is k periods from 0."""
        self._count = math.floor(step / self._ratio + 1e-9) + 1
        self.next = round(self._count * self._ratio)

    def skip(self, steps: int) -> None:
        """Skip due steps that are less than `steps` after the last one before `next`."""
        first = round((self._count - 1) * self._ratio) + steps
        self._count = max(self._count, math.ceil(first / self._ratio - 1e-9))
        self.next = round(self._count * self._ratio)

    @property
    def period(self) -> float:
        """Mean number of steps between two due ones."""
        return self._ratio

    def due_before(self, end: int) -> list[int]:
        """All due steps before one; then the next due step is that or a later one."""
        steps = []
        while self.next < end:
            steps.append(self.next)
            self.due(self.next)
        return steps

    def due(self, step: int) -> bool:
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
        has_subscribers: function -> whether the topic has subscribers.
        on_start: function that is called when it has some again.

    Attributes:
        subscribed: whether there were subscribers at the last check.
    """

    STATE: ClassVar[tuple[str, ...]] = ("subscribed",)

    def __init__(
        self,
        rate: float,
        time_step: float,
        start: int,
        has_subscribers: Callable[[], Any],
        on_start: Callable[[], None] = lambda: None,
    ) -> None:
        super().__init__(rate, time_step, start)
        self._has_subscribers, self.subscribed = has_subscribers, False
        self._on_start = on_start

    def check_subscribers(self, step: int) -> bool:
        """Check after a step whether there are subscribers, and return it."""
        subscribed = bool(self._has_subscribers())
        if subscribed and not self.subscribed:
            super().due(step)  # skip what was due without a subscriber
            self._on_start()
        self.subscribed = subscribed
        return subscribed

    def next_due_subscribed(self, step: int, check: bool = True) -> int:
        """Step after which a message with subscribers is due, or infinity.

        Args:
            step: the last one.
            check: check for subscribers; False: as at the last check.
        """
        subscribed = self.check_subscribers(step) if check else self.subscribed
        return self.next if subscribed else NEVER

    def due(self, step: int) -> bool:
        """As Schedule's; False without subscribers at the last check."""
        return self.subscribed and step >= self.next and super().due(step)


class BatchSchedule(SubscribedSchedule):
    """Due after each batch of steps, which it lets go on until a step.

    Args:
        world: World whose steps these are.
        needed: function -> step after which it has to be due.
        on_start: as of a SubscribedSchedule.
    """

    def __init__(self, world: Any, needed: Callable[[], int], on_start: Callable[[], None]) -> None:
        step = world.time_step
        super().__init__(1.0 / step, step, world.step_count, lambda: True, on_start)
        self._world, self._needed = world, needed

    def next_due_subscribed(self, step: int, check: bool = True) -> int:
        super().next_due_subscribed(step, check)
        return self._needed()

    def due(self, step: int) -> bool:
        """Not at a step within a batch that the world shows."""
        return not self._world.is_shown and super().due(step)

"""/clock and the pace: schedules of messages, pacing by wall time, clock throttling."""

from __future__ import annotations

import collections
import math
import operator
import time as wall
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import rospy
from bullet_sim.component import Stateful
from rosgraph_msgs.msg import Clock

from bullet_bridge.transport.conversions import stamp
from bullet_bridge.transport.packed import PackedClock
from bullet_bridge.transport.publishing import publisher

PACKETS = 200.0  # [Hz] of simulated time: of messages on /clock that leave together
MAX_PACKET = 1000  # messages on /clock that leave together; after a longer jump one goes alone
COUNTED = 600  # periods over which a mean is taken
NANOSECOND = 1e-9  # [s]
CLOCK_GAP = 0.002  # [s] minimum wall time between two messages on /clock when running free ...
CLOCK_STRIDE = 0.05  # [s] ... and maximum simulated time


class ClockThrottle:
    """Skips due times of a clock at the present speed of the simulation.

    Args:
        now: function that returns wall time [s].
        step: physics step at which it starts.

    Attributes:
        waits: whether messages are further apart than a batch; then the clock is published at the
            end of a batch, which it does not cut short.
    """

    def __init__(self, clock: SimClock, now: Callable[[], float], step: int) -> None:
        self._clock, self._now = clock, now
        self._last, self.waits = (now(), step), False
        self._batch = self._stride = 1

    def set_batch(self, batch: int, time_step: float) -> None:
        """Set the longest batch [steps] and the physics step [s]."""
        self._batch, self._stride = batch, round(CLOCK_STRIDE / time_step)

    def skip(self, step: int) -> None:
        """After a message: skip the due times that lie within CLOCK_GAP."""
        now, (before, last_step) = self._now(), self._last
        self._last = now, step
        passed = max(now - before, 1e-6)
        steps = min(int((step - last_step) * CLOCK_GAP / passed), self._stride)
        self.waits = steps > self._batch
        self._clock.skip(min(steps, self._stride - self._batch) if self.waits else steps)


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

    STATE = ("subscribed",)

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


MAX_LAG = 0.25  # [s] lateness beyond which the pace restarts instead of catching up
WINDOW = 1.0  # [s] wall time over which the real time factor is measured
HISTORY = 4096  # batches whose lateness is stored


class Pace:
    """Wall time at which simulated times are due.

    Args:
        factor: simulated seconds per wall second; 0: as fast as possible.
        now: function that returns wall time [s].
        on_measured: called with the measured real time factor after each full WINDOW.
    """

    def __init__(
        self,
        factor: float,
        now: Callable[[], float] = wall.monotonic,
        on_measured: Callable[[float], None] | None = None,
    ) -> None:
        self.factor, self._now, self._on_measured = factor, now, on_measured
        self._late: collections.deque[float] = collections.deque(maxlen=HISTORY)
        self._measured = 0.0
        self.anchor(0.0)

    def anchor(self, time: float) -> None:
        """Restart the pace: simulated time [s] is due now."""
        self._wall_start = self._window_wall = self._now()
        self._sim_start = self._window_sim = time

    def delay(self, time: float) -> float:
        """Wall time [s] until the step that follows simulated time [s] is due; 0: it is due."""
        now = self._now()
        if now - self._window_wall >= WINDOW:
            self._measured = (time - self._window_sim) / (now - self._window_wall)
            self._window_wall, self._window_sim = now, time
            if self._on_measured is not None:
                self._on_measured(self._measured)
        if self.factor == 0:
            return 0.0
        delay = self._wall_start + (time - self._sim_start) / self.factor - now
        if delay > 0:
            return delay
        self._late.append(-delay)
        if delay < -MAX_LAG:
            self._wall_start, self._sim_start = now, time
        return 0.0

    def statistics(self) -> dict[str, float]:
        """Lateness of the last batches and the measured real time factor.

        Returns:
            dict of lateness_p50, lateness_p99, lateness_max [s] (wall time from when a batch was
            due to when it began; 0 when running free), batches (their number) and
            real_time_factor (over the last full WINDOW; 0: none yet).
        """
        late = sorted(self._late)
        pick = (
            (lambda fraction: late[min(int(fraction * len(late)), len(late) - 1)])
            if late
            else lambda fraction: 0.0
        )
        return {
            "lateness_p50": pick(0.5),
            "lateness_p99": pick(0.99),
            "lateness_max": pick(1.0),
            "batches": len(late),
            "real_time_factor": self._measured,
        }


def set_process_time(now: rospy.Time) -> None:
    """Set rospy's time in this process, as a subscription to /clock would."""
    rospy.rostime._rostime_current = now


class SimClock(Schedule):
    """Publishes simulated time, as gazebo_ros after every step or at a rate, and on request.

    The messages of steps that are made in one batch leave together, PACKETS times a simulated
    second or more often.

    Args:
        rate: messages per simulated second [Hz]; 0: one a step.
        time_step: physics step [s].
        send: function of a list of simulated times [s], instead of the topic /clock (tests).
        set_time: function of a rospy.Time that sets the time of this process.
        latch: a new subscriber gets the last time; in Gazebo it waits for the next step.
    """

    STATE = ("_sent",)

    def __init__(
        self,
        rate: float,
        time_step: float,
        send: Callable[[Sequence[float]], None] | None = None,
        set_time: Callable[[rospy.Time], None] | None = None,
        latch: bool = False,
    ) -> None:
        self._set_time = set_time
        if send is None:
            send = PackedClock(publisher("/clock", Clock, latch=latch)).send
        self._send = send
        self._rate = rate
        self._sent = 0.0  # the last time
        self.set_time_step(time_step, 0)

    def set_time_step(self, time_step: float, step: int) -> None:
        """Continue after a step with another physics step [s]; at most one message per step."""
        fastest = 1.0 / time_step
        rate = whole_rate(min(self._rate, fastest), time_step) if self._rate else PACKETS
        self.set_step(time_step, min(rate, fastest), step)

    def publish_due(self, step: int, time: float, thinned: bool = False) -> bool:
        """Publish the time [s] if it is due at this step.

        Args:
            thinned: False: where each step has a message, those of a batch leave at its end.

        Returns:
            Whether it was due.
        """
        is_due = self.due(step)
        if is_due or not (thinned or self._rate):
            self.publish(time)
        return is_due

    def settle(self, time: float, always: bool) -> None:
        """Publish the steps up to a time [s] that are not published yet.

        Args:
            always: also where there are none, as after a reset.
        """
        if always or time > self._sent:
            self.publish(time)
            return
        self._sent = time
        if self._set_time is not None:
            self._set_time(stamp(time))

    def publish(self, time: float) -> None:
        """Publish the time [s] now."""
        if self._set_time is not None:
            self._set_time(stamp(time))
        self._send([*self._before(time), time])
        self._sent = time

    def _before(self, time: float) -> list[float]:
        """Times of the steps since the last message, where each gets one."""
        count = round((time - self._sent) / self._time_step)
        if self._rate or not 1 < count <= MAX_PACKET:
            return []
        return [time - number * self._time_step for number in range(count - 1, 0, -1)]

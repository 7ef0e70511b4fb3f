"""/clock and the pace: schedules of messages, pacing by wall time, clock throttling."""

from __future__ import annotations

import collections
import time as wall
from collections.abc import Callable, Sequence

import rospy
from bullet_sim.parts.schedule import Schedule, whole_rate
from rosgraph_msgs.msg import Clock

from bullet_bridge.transport.conversions import stamp
from bullet_bridge.transport.packed import PackedClock
from bullet_bridge.transport.publishing import publisher

PACKETS = 200.0  # [Hz] of simulated time: of messages on /clock that leave together
MAX_PACKET = 1000  # messages on /clock that leave together; after a longer jump one goes alone
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


PARTS = "steps", "messages", "sockets"  # of the loop's time


class Shares:
    """What the loop's wall time goes into.

    Attributes:
        last: part -> fraction of the time between the last two calls of measured().
    """

    def __init__(self) -> None:
        self.last = dict.fromkeys(PARTS, 0.0)
        self.restart()

    def restart(self) -> None:
        """Begin a new measurement."""
        self._spent, self._since = dict.fromkeys(PARTS, 0.0), wall.perf_counter()

    def add(self, part: str, since: float) -> float:
        """Add the time since a result of perf_counter(); what that is now."""
        now = wall.perf_counter()
        self._spent[part] += now - since
        return now

    def measured(self) -> None:
        """End a measurement, begin the next one."""
        passed = max(wall.perf_counter() - self._since, 1e-9)
        self.last = {part: spent / passed for part, spent in self._spent.items()}
        self.restart()


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

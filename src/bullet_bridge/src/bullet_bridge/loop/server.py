"""The simulation thread: it owns the engine, steps it, and does the jobs of other threads."""

from __future__ import annotations

import gc
import math
import sys
import threading
import time as wall
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

import rospy
from bullet_sim.errors import WorldError
from bullet_sim.parts.schedule import NEVER
from paddock_common.process import raise_priority

from bullet_bridge.loop.clock import PARTS, ClockThrottle, Pace, Shares, SimClock
from bullet_bridge.loop.rtf_monitor import CallMonitor, RealTimeFactorMonitor

if TYPE_CHECKING:
    from bullet_sim.world import World, WorldState

    from bullet_bridge.loop.jobs import JobQueue
    from bullet_bridge.transport.relay import Relay


class Reporter(Protocol):
    """Publishes in every batch of steps.

    Attributes:
        watches: what it publishes is of the state after a step alone, see parts.base.Part.
        period: of what watches [steps].
    """

    watches: bool

    @property
    def period(self) -> float: ...

    def next_due(self) -> int:
        """Physics step after which publish() has to be called at the latest."""

    def publish(self, step: int, time: float) -> None:
        """Publish what is due after a batch that ended at a step, simulated time [s]."""

    def publish_recorded(self, end: int) -> None:
        """Publish what watches, can be made of several recorded steps at once and is due before a
        step."""

    def restart(self) -> None:
        """Restart the schedule, after a reset or a change of the physics step."""


class ModelOutputs(Protocol):
    """What the loop uses of bullet_bridge.robots.Robots."""

    waits_for_renderer: bool

    def next_due(self) -> int:
        """As of a Reporter, but for what watches."""

    def next_watched(self) -> tuple[int, float]:
        """As next_due(), of what watches, and the shortest period of it [steps]."""

    def publish(self, step: int, time: float) -> None:
        """As of a Reporter."""

    def publish_watched(self, step: int, time: float) -> None:
        """Publish what watches and is due at a step that the world shows."""

    def publish_recorded(self, end: int) -> None:
        """As of a Reporter."""

    def restart(self, fresh: bool = True) -> None:
        """Restart the schedule; fresh: commands and plugins, too, as after a new start."""

    def apply_commands(self) -> None:
        """Pass the latest commands to the controllers."""

    def refresh(self) -> None:
        """Update what is published, after jobs."""

    def prepare(self) -> None:
        """Prepare models that were reloaded before the first step."""

    def on_time_step(self) -> None:
        """Continue after a change of the physics step."""

    def reset_models(self) -> None:
        """Reset the plugins that have something to reset with their model."""

    def take_failures(self) -> list[str]:
        """Messages about what could not be published since the last call."""

    def save_state(self) -> Any:
        """State of plugins and commands."""

    def restore_state(self, state: Any) -> None:
        """Restore a result of save_state()."""


class Steps:
    """Steps requested by a caller that waits for them.

    Attributes:
        left: steps to go.
        done: set when they are made or aborted.
        error: why they were aborted or are incomplete, or ''.
    """

    def __init__(self, count: int) -> None:
        self.left, self.error, self.done = count, "", threading.Event()


PACED_BATCH = 0.001  # [s] wall time of one batch of steps at a given real time factor
FREE_BATCH = 0.02  # [s] simulated time of the longest batch when running free
IDLE_WAIT = 0.05  # [s] longest wait for jobs, after which a shutdown is noticed
JOBS_SHARE = 0.25  # of the time of a batch that jobs may take before the next one is due
HOLD_LIMIT = 2.0  # [s] wall time for which hold() stops the simulation at most ...
RUN_TIME = 0.2  # [s] ... and for which it then runs, whoever else holds it


class Server:
    """The simulation loop of a world.

    Args:
        robots: Robots, given their commands and published in every batch.
        now: function that returns wall time [s].
    """

    def __init__(
        self,
        world: World,
        jobs: JobQueue,
        robots: ModelOutputs,
        config: Any,
        clock: SimClock | None = None,
        now: Callable[[], float] = wall.monotonic,
        relay: Relay | None = None,
    ) -> None:
        self._world, self._jobs, self._robots = world, jobs, robots
        self.paused, self.lockstep = config.paused, config.lockstep
        self._monotonic, self._niceness = config.monotonic_clock, config.niceness
        self._relay = relay
        self._now = now
        self._holds: list[float] = []  # wall times at which they end [s]
        self._held_since: float | None = None  # wall time [s]
        self._rtf_monitor = RealTimeFactorMonitor(now=now)
        self._pace = Pace(config.real_time_factor, now, self._measured)
        self._clock = clock or SimClock(config.clock_rate, world.time_step, latch=config.lockstep)
        self._throttle = ClockThrottle(self._clock, now, world.step_count)
        self._spent = 0.0  # wall time of the last batch [s]
        self._shares = Shares()
        self._call_monitor = CallMonitor(now=now)
        self._steps: Steps | None = None  # the request that is being served
        self._reporters: list[Reporter] = []
        self._set_batches()
        self._anchor()

    def _set_batches(self) -> None:
        step = self._world.time_step
        self._free_batch = max(1, round(FREE_BATCH / step))
        self._throttle.set_batch(self._free_batch, step)
        self._batch = (
            max(1, round(self._pace.factor * PACED_BATCH / step))
            if self._pace.factor
            else self._free_batch
        )
        if self._relay is not None:
            self._relay.set_polling(self._pace.factor == 0)  # running free

    def add_reporter(self, reporter: Reporter) -> None:
        """Add an object with next_due(), publish(step, time) and restart(), used in every batch."""
        self._reporters.append(reporter)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._world.time

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per wall second; 0: as fast as possible."""
        return self._pace.factor

    def statistics(self) -> dict[str, Any]:
        """As Pace.statistics, and `shares`: fractions of the wall time of the last WINDOW that went
        into steps, into making messages, into writing to sockets. All are 0 while paused."""
        values: dict[str, Any] = dict(self._pace.statistics(), shares=self._shares.last)
        if self.paused:
            values.update(real_time_factor=0.0, shares=dict.fromkeys(PARTS, 0.0))
        return values

    def _measured(self, factor: float) -> None:
        self._shares.measured()
        self._rtf_monitor.measured(factor, self._pace.factor, self._world.time_step)

    def set_pace(self, factor: float) -> None:
        """Change the real time factor (simulation thread)."""
        self._pace.factor = factor
        self._set_batches()
        self._anchor()

    def set_time_step(self, time_step: float) -> None:
        """Change the physics step [s] and restart all schedules (simulation thread)."""
        before = self._world.time_step
        self._clock.set_time_step(time_step, self._world.step_count)
        try:
            self._world.set_time_step(time_step)
        except ValueError:
            self._clock.set_time_step(before, self._world.step_count)
            raise
        self._clock.restart(self._world.step_count)
        self._robots.on_time_step()
        for reporter in self._reporters:
            reporter.restart()
        self._set_batches()
        self._anchor()

    def _anchor(self) -> None:
        """Restart the measurement of the pace."""
        self._rtf_monitor.restart()
        self._shares.restart()
        self._pace.anchor(self._world.time)

    def run(self) -> None:
        """Loop until the node shuts down."""
        if self._niceness < 0:
            raise_priority(self._niceness)
        sys.setswitchinterval(0.0002)  # other threads release the GIL sooner
        gc.collect()
        gc.freeze()  # later collections skip these objects: shorter pauses
        self._clock.settle(self._world.time, always=self.lockstep)
        while not rospy.is_shutdown():
            try:
                self.spin_once()
            except rospy.ROSException:
                # A shutdown from another thread (rosnode kill, a master that has exited) closes the
                # topics while a batch is being published.
                if not rospy.core.is_shutdown_requested():
                    raise
                return

    def spin_once(self) -> None:
        """One iteration of the loop: jobs, then one batch, or a wait until one is due."""
        free = self.paused or self._steps is not None
        self._run_jobs(0.0, math.inf if free else JOBS_SHARE * self._spent)
        held = self._is_held()
        if self._steps is not None and not held:
            self._make_steps(self._steps)
            return
        if self.paused or held:
            wait = IDLE_WAIT
            self._anchor()
        else:
            wait = min(self._pace.delay(self._world.time), IDLE_WAIT)
            if wait == 0:
                begin = self._now()
                self.advance(self._batch, throttle=self._pace.factor == 0)
                self._spent = self._now() - begin
                return
        self._run_jobs(wait, math.inf if self.paused else wait)

    def _run_jobs(self, wait: float, budget: float) -> None:
        """Run jobs, see JobQueue.run_pending."""
        if self._jobs.run_pending(wait, budget):
            self._robots.refresh()
        self._call_monitor.measured(self._jobs.waiting, self._jobs.answered)

    def hold(self, limit: float = HOLD_LIMIT) -> float:
        """Make no step until release() of the result (simulation thread).

        A model's plugins then start at the step at which it is there, as in Gazebo, which loads
        them between two steps.

        Args:
            limit: wall time [s] at most.
        """
        end = self._now() + limit
        self._holds.append(end)
        return end

    def release(self, hold: float) -> None:
        """Go on after a hold() (simulation thread)."""
        self._holds.remove(hold)

    def _is_held(self) -> bool:
        now = self._now()
        if not self._holds or now >= max(self._holds):
            self._held_since = None
            return False
        since = self._held_since
        if since is None or now - since >= HOLD_LIMIT + RUN_TIME:
            since = self._held_since = now
        return now - since < HOLD_LIMIT

    def advance(self, limit: int, throttle: bool = False) -> None:
        """Commands in, physics steps until something is due or `limit` is reached, results out.

        Args:
            limit: maximum number of physics steps.
            throttle: skip messages on /clock, see ClockThrottle.
        """
        world, robots = self._world, self._robots
        if world.sort_before_start():
            robots.prepare()
            robots.refresh()
        robots.apply_commands()
        due = robots.next_due()
        if not (throttle and self._throttle.waits):
            due = min(due, self._clock.next)
        for reporter in self._reporters:
            if not reporter.watches:
                due = min(due, reporter.next_due())
        first, period = self._next_watched()
        first = max(first, world.step_count + 1)
        end = max(world.step_count + 1, min(world.step_count + limit, due))
        if records := first + period <= end and world.most_recorded > 1:
            end = min(end, world.step_count + world.most_recorded)
        else:
            end = min(end, first)
        begin = wall.perf_counter()
        world.step(end - world.step_count, records)
        stepped = self._shares.add("steps", begin)
        if self._relay is not None:
            self._relay.begin_batch()
        try:
            if records:
                self._publish_watched(throttle)
            self._publish_clock(throttle)
            step, time = world.step_count, world.time
            robots.publish(step, time)
            for reporter in self._reporters:
                reporter.publish(step, time)
        finally:
            made = self._shares.add("messages", stepped)
            if self._relay is not None:
                self._relay.end_batch()
                self._shares.add("sockets", made)

    def _next_watched(self) -> tuple[int, float]:
        """Physics step after which something that watches is due, or infinity; the shortest period
        of that [steps]."""
        due, period = self._robots.next_watched()
        for reporter in self._reporters:
            if reporter.watches and (step := reporter.next_due()) < NEVER:
                due, period = min(due, step), min(period, reporter.period)
        return due, period

    def _publish_watched(self, throttle: bool) -> None:
        """Publish what watches and was due before the last of the steps that were made."""
        world, end = self._world, self._world.step_count
        watching = [reporter for reporter in self._reporters if reporter.watches]
        self._robots.publish_recorded(end)
        for reporter in watching:
            reporter.publish_recorded(end)
        step, _ = self._next_watched()
        if step >= end:
            return
        try:
            while step < end:
                world.show(step)
                self._publish_clock(throttle)
                self._robots.publish_watched(step, world.time)
                for reporter in watching:
                    reporter.publish(step, world.time)
                step = max(step + 1, self._next_watched()[0])
        finally:
            world.show_end()

    def _publish_clock(self, throttle: bool) -> None:
        step = self._world.step_count
        if self._clock.publish_due(step, self._world.time, thinned=throttle) and throttle:
            self._throttle.skip(step)

    # steps on request -------------------------------------------------------------------------
    def begin_steps(self, count: int) -> Steps:
        """Make `count` steps, as fast as possible, while paused (simulation thread).

        Returns:
            Steps; `done` is set when the steps are made and all due messages published.

        Raises:
            WorldError: not paused, or steps are being made already.
        """
        if not self.paused:
            raise WorldError("the simulation runs; pause it before stepping")
        if self._steps is not None:
            raise WorldError(f"{self._steps.left} steps of another call are still to be made")
        self._robots.take_failures()
        self._robots.waits_for_renderer = True  # no wall time counts while steps are made
        self._steps = Steps(count)
        return self._steps

    def _make_steps(self, steps: Steps) -> None:
        """Make a batch of the requested steps, and end the request after its last one."""
        before = self._world.step_count
        self.advance(min(steps.left, self._free_batch))
        steps.left -= self._world.step_count - before
        if steps.left <= 0:
            self._end_steps("; ".join(self._robots.take_failures()))

    def _end_steps(self, error: str) -> None:
        """End the request, if there is one; error: why it is incomplete, or ''."""
        steps, self._steps = self._steps, None
        self._robots.waits_for_renderer = False
        if steps is not None:
            self._settle()
            steps.error = error
            steps.done.set()

    # commands ---------------------------------------------------------------------------------
    def set_paused(self, paused: bool) -> None:
        """Pause or resume (simulation thread).

        Raises:
            WorldError: resuming in lockstep.
        """
        if not paused and self.lockstep:
            raise WorldError("in lockstep time advances only by /gazebo/step")
        self._end_steps("the simulation was paused or resumed by another call")
        self.paused = paused
        self._settle()

    def reset(self, fresh: bool = False) -> None:
        """Reset the world, also simulated time unless it is monotonic (simulation thread).

        Args:
            fresh: as after a new start, as always in lockstep; else controllers and wrenches go on,
                as in Gazebo.
        """
        self._end_steps("the simulation was reset by another call")
        fresh = fresh or self.lockstep
        if fresh:
            self._world.sort_models()
            self._world.reset(time=not self._monotonic)
        else:
            self._world.start_over(time=not self._monotonic)
        self._restart(fresh=fresh)

    def reset_models(self) -> None:
        """Put the models to their initial poses; all else goes on (simulation thread)."""
        self._world.reset_models()
        self._robots.reset_models()

    def _restart(self, fresh: bool = True, tell: bool = False) -> None:
        """Restart all schedules at the present step.

        Args:
            fresh: see Robots.restart.
            tell: publish the time before the next step, too.
        """
        self._clock.restart(self._world.step_count)
        self._robots.restart(fresh)
        for reporter in self._reporters:
            reporter.restart()
        self._settle(tell)

    def save_state(self) -> tuple[WorldState, Any]:
        """The state of world, controllers and sensors, for restore_state()."""
        return self._world.save_state(), self._robots.save_state()

    def restore_state(self, state: tuple[WorldState, Any]) -> str:
        """Go back to a saved state, also of simulated time.

        Returns:
            What is not as it was, one line of text, or ''.

        Raises:
            WorldError: the models are others, or the clock is monotonic; nothing has changed then.
        """
        if self._monotonic:
            raise WorldError(
                "a state cannot be restored with monotonic_clock: time would go back; start "
                "without it"
            )
        world, robots = state
        note = self._world.restore_state(world)
        self._end_steps("a state was restored by another call")
        self._restart(tell=True)
        self._robots.restore_state(robots)
        return note

    def _settle(self, tell: bool = False) -> None:
        """Restart measuring the pace; return when the time and all earlier messages are sent.

        Args:
            tell: send the time even if no step was made, as in lockstep.
        """
        self._anchor()
        self._clock.settle(self._world.time, always=tell or self.lockstep)
        if self._relay is not None:
            self._relay.drain()

"""The loop against a wall clock that only advances when something waits or works."""

import math
import threading

import pytest
import rospy
from bullet_bridge.loop import clock as clock_module
from bullet_bridge.loop.clock import CLOCK_STRIDE, SimClock
from bullet_bridge.loop.jobs import JobQueue
from bullet_bridge.loop.server import HOLD_LIMIT, RUN_TIME, Server
from bullet_bridge.node import Config
from bullet_sim.errors import WorldError
from bullet_sim.parts.schedule import Schedule


class Wall:
    """Wall time [s] of the test."""

    def __init__(self):
        self.time = 100.0

    def now(self):
        return self.time


class World:
    """Counts steps; each takes `cost` of wall time [s]."""

    def __init__(self, wall, cost, time_step=0.001):
        self.wall, self.cost, self.time_step = wall, cost, time_step
        self.step_count, self.batches, self.calls = 0, [], []

    @property
    def time(self):
        """Simulated time [s]."""
        return self.step_count * self.time_step

    most_recorded = 0

    def step(self, count, records=False):
        self.batches.append(count)
        self.step_count += count
        self.wall.time += count * self.cost

    def sort_before_start(self):
        return False

    def sort_models(self):
        self.calls.append("sort_models")

    def reset_models(self):
        self.calls.append("reset_models")

    def reset(self, time):
        self.calls.append(("reset", time))
        if time:
            self.step_count = 0

    def start_over(self, time):
        self.calls.append(("start_over", time))
        if time:
            self.step_count = 0


class Jobs:
    """An empty queue: waiting takes as long as requested."""

    def __init__(self, wall):
        self.wall = wall

    waiting = answered = 0

    def run_pending(self, wait=0.0, budget=math.inf):
        self.wall.time += wait
        return 0


class Robots:
    """One sensor; keeps the steps at which it was due."""

    waits_for_renderer = False

    def __init__(self, rate=0.0):
        self.schedule = Schedule(rate, 0.001) if rate else None
        self.seen, self.applied, self.failures, self.restarts = [], [], [], 0
        self.refreshed = self.prepared = 0

    def apply_commands(self):
        self.applied.append(True)

    def next_due(self):
        return self.schedule.next if self.schedule else math.inf

    def next_watched(self):
        return math.inf, math.inf

    def publish(self, step, _time):
        if self.schedule and self.schedule.due(step):
            self.seen.append(step)

    def refresh(self):
        self.refreshed += 1

    def prepare(self):
        self.prepared += 1

    def restart(self, fresh=True):
        self.restarts += 1
        self.fresh = fresh
        if self.schedule:
            self.schedule.restart(0)

    def reset_models(self):
        self.restarts += 100

    def take_failures(self):
        failures, self.failures = self.failures, []
        return failures


class Rig:
    def __init__(self, cost=1e-5, rate=0.0, clock_rate=200.0, **config):
        self.wall = Wall()
        self.world, self.robots = World(self.wall, cost), Robots(rate)
        self.published = []
        clock = SimClock(
            clock_rate,
            0.001,
            lambda times: self.published.extend((time, self.wall.time) for time in times),
        )
        self.server = Server(
            self.world,
            Jobs(self.wall),
            self.robots,
            Config(niceness=0, clock_rate=clock_rate, **{"real_time_factor": 1.0, **config}),
            clock,
            self.wall.now,
        )

    def run(self, seconds):
        """Run the loop for some wall time."""
        end = self.wall.time + seconds
        while self.wall.time < end:
            self.server.spin_once()

    def run_steps(self, steps):
        """Run the loop until the steps are made."""
        for _ in range(100000):
            if steps.done.is_set():
                return
            self.server.spin_once()
        raise AssertionError("the steps are never made")


@pytest.mark.parametrize("factor", [0.1, 0.5, 1.0, 4.0, 20.0])
def test_the_real_time_factor_is_kept(factor):
    rig = Rig(real_time_factor=factor)
    rig.run(10.0)
    assert rig.world.time == pytest.approx(10.0 * factor, rel=1e-3)
    statistics = rig.server.statistics()
    assert statistics["real_time_factor"] == pytest.approx(factor, rel=0.01)
    assert 0 <= statistics["lateness_p50"] <= statistics["lateness_max"] < 0.002


@pytest.mark.parametrize("factor", [0.0, 1.0])
def test_a_held_world_makes_no_step_for_a_while(factor):
    rig = Rig(real_time_factor=factor)
    rig.run(0.5)
    one, other = rig.server.hold(), rig.server.hold()
    before = rig.world.step_count
    rig.run(0.5)
    rig.server.release(one)
    rig.run(0.5)
    assert rig.world.step_count == before
    rig.server.release(other)
    rig.run(0.5)
    done = rig.world.step_count - before
    assert done == pytest.approx(500, abs=60) if factor else done > 500, "nothing is caught up"
    rig.server.hold()
    before = rig.world.step_count
    rig.run(HOLD_LIMIT + 0.5)
    assert rig.world.step_count > before, "whoever has held it does not respond"
    later = rig.server.hold()
    rig.server.release(later)
    before = rig.world.step_count
    rig.run(0.1)
    assert rig.world.step_count > before, "nor does it hold up those who come later"


def test_holds_that_follow_each_other_stop_time_no_longer_than_one():
    """Eight clients that spawned and deleted models stopped it for as long as they did."""
    rig = Rig()
    hold, steps = rig.server.hold(), []
    for _ in range(60):
        rig.run(0.1)
        hold, before = rig.server.hold(), hold
        rig.server.release(before)
        steps.append(rig.world.step_count)
    longest = max(steps.count(count) for count in steps)
    assert longest * 0.1 == pytest.approx(HOLD_LIMIT, abs=0.25)
    assert steps[-1] == pytest.approx(2 * 1000 * RUN_TIME, abs=110)


def test_steps_on_request_wait_while_a_world_is_held():
    rig = Rig(paused=True)
    hold = rig.server.hold()
    steps = rig.server.begin_steps(5)
    rig.run(0.5)
    assert rig.world.step_count == 0
    rig.server.release(hold)
    rig.run_steps(steps)
    assert rig.world.step_count == 5


def test_running_free_it_runs_as_fast_as_the_steps_allow():
    rig = Rig(real_time_factor=0.0, cost=2e-5)
    rig.run(3.0)
    assert rig.world.time == pytest.approx(3.0 * 0.001 / 2e-5, rel=1e-3)
    assert rig.server.statistics()["real_time_factor"] == pytest.approx(50, rel=0.01)
    statistics = rig.server.statistics()
    assert statistics["batches"] == 0
    assert all(0.0 <= share <= 1.0 for share in statistics["shares"].values())
    assert statistics["shares"]["steps"] > 0.0
    rig.server.set_paused(True)
    assert set(rig.server.statistics()["shares"].values()) == {0.0}


def test_a_slow_world_runs_as_fast_as_it_can_and_reports_its_lateness():
    rig = Rig(real_time_factor=1.0, cost=0.002)
    rig.run(5.0)
    assert rig.world.time == pytest.approx(2.5, rel=0.01)
    assert rig.server.statistics()["real_time_factor"] == pytest.approx(0.5, rel=0.01)
    assert 0.2 < rig.server.statistics()["lateness_max"] < 0.3


def test_after_a_delay_the_pace_restarts():
    rig = Rig(real_time_factor=1.0)
    rig.run(1.0)
    rig.wall.time += 5.0
    before = rig.world.time
    rig.run(1.0)
    assert rig.world.time - before == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("factor", [0.1, 1.0, 4.0, 0.0])
@pytest.mark.parametrize("rate", [30.0, 50.0, 1000.0])
def test_due_steps_are_exact_at_any_pace(factor, rate):
    rig = Rig(real_time_factor=factor, rate=rate)
    while rig.world.time < 2.0:
        rig.server.spin_once()
    expected = [round(k * 1000 / rate) for k in range(1, int(2 * rate) + 1)]
    assert [step for step in rig.robots.seen if step <= 2000] == expected


def test_clock_at_a_pace_comes_at_its_rate():
    rig = Rig(real_time_factor=1.0)
    rig.run(1.0)
    assert [round(time, 9) for time, _ in rig.published[:100]] == [
        pytest.approx(0.005 * k) for k in range(1, 101)
    ]


def test_without_a_rate_every_step_has_its_clock_message_as_in_gazebo():
    rig = Rig(clock_rate=0.0, paused=True)
    rig.run_steps(rig.server.begin_steps(23))
    rig.server.set_paused(False)
    rig.run(0.1)
    rig.server.set_paused(True)
    times = [round(time * 1000) for time, _ in rig.published]
    assert times == sorted(times) and set(times) == set(range(1, times[-1] + 1)), "none is left out"
    assert times[-1] >= 120
    assert len(times) == len(set(times)), "also at a pause none comes twice"
    rig.published.clear()
    rig.server.reset()
    assert rig.published == [], "the next step tells"
    rig.run_steps(rig.server.begin_steps(2))
    assert [round(time, 6) for time, _ in rig.published] == [0.001, 0.002]


@pytest.mark.parametrize(
    "cost, least, most",
    [
        (1e-3, 200, 200),  # real time: every one
        (1e-2, 200, 200),  # slower: every one
        (5e-5, 25, 25),  # 20 times as fast: every 40 ms
        (1e-6, 25, 25),  # 1000 times as fast: by CLOCK_STRIDE, at the end of a batch
        (2e-4, 95, 100),
    ],
)  # 5 times as fast: 500 a wall second are allowed
def test_clock_running_free_is_thinned_by_wall_time(cost, least, most):
    rig = Rig(real_time_factor=0.0, cost=cost)
    while rig.world.time < 5.0:
        rig.server.spin_once()
    times = [time for time, _ in rig.published if time > 1.0]
    assert least <= len(times) / 4.0 <= most + 0.5
    assert all(time * 200 == pytest.approx(round(time * 200), abs=1e-6) for time in times)
    assert max(b - a for a, b in zip(times, times[1:])) <= CLOCK_STRIDE + 0.0001


def test_time_stops_while_paused_and_does_not_catch_up():
    rig = Rig(real_time_factor=1.0, paused=True)
    rig.run(3.0)
    assert rig.world.step_count == 0
    rig.server.set_paused(False)
    rig.run(1.0)
    assert rig.world.time == pytest.approx(1.0, abs=0.01)
    rig.server.set_paused(True)
    assert rig.published[-1][0] == pytest.approx(rig.world.time)
    assert rig.server.statistics()["real_time_factor"] == 0.0


@pytest.mark.parametrize("paused", [False, True])
def test_jobs_that_only_read_cost_no_refresh(paused):
    rig, jobs = Rig(paused=paused), JobQueue()
    rig.server._jobs = jobs

    def refreshes(ask):
        """How often one job of a caller has the robots refreshed."""
        before, caller = rig.robots.refreshed, threading.Thread(target=ask, args=(lambda: 1, 90.0))
        caller.start()
        while caller.is_alive():
            rig.server.spin_once()
        return rig.robots.refreshed - before

    assert [refreshes(ask) for ask in (jobs.read, jobs.call, jobs.read)] == [0, 1, 0]


@pytest.mark.parametrize("count", [1, 7, 20, 1234])
def test_steps_on_request_are_counted_exactly(count):
    rig = Rig(paused=True, rate=50.0)
    steps = rig.server.begin_steps(count)
    rig.run_steps(steps)
    rig.run(0.2)
    assert rig.world.step_count == count and steps.error == ""
    assert rig.robots.seen == list(range(20, count + 1, 20))
    assert rig.published[-1][0] == pytest.approx(0.001 * count)
    times = [round(0.005 * k, 6) for k in range(1, count // 5 + 1)]
    times += [0.001 * count] if count % 5 else []
    assert [time for time, _ in rig.published] == pytest.approx(times), "each time once"


def test_commands_are_applied_before_the_first_step():
    rig = Rig(paused=True)
    order = []
    rig.robots.apply_commands = lambda: order.append(("apply_commands", rig.world.step_count))
    rig.run_steps(rig.server.begin_steps(1))
    assert order == [("apply_commands", 0)]


def test_steps_are_refused_while_it_runs_or_steps_already():
    rig = Rig()
    with pytest.raises(WorldError, match="pause it before stepping"):
        rig.server.begin_steps(1)
    rig.server.set_paused(True)
    steps = rig.server.begin_steps(5)
    with pytest.raises(WorldError, match="5 steps of another call"):
        rig.server.begin_steps(1)
    rig.run_steps(steps)
    assert rig.world.step_count == 5


@pytest.mark.parametrize(
    "interrupt, reason",
    [
        (lambda server: server.reset(), "was reset"),
        (lambda server: server.set_paused(False), "resumed"),
        (lambda server: server.set_paused(True), "paused"),
    ],
)
def test_interrupted_steps_report_the_reason(interrupt, reason):
    rig = Rig(paused=True)
    steps = rig.server.begin_steps(10000)
    rig.server.spin_once()
    assert rig.robots.waits_for_renderer
    interrupt(rig.server)
    assert steps.done.is_set() and reason in steps.error
    assert not rig.robots.waits_for_renderer


def test_missing_images_make_the_step_fail():
    rig = Rig(paused=True)
    rig.robots.failures = ["from before"]
    steps = rig.server.begin_steps(1)
    rig.robots.failures = ["no image of cam", "at all"]
    rig.run_steps(steps)
    assert steps.error == "no image of cam; at all"


def test_lockstep_refuses_to_run_by_itself():
    rig = Rig(paused=True, lockstep=True)
    with pytest.raises(WorldError, match="only by /gazebo/step"):
        rig.server.set_paused(False)
    rig.server.set_paused(True)
    rig.run(1.0)
    assert rig.world.step_count == 0


def test_reset_of_the_models_lets_all_else_go_on():
    rig = Rig()
    rig.run(1.0)
    before, published = rig.world.time, len(rig.published)
    rig.server.reset_models()
    assert rig.world.calls == ["reset_models"] and rig.robots.restarts == 100
    assert (rig.world.time, len(rig.published)) == (before, published)


@pytest.mark.parametrize("lockstep", [False, True])
@pytest.mark.parametrize("monotonic, expected", [(False, True), (True, False)])
def test_reset(monotonic, expected, lockstep):
    rig = Rig(monotonic_clock=monotonic, lockstep=lockstep, paused=lockstep)
    rig.run(1.0)
    before = rig.world.time
    rig.server.reset()
    fresh = ["sort_models", ("reset", expected)]
    assert rig.world.calls == (fresh if lockstep else [("start_over", expected)])
    assert (rig.robots.restarts, rig.robots.fresh) == (1, lockstep)
    told = 0.0 if expected and lockstep else before
    assert rig.published[-1][0] == pytest.approx(told, abs=0.005), "else the next step tells"
    rig.run(1.0)
    further = 0.0 if lockstep else 1.0
    assert rig.world.time == pytest.approx((0.0 if expected else before) + further, abs=0.01)


def test_a_restart_is_as_after_a_new_start():
    rig = Rig()
    rig.run(1.0)
    rig.server.reset(fresh=True)
    assert rig.world.calls == ["sort_models", ("reset", True)]
    assert (rig.robots.restarts, rig.robots.fresh) == (1, True)


class Reporter:
    """Due at every 7th step."""

    watches = False

    def __init__(self):
        self.schedule, self.seen, self.restarts = Schedule(1000 / 7, 0.001), [], 0

    def next_due(self):
        return self.schedule.next

    def publish(self, step, time):
        if self.schedule.due(step):
            self.seen.append((step, round(time, 6)))

    def restart(self):
        self.restarts += 1
        self.schedule.restart(0)


def test_reporters_are_called_at_their_steps():
    rig = Rig(paused=True)
    reporter = Reporter()
    rig.server.add_reporter(reporter)
    rig.run_steps(rig.server.begin_steps(21))
    assert reporter.seen == [(7, 0.007), (14, 0.014), (21, 0.021)]
    rig.server.reset()
    assert reporter.restarts == 1


def test_the_process_time_is_the_published_time(monkeypatch):
    own = []
    published = []
    clock = SimClock(200.0, 0.001, published.extend, own.append)
    clock.publish(1.25)
    assert [time.to_sec() for time in own] == [1.25] == published
    monkeypatch.setattr(clock_module.rospy.rostime, "_rostime_initialized", True)
    monkeypatch.setattr(clock_module.rospy.rostime, "_rostime_current", None)
    clock_module.set_process_time(own[0])
    assert clock_module.rospy.get_time() == 1.25


@pytest.mark.parametrize("ending", [True, False])
def test_topics_that_a_shutdown_closes_during_a_batch_end_the_loop(monkeypatch, ending):
    rig = Rig()

    def publish(_step, _time):
        raise rospy.ROSException("publish() to a closed topic")

    rig.robots.publish = publish
    monkeypatch.setattr(rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: ending)
    if ending:
        rig.server.run()
    else:
        with pytest.raises(rospy.ROSException):
            rig.server.run()

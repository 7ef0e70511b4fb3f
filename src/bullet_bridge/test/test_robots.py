"""Outputs and controls of models: when they are updated, spawns and deletions."""

import logging
from types import SimpleNamespace

import pytest
from bullet_bridge.robots import Robots
from bullet_sim.parts.schedule import SubscribedSchedule

from bullet_bridge import robots
from bullet_bridge import robots as module


class Spec(SimpleNamespace):
    topic, link = "/topic", "base"


class Part:
    """Stands in for a sensor: stores the times of its updates."""

    always = watches = tells_velocities = goes_on = False

    def __init__(self, context):
        spec, world = context.spec, context.world
        if spec.rate is None:
            raise ValueError("bad sensor")
        if spec.rate < 0:
            raise OverflowError("too large")
        self.world, self.model, self.spec, self.seed = world, context.model, spec, context.seed
        self.schedule = SubscribedSchedule(spec.rate, 0.001, world.step_count, self.needs_update)
        self.times, self.subscribed, self.closed, self.restarts = [], True, False, 0
        self.updated, self.error, self.prepared = 0.0, None, []
        self.resets_with_model, self.waits = spec.rate == 100, spec.rate == 25

    def needs_update(self):
        return self.subscribed

    def update(self, time, period):
        if self.error is not None:
            raise self.error
        self.times.append(time)
        assert period > 0.0

    def prepare(self):
        self.prepared.append(self.world.step_count)

    def on_time_step(self):
        self.schedule.set_step(self.world.time_step, self.spec.rate, self.world.step_count)

    def go_back(self, _time):
        if not self.waits:
            self.schedule.restart(0)

    def is_message(self, step):
        return step % 40 == 0 or self.spec.rate != 200

    def reset(self, _time):
        self.restarts += 1
        self.updated = 0.0
        self.schedule.restart(0)

    def close(self):
        self.closed = True


class Rig:
    def __init__(self, monkeypatch):
        self.made, self.errors, self.before_register = [], [], lambda: None

        def make(context, _kind=None):
            self.made.append(Part(context))
            return self.made[-1]

        monkeypatch.setattr(module, "make_plugin", make)
        monkeypatch.setattr(
            module.rospy, "logerr", lambda text, *rest: self.errors.append(text % rest)
        )
        monkeypatch.setattr(
            module.rospy, "logerr_throttle", lambda _, text, *__: self.errors.append(text)
        )
        self.world = SimpleNamespace(
            models={}, step_count=0, time_step=0.001, time=0.0, name="w", sources=lambda: []
        )
        self.camera_restarts = []
        cameras = SimpleNamespace(
            set_sources=lambda _: None,
            take_failures=lambda: ["dark"],
            restart=lambda: self.camera_restarts.append(True),
            flush=lambda *_: None,
        )
        self.robots = Robots(SimpleNamespace(call=self.call), self.world, cameras, seed=3)

    def call(self, job):
        """Run it, after what comes before it."""
        self.before_register()
        return job()

    def model(self, name, *rates):
        """A model with sensors of these rates [Hz], connected."""
        model = SimpleNamespace(
            name=name,
            manager=None,
            description=SimpleNamespace(
                log_level="",
                warnings=[],
                sensors=[Spec(rate=rate, name=f"s{rate}") for rate in rates],
            ),
        )
        self.world.models[name] = model
        self.robots.connect(model)
        return model

    def run(self, steps):
        """Run as Server does, from due step to due step; returns the due steps."""
        due = []
        while self.world.step_count < steps:
            self.world.step_count = step = min(steps, self.robots.next_due())
            self.robots.publish(step, step * 0.001)
            due.append(step)
        return due


@pytest.fixture(name="rig")
def _rig(monkeypatch):
    return Rig(monkeypatch)


def test_outputs_are_updated_when_due_and_nothing_else_stops_a_batch(rig):
    rig.model("a", 100, 40)
    assert rig.run(100) == [10, 20, 25, 30, 40, 50, 60, 70, 75, 80, 90, 100]
    assert rig.made[0].times == pytest.approx([0.01 * k for k in range(1, 11)])
    assert rig.made[1].times == pytest.approx([0.025, 0.05, 0.075, 0.1])


def test_a_plugin_sets_the_level_of_the_log(rig):
    log = logging.getLogger("rosout")
    before = log.level
    try:
        log.setLevel("INFO")
        model = rig.model("a", 100)
        assert log.level == logging.INFO
        model.description.log_level = "DEBUG"
        rig.robots.connect(model)
        assert log.level == logging.DEBUG
    finally:
        log.setLevel(before)


def test_without_models_nothing_is_due(rig):
    rig.robots.refresh()
    assert rig.run(50) == [20, 40, 50]


def test_no_subscriber_no_work(rig):
    rig.model("a", 100)
    rig.made[0].subscribed = False
    rig.robots.refresh()
    rig.run(50)
    assert rig.made[0].times == [] and rig.robots.sensor_counts() == {}
    rig.made[0].subscribed = True
    rig.robots.refresh()
    rig.run(100)
    assert rig.made[0].times == pytest.approx([0.06, 0.07, 0.08, 0.09, 0.1])
    assert rig.robots.sensor_counts() == {"w::a::base::s100": 5}


def test_without_subscribers_no_batch_ends_and_a_late_subscriber_gets_the_same_times(
    rig, monkeypatch
):
    monkeypatch.setattr(robots, "CHECK_GAP", 0.0)
    rig.model("a", 1000, 30)
    for part in rig.made:
        part.subscribed = False
    rig.robots.refresh()
    assert rig.run(100) == [20, 40, 60, 80, 100]
    rig.made[1].subscribed = True
    assert rig.run(200) == [120, 133, 153, 167, 187, 200]
    assert rig.made[0].times == []
    assert rig.made[1].times == pytest.approx([0.133, 0.167, 0.2])


def test_subscribers_are_checked_at_most_once_per_check_gap_of_wall_time(rig, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(robots.wall, "monotonic", lambda: now[0])
    rig.model("a", 100)
    rig.made[0].subscribed = False
    rig.robots.refresh()
    rig.made[0].subscribed = True
    assert rig.run(100) == [20, 40, 60, 80, 100]
    now[0] += 1.1 * robots.CHECK_GAP
    assert rig.run(160) == [120, 130, 140, 150, 160]
    assert rig.made[0].times == pytest.approx([0.13, 0.14, 0.15, 0.16])


def test_models_come_and_go(rig):
    rig.model("a", 100)
    rig.run(20)
    rig.model("b", 50)
    rig.run(40)
    del rig.world.models["a"]
    gone = rig.robots.disconnect("a")
    assert gone == [rig.made[0]]
    rig.run(100)
    assert len(rig.made[0].times) == 4
    assert rig.made[1].times == pytest.approx([0.04, 0.06, 0.08, 0.1])


@pytest.mark.parametrize("rate, reason", [(None, "bad sensor"), (-1, "too large")])
def test_a_sensor_that_cannot_work_is_skipped(rig, rate, reason):
    rig.model("a", rate, 50)
    assert rig.run(20) == [20] and len(rig.made) == 1
    assert rig.errors == [f"model 'a': sensor on /topic is left out: {reason}"]


@pytest.mark.parametrize("error", [OSError("no master"), KeyboardInterrupt()])
def test_a_failed_spawn_closes_everything(rig, error):
    def refuse():
        raise error

    rig.before_register = refuse
    with pytest.raises(type(error)):
        rig.model("a", 50, 100)
    assert [part.closed for part in rig.made] == [True, True]


def test_a_plugin_that_raises_is_switched_off_until_the_reset_and_the_others_go_on(rig):
    rig.model("a", 50, 100)
    rig.run(20)
    rig.made[0].error = KeyError("speed")
    rig.run(60)
    (text,) = rig.errors
    assert "model 'a', sensor on /topic: is switched off" in text and "KeyError: 'speed'" in text
    rig.made[0].error = None
    assert len(rig.made[0].times) == 1 and len(rig.made[1].times) == 6
    rig.world.step_count = 0
    rig.robots.restart()
    rig.run(40)
    assert len(rig.made[0].times) == 3


def test_a_model_deleted_during_its_spawn_leaves_nothing(rig):
    rig.before_register = rig.world.models.clear
    rig.model("a", 50, 100)
    assert [part.closed for part in rig.made] == [True, True]
    rig.run(50)
    assert [part.times for part in rig.made] == [[], []]


def test_seeds_depend_on_model_and_place_and_stay(rig):
    rig.model("a", 50, 100)
    rig.model("b", 50)
    seeds = [part.seed for part in rig.made]
    assert len(set(seeds)) == 3
    rig.robots.disconnect("a")
    rig.model("a", 50, 100)
    assert [part.seed for part in rig.made[3:]] == seeds[:2]


def test_restart_reaches_all_and_starts_the_schedules_over(rig):
    rig.model("a", 50)
    rig.run(110)
    rig.world.step_count = 0
    rig.robots.restart()
    assert (rig.made[0].restarts, rig.robots.next_due()) == (1, 20)
    assert rig.made[0].prepared == [0, 0]
    assert rig.camera_restarts == [True]


def test_a_restart_that_is_not_fresh_leaves_the_commands_of_plugins_without_a_reset(rig):
    rig.model("a", 50, 100)
    rig.run(110)
    rig.world.step_count = 0
    rig.robots.restart(fresh=False)
    assert [part.restarts for part in rig.made] == [0, 1]
    assert [part.prepared for part in rig.made] == [[0], [0, 0]]
    assert rig.robots.next_due() == 10, "both start their schedules over"


def test_what_waits_for_its_time_is_silent_until_then_but_after_a_new_start(rig):
    rig.model("a", 25)
    rig.run(110)
    for fresh, dues in ((False, [120, 160, 200]), (True, [40, 80, 120, 160, 200])):
        rig.world.step_count = 0
        rig.robots.restart(fresh=fresh)
        rig.made[0].times.clear()
        rig.run(210)
        assert [round(1000 * time) for time in rig.made[0].times] == dues
        rig.run(110)


def test_updates_that_publish_nothing_count_as_no_message(rig):
    rig.model("a", 200)
    rig.run(200)
    assert len(rig.made[0].times) == 40
    assert list(rig.robots.sensor_counts().values()) == [5]


def test_a_reset_of_the_models_reaches_plugins_that_have_one(rig):
    rig.model("a", 50, 100)
    rig.run(110)
    rig.robots.reset_models()
    assert [part.restarts for part in rig.made] == [0, 1]
    assert rig.camera_restarts == [] and [part.prepared for part in rig.made] == [[0], [0]]


def test_a_restart_drops_the_counts_of_commands(rig):
    rig.robots.received.add("/cmd")
    rig.robots.received.count("/cmd")
    rig.robots.restart()
    with pytest.raises(TimeoutError, match="/cmd: 0 of 1"):
        rig.robots.received.take({"/cmd": 1}, 0.0)


def test_failures_of_images_are_returned(rig):
    assert rig.robots.take_failures() == ["dark"]


class Control:
    during_init = error = None

    def __init__(self, _jobs, _world, model, namespace, _received, run):
        self.model, self.namespace, self.closed, self.closed_here = model, namespace, False, False
        self.run = run
        during_init, Control.during_init = Control.during_init, None
        if during_init is not None:
            during_init()

    def refresh(self):
        """Nothing to update."""

    on_time_step = refresh

    def schedules(self):
        """Every 10 steps."""
        return [(False, SubscribedSchedule(100, 0.001, 0, lambda: True))]

    def publish(self, step, _time):
        if self.error is not None:
            raise self.error
        self.published = step

    def close(self):
        self.closed_here = True


@pytest.fixture(name="spawn")
def _spawn(rig, monkeypatch):
    """Function that spawns a model with controllers in the namespace /n."""
    monkeypatch.setattr(module, "RobotControl", Control)
    monkeypatch.setattr(Control, "during_init", None)

    def spawn(name, *sensors, namespace="/n/"):
        model = SimpleNamespace(
            name=name,
            manager=True,
            description=SimpleNamespace(
                log_level="", warnings=[], sensors=sensors, control_namespace=""
            ),
        )
        rig.world.models[name] = model
        rig.robots.connect(model, namespace)

    return spawn


def test_plugins_are_ready_in_the_step_in_which_the_hardware_layer_is(rig, spawn, monkeypatch):
    jobs = []
    monkeypatch.setattr(rig.robots._jobs, "call", lambda work: jobs.append(work) or work())

    def gains_come_into_force():
        assert not rig.made[0].prepared
        rig.made[0].prepared.append("hardware")

    class WithHardware(Control):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            self.run(gains_come_into_force)
            assert len(jobs) == 1 and rig.made[0].prepared == ["hardware", 0]

    monkeypatch.setattr(module, "RobotControl", WithHardware)
    spawn("bot", Spec(rate=50))
    assert rig.made[0].prepared == ["hardware", 0, 0] and not rig.errors


def test_of_two_simultaneous_spawns_in_one_namespace_the_second_has_no_controllers(rig, spawn):
    Control.during_init = lambda: spawn("second")
    spawn("first")
    assert list(rig.robots._controls) == ["first"]
    assert len(rig.errors) == 1 and "model 'second' has no controllers: 'first'" in rig.errors[0]


def test_a_namespace_is_free_again_after_a_deletion_or_a_failed_spawn(rig, spawn):
    spawn("a")
    del rig.world.models["a"]
    (gone,) = rig.robots.disconnect("a")
    assert gone.closed
    rig.before_register = rig.world.models.clear
    spawn("b")
    rig.before_register = lambda: None

    def refuse():
        raise OSError("no master")

    Control.during_init = refuse
    with pytest.raises(OSError):
        spawn("c")

    def taken():
        raise module.rospy.ServiceException("taken")

    Control.during_init = taken
    spawn("d")
    assert rig.errors == ["model 'd' has no controllers: taken"]
    spawn("e")
    assert list(rig.robots._controls) == ["e"] and len(rig.errors) == 1


@pytest.mark.parametrize("error", [ValueError("no rotation"), OverflowError("too much")])
def test_a_controller_that_cannot_be_published_stops_no_other(rig, spawn, error):
    for name in ("a", "b"):
        spawn(name, namespace=f"/{name}/")
    first, second = rig.robots._controls.values()
    first.error = error
    rig.robots.publish(10, 0.01)
    assert second.published == 10
    (text,) = rig.errors
    assert "'a'" in text and str(error) in text

"""Controllers: their configuration and their life cycles, on fake joints."""

import dataclasses
import math
from typing import Any, ClassVar

import pytest
from bullet_sim.controllers import CONTROLLERS, Controller, ControllerConfig, configure
from bullet_sim.controllers.base import INTERFACES
from bullet_sim.controllers.manager import INITIALIZED, RUNNING, STOPPED, Manager
from bullet_sim.controllers.pid import PidConfig, parse_pid
from bullet_sim.description.model import Joint, ModelDescription
from bullet_sim.description.transmissions import Transmission, Transmissions
from bullet_sim.errors import CommandError, ControllerError
from fake_joints import FakeJoints, limited_effort

STATE = "joint_state_controller/JointStateController"
VELOCITY = "velocity_controllers/JointVelocityController"
GROUP = "velocity_controllers/JointGroupVelocityController"
POSITION = "position_controllers/JointPositionController"
EFFORT = "effort_controllers/JointEffortController"
EFFORT_GROUP = "effort_controllers/JointGroupEffortController"
EFFORT_POSITION = "effort_controllers/JointPositionController"
EFFORT_GROUP_POSITION = "effort_controllers/JointGroupPositionController"
EFFORT_VELOCITY = "effort_controllers/JointVelocityController"
VELOCITY_POSITION = "velocity_controllers/JointPositionController"
JOINTS = ("left", "right")


class Recorded(FakeJoints):
    """Joints at 0.25 rad that record what they are told."""

    names = JOINTS
    limits = {name: Joint(name, "continuous", "base", name, effort=10.0) for name in JOINTS}

    def __init__(self):
        super().__init__()
        self.calls = []
        self.positions = dict.fromkeys(JOINTS, 0.25)

    def apply_efforts(self, handles, computes=False):
        """Record, within the limits."""
        efforts = {handle.name: limited_effort(handle)[0] for handle in handles}
        self.calls.append(("effort", efforts))

    def drive_velocities(self, names, values):
        """Record."""
        self.calls.append(("velocity", tuple(names), tuple(values)))

    def drive_positions(self, names, values):
        """Record."""
        self.calls.append(("position", tuple(names), tuple(values)))

    def release(self, names):
        """Record."""
        self.calls.append(("release", tuple(names)))


@pytest.fixture(name="joints")
def _joints():
    return Recorded()


@pytest.fixture(name="manager")
def _manager(joints):
    manager = Manager(joints)
    manager.load("speed", {"type": VELOCITY, "joint": "left"})
    manager.load("angle", {"type": POSITION, "joint": "left"})
    manager.load("other", {"type": VELOCITY, "joint": "right"})
    manager.load("state", {"type": STATE, "publish_rate": 10})
    return manager


def states(manager):
    """Map of name -> state."""
    return {config.name: state for _, config, state in manager.list()}


BAD = [
    (None, ["None", "mapping"]),
    ({}, ["type 'None'", VELOCITY]),
    ({"type": "x/Y"}, ["type 'x/Y'", "must be one of", STATE, GROUP]),
    ({"type": ["x"]}, ["type '['x']'", "must be one of"]),
    ({"type": VELOCITY}, ["joint None", "a joint name"]),
    ({"type": VELOCITY, "joint": "nose"}, ["joint 'nose'", "joints are left, right"]),
    ({"type": GROUP, "joints": "left"}, ["joints 'left'", "a list"]),
    ({"type": GROUP, "joints": []}, ["joints []", "a list"]),
    ({"type": GROUP, "joints": ["left", "nose"]}, ["joint 'nose'"]),
    ({"type": VELOCITY, "joint": "left", "interface_name": "effort"}, ["'effort'", "'velocity'"]),
    ({"type": VELOCITY, "joint": "left", "pid": 3}, ["pid is 3", "mapping"]),
    ({"type": VELOCITY, "joint": "left", "pid": {"i": 1}}, ["no p"]),
    ({"type": VELOCITY, "joint": "left", "pid": {"p": "high"}}, ["pid p is 'high'", "finite"]),
    ({"type": VELOCITY, "joint": "left", "pid": {"p": 1, "d": math.nan}}, ["pid d is nan"]),
    ({"type": STATE}, ["Parameter 'publish_rate' not set", "'c'"]),
    ({"type": STATE, "publish_rate": 0}, ["publish_rate 0", "above 0"]),
    ({"type": STATE, "publish_rate": "fast"}, ["publish_rate 'fast'"]),
    ({"type": STATE, "publish_rate": True}, ["publish_rate True"]),
    ({"type": STATE, "publish_rate": 10**400}, ["publish_rate 1000"]),
    ({"type": STATE, "publish_rate": 50, "joints": ["nose"]}, ["joint 'nose'"]),
    ({"type": GROUP, "joints": ["left", "right", "left"]}, ["joint 'left' twice"]),
    ({"type": EFFORT_GROUP, "joints": ["left", "left"]}, ["joint 'left' twice"]),
    ({"type": EFFORT_POSITION, "joint": "left"}, ["has no pid", EFFORT_POSITION]),
    ({"type": EFFORT_VELOCITY, "joint": "left", "pid": {"i": 1}}, ["no p"]),
    ({"type": VELOCITY_POSITION, "joint": "left", "pid": {"p": "1.x"}}, ["pid p is '1.x'"]),
    (
        {"type": EFFORT_POSITION, "joint": "left", "pid": {"p": 1e308}},
        ["pid p is 1e+308", "to 1e+15"],
    ),
    (
        {"type": EFFORT_POSITION, "joint": "left", "pid": {"p": 1, "antiwindup": 3}},
        ["antiwindup is 3", "true or false"],
    ),
    (
        {"type": EFFORT_GROUP_POSITION, "joints": ["left", "right"], "left": {"pid": {"p": 1}}},
        ["controller 'c' right has no pid"],
    ),
    ({"type": STATE, "publish_rate": 50, "joints": 3}, ["joints 3", "a list"]),
]


@pytest.mark.parametrize("config, parts", BAD, ids=[" ".join(p) for _, p in BAD])
def test_bad_configurations_are_refused_by_name(config, parts):
    with pytest.raises(ControllerError) as error:
        configure("c", config, JOINTS)
    for part in ["controller 'c'", *parts]:
        assert part in str(error.value)


UNKNOWN = [
    ({"type": VELOCITY, "joint": "left", "gain": 1}, "controller 'c' has key 'gain'"),
    ({"type": VELOCITY, "joint": "left", "pid": {"p": 1, "q": 1}}, "pid has key 'q'"),
    ({"type": STATE, "publish_rate": 50, 1: 2}, "key '1'"),
    ({"type": STATE, "publish_rate": 50, "joint": "left"}, "key 'joint'"),
    (
        {"type": STATE, "publish_rate": 50, "extra_joints": [{"name": "x", "speed": 1}]},
        "#0 has key 'speed'",
    ),
    (
        {"type": STATE, "publish_rate": 50, "extra_joints": 3},
        "extra_joints 3, must be a list; it is ignored",
    ),
    (
        {"type": STATE, "publish_rate": 50, "extra_joints": [{"position": 1}]},
        "#0 has name None, must be a name; it",
    ),
    (
        {"type": STATE, "publish_rate": 50, "extra_joints": [{"name": "x", "effort": "a"}]},
        "effort 'a', must be a",
    ),
    (
        {"type": STATE, "publish_rate": 50, "extra_joints": [{"name": "x"}, {"name": "x"}]},
        "'x' a second time",
    ),
    (
        {"type": EFFORT_GROUP_POSITION, "joints": ["left"], "left": {"pid": {"p": 1}, "gear": 2}},
        "controller 'c' left has key 'gear'",
    ),
]


def test_extra_joints_that_are_usable_stay():
    extra = [{"name": "x", "position": 1.5}, 3, {"name": "x", "position": 2.0}, {"name": "y"}]
    extra.append({"name": "z", "position": 1})  # upstream wants doubles
    _, config = configure("c", {"type": STATE, "publish_rate": 50, "extra_joints": extra}, JOINTS)
    assert config.extra_joints == (("x", 1.5, 0.0, 0.0), ("y", 0.0, 0.0, 0.0))
    assert len(config.warnings) == 3
    assert "Extra joint 'z' does not specify a valid default position" in config.warnings[2]


@pytest.mark.parametrize("config, text", UNKNOWN, ids=[text for _, text in UNKNOWN])
def test_unknown_keys_are_one_warning_each_and_the_rest_counts(config, text):
    _, config = configure("c", config, JOINTS)
    assert len(config.warnings) == 1 and text in config.warnings[0]


def test_gains_may_be_texts_of_numbers():
    gains = parse_pid({"p": "1e0", "i_clamp": "2.5e1"}, "c")
    assert (gains.p, gains.i_clamp_min, gains.i_clamp_max) == (1.0, -25.0, 25.0)


def test_unused_pid_is_said():
    _, config = configure("c", {"type": VELOCITY, "joint": "left", "pid": {"p": 1}}, JOINTS)
    assert config.gains == () and "controller 'c': pid is accepted and not used" in config.notes[0]


def test_types_and_interfaces():
    assert len(CONTROLLERS.names()) == 22
    interface = CONTROLLERS.find(VELOCITY).interface
    assert INTERFACES[interface] == "hardware_interface::VelocityJointInterface"


def test_list_keeps_the_order_of_loading(manager):
    assert list(states(manager)) == ["speed", "angle", "other", "state"]
    assert set(states(manager).values()) == {INITIALIZED}


def test_loading_twice_is_refused_and_the_first_stays(manager):
    with pytest.raises(ControllerError, match="A controller named 'speed' was already loaded"):
        manager.load("speed", {"type": POSITION, "joint": "right"})
    assert manager.list()[0][1].type == VELOCITY


def test_unload(manager):
    manager.switch(["speed"], [])
    with pytest.raises(ControllerError, match="with name 'speed' because it is still running"):
        manager.unload("speed")
    with pytest.raises(ControllerError, match="'gone' because no controller .* loaded are speed"):
        manager.unload("gone")
    manager.switch([], ["speed"])
    manager.unload("speed")
    assert "speed" not in states(manager)


def test_start_and_stop(manager, joints):
    manager.switch(["speed", "state"], [])
    assert joints.calls == [("velocity", ("left",), (0,))]
    assert states(manager)["state"] == RUNNING
    manager.command("speed", [3.0])
    manager.switch([], ["speed"])
    assert joints.calls[-1] == ("velocity", ("left",), (3.0,)), "it keeps its last speed"
    assert states(manager)["speed"] == STOPPED


def test_position_controller_starts_where_the_joint_is(manager, joints):
    manager.switch(["angle"], [])
    assert joints.calls == [("position", ("left",), (0.25,))]


def test_swap_of_two_controllers_on_one_joint(manager, joints):
    manager.switch(["speed"], [])
    joints.calls.clear()
    assert manager.switch(["angle"], ["speed"]) == []
    assert (states(manager)["speed"], states(manager)["angle"]) == (STOPPED, RUNNING)
    assert joints.calls == [("position", ("left",), (0.25,))]


@pytest.mark.parametrize(
    "start, stop, reason",
    [
        (
            ["other", "angle"],
            [],
            r"Could not switch controllers, due to resource conflict: Resource conflict on "
            r"\[left\].  Controllers = \[speed, angle, \]",
        ),
        (["other", "gone"], ["speed"], "Could not start controller with name 'gone' because no"),
        (["gone"], ["lost"], "Could not stop controller with name 'lost' because no"),
        (["other"], ["speed", "angle"], "Could not stop controller 'angle' since it is not runn"),
        (["other", "speed"], [], "Controller 'speed' is already running"),
    ],
)
def test_strict_switch_refuses_all_with_a_reason(manager, joints, start, stop, reason):
    manager.switch(["speed"], [])
    before, calls = states(manager), list(joints.calls)
    with pytest.raises(ControllerError, match=reason):
        manager.switch(start, stop, strict=True)
    assert (states(manager), joints.calls) == (before, calls)


def test_a_controller_that_claims_a_joint_twice_cannot_start(manager):
    controller = manager.get("speed")
    claims = (("velocity", ("left",)), ("effort", ("left",)))
    controller.config = dataclasses.replace(controller.config, claims=claims)
    with pytest.raises(ControllerError, match=r"conflict on \[left\].*speed, speed, \]"):
        manager.switch(["speed"], [])
    with pytest.raises(ControllerError, match=r"\[left\]"):
        manager.switch(["speed", "other"], [], strict=False)
    assert RUNNING not in states(manager).values(), "a conflict refuses all, as upstream"


def test_two_rivals_in_one_switch_are_refused(manager):
    for strict in (True, False):
        with pytest.raises(ControllerError, match="speed, angle"):
            manager.switch(["speed", "angle"], [], strict=strict)
        assert RUNNING not in states(manager).values()


def test_a_running_controller_does_not_start_and_stop_at_once(manager):
    manager.switch(["speed"], [])
    for strict in (True, False):
        with pytest.raises(ControllerError, match="'speed' because of conflicting switching"):
            manager.switch(["speed", "other"], ["speed"], strict=strict)
    assert states(manager)["speed"] == RUNNING and states(manager)["other"] != RUNNING


def test_best_effort_starts_a_running_controller_anew(manager, joints):
    """As upstream, whose startRequest() knows no state in which it does nothing."""
    manager.switch(["speed"], [])
    manager.command("speed", [3.0])
    assert manager.switch(["speed"], [], strict=False) == []
    assert joints.calls[-2:] == [("velocity", ("left",), (3.0,)), ("velocity", ("left",), (0,))]
    assert states(manager)["speed"] == RUNNING


def test_best_effort_switch_leaves_out_what_does_not_fit(manager):
    manager.switch(["speed"], [])
    reasons = manager.switch(["speed", "other", "gone"], ["state"], strict=False)
    assert states(manager) == {
        "speed": RUNNING,
        "angle": INITIALIZED,
        "other": RUNNING,
        "state": INITIALIZED,
    }
    assert len(reasons) == 2
    for name in ("gone", "state"):
        assert any(f"'{name}'" in reason for reason in reasons)


def test_commands_of_the_wrong_length_to_nobody_and_to_a_stopped_one(manager, joints):
    with pytest.raises(CommandError, match="has 2 values, must have 1"):
        manager.command("speed", [1, 2])
    with pytest.raises(ControllerError, match="'gone' because no controller with this name"):
        manager.command("gone", [1])
    manager.command("speed", [1])
    assert joints.calls == []


def test_group_drives_its_joints_in_its_order(joints):
    manager = Manager(joints)
    manager.load("all", {"type": GROUP, "joints": ["right", "left"]})
    manager.switch(["all"], [])
    manager.command("all", [1, 2])
    assert joints.calls[-2:] == [("velocity", ("right",), (1,)), ("velocity", ("left",), (2,))]


def test_restart_forgets_commands(manager, joints):
    manager.switch(["speed"], [])
    manager.command("speed", [5])
    manager.restart()
    assert joints.calls[-1] == ("velocity", ("left",), (0,))
    assert states(manager)["speed"] == RUNNING


def test_effort_is_given_before_every_step_also_after_the_stop(joints):
    manager = Manager(joints)
    manager.load("push", {"type": EFFORT, "joint": "left"})
    assert not manager.periodic
    manager.switch(["push"], [])
    assert manager.periodic and joints.calls == [("release", ("left",))]
    manager.command("push", [4.0])
    manager.update(0.001)
    manager.update(0.001)
    assert joints.calls[-2:] == [("effort", {"left": 4.0})] * 2
    manager.command("push", [40.0])
    manager.update(0.001)
    assert joints.calls[-1] == ("effort", {"left": 10.0})
    manager.switch([], ["push"])
    manager.update(0.001)
    assert manager.periodic and joints.calls[-1] == ("effort", {"left": 10.0})


@pytest.mark.parametrize(
    "kind, command, effort",
    [
        (EFFORT_POSITION, 0.75, 2.0 * (0.75 - 0.25)),
        (EFFORT_VELOCITY, 3.0, 2.0 * 3.0),
    ],
)
def test_pid_controllers_give_gain_times_error(joints, kind, command, effort):
    manager = Manager(joints)
    manager.load("arm", {"type": kind, "joint": "left", "pid": {"p": 2.0}})
    manager.switch(["arm"], [])
    manager.update(0.001)
    assert joints.calls[-1] == ("effort", {"left": 0.0})
    manager.command("arm", [command])
    manager.update(0.001)
    assert joints.calls[-1][1]["left"] == pytest.approx(effort)
    sample = manager.get("arm").sample
    assert (sample.set_point, sample.time, sample.period) == (command, 0.001, 0.001)


def test_velocity_from_a_position_pid(joints):
    manager = Manager(joints)
    manager.load("arm", {"type": VELOCITY_POSITION, "joint": "left", "pid": {"p": 2.0}})
    manager.switch(["arm"], [])
    manager.command("arm", [0.75])
    manager.update(0.001)
    assert ("velocity", ("left",), (1.0,)) in joints.calls


def test_group_of_position_pids_has_gains_a_joint(joints):
    manager = Manager(joints)
    manager.load(
        "arms",
        {
            "type": EFFORT_GROUP_POSITION,
            "joints": ["right", "left"],
            "right": {"pid": {"p": 1.0}},
            "left": {"pid": {"p": 3.0}},
        },
    )
    manager.switch(["arms"], [])
    manager.command("arms", [1.25, 1.25])
    manager.update(0.001)
    assert joints.calls[-1] == ("effort", {"right": 1.0, "left": 3.0})


def test_a_reset_of_its_model_makes_the_next_period_as_long_as_the_time(joints):
    """gazebo_ros_control then takes the update before for one at zero; nothing is restarted, and
    what counts periods, as a trajectory's uptime, jumps ahead."""
    manager = Manager(joints, ModelDescription("bot", control_period=0.004))
    manager.load("arm", {"type": EFFORT_VELOCITY, "joint": "left", "pid": {"p": 1.0}})
    manager.switch(["arm"], [])
    seen = []
    manager._updates = [lambda time, period: seen.append((round(time, 6), round(period, 6)))]
    for _ in range(10):
        manager.update(0.001)
    manager.forget_updates(2.0)
    for _ in range(5):
        manager.update(0.001)
    assert seen == [(0.0, 0.001), (0.004, 0.004), (0.008, 0.004), (2.01, 2.0), (2.014, 0.004)]


def test_control_period_updates_seldom_and_holds_the_effort(joints):
    description = ModelDescription("bot", control_period=0.004)
    manager = Manager(joints, description)
    manager.load("arm", {"type": EFFORT_VELOCITY, "joint": "left", "pid": {"p": 1.0}})
    manager.switch(["arm"], [])
    times = []
    for step in range(9):
        manager.command("arm", [float(step)])
        manager.update(0.001)
        times.append((manager.get("arm").sample.time, joints.calls[-1][1]["left"]))
    held = [(0.0, 0.0)] * 4 + [(0.004, 4.0)] * 4 + [(0.008, 8.0)]
    assert [(round(t, 9), effort) for t, effort in times] == held
    assert manager.get("arm").sample.period == pytest.approx(0.004)


def test_gains_of_a_joint_turn_its_velocity_command_into_an_effort(joints, manager):
    manager.hardware.set_gains("left", parse_pid({"p": 0.5}, "gains"))
    manager.switch(["speed", "other"], [])
    manager.command("speed", [3.0])
    manager.update(0.001)
    assert joints.calls[-1] == ("effort", {"left": 1.5})
    assert ("velocity", ("right",), (0.0,)) in joints.calls
    assert not [call for call in joints.calls if call[:2] == ("velocity", ("left",))]
    manager.switch([], ["speed"])
    manager.update(0.001)
    assert manager.periodic and joints.calls[-1] == ("effort", {"left": 1.5})


def test_gains_of_no_joint_are_refused(manager):
    with pytest.raises(ControllerError, match="joint 'nose', which does not exist.* left, right"):
        manager.hardware.set_gains("nose", parse_pid({"p": 1}, "gains"))


def test_interfaces_of_transmissions(joints):
    taken = Transmission("t", (("left", ("EffortJointInterface",)),))
    manager = Manager(joints, ModelDescription("bot", transmissions=Transmissions((taken,))))
    for values, text in (
        ({"type": VELOCITY, "joint": "left"}, "'left' in 'hardware_interface::VelocityJointInter"),
        ({"type": VELOCITY, "joint": "left"}, "its <transmission> offers effort"),
        ({"type": EFFORT_GROUP, "joints": ["left", "right"]}, "no <transmission> names it"),
    ):
        with pytest.raises(ControllerError, match=text):
            manager.load("v", values)
    assert manager.list() == []
    assert manager.load("e", {"type": EFFORT, "joint": "left"}).warnings == ()
    assert manager.hardware.published_names == ("left",)


def test_a_name_given_twice_in_a_switch_counts_once(manager, joints):
    manager.switch(["speed", "speed"], [])
    assert states(manager)["speed"] == RUNNING
    manager.switch([], ["speed", "speed"])
    assert states(manager)["speed"] == STOPPED


class Faulty(Controller):
    """Raises an exception where its configuration says."""

    interface, periodic = "effort", True

    @classmethod
    def configure(cls, settings, joints, description):
        """Raise, or claim a joint."""
        where = settings.text("where", "nowhere")
        if where == "configure":
            raise TypeError("wrong")
        return ControllerConfig(
            name=settings.name, joints=("left",), claims=(("effort", ("left",)),), notes=(where,)
        )

    def _raise(self, where):
        if self.config.notes == (where,):
            raise KeyError(where)

    def start(self, time):
        """Start."""
        self._raise("start")

    def command(self, values):
        """Command."""
        self._raise("command")

    def update(self, time, period):
        """Update."""
        self.joints[0].set_effort(1.0)
        self._raise("update")


@pytest.fixture(name="faulty")
def _faulty():
    remove = CONTROLLERS.add_source(
        lambda name: Faulty if name == "my/Faulty" else None, lambda: ("my/Faulty",)
    )
    yield
    remove()


@pytest.mark.parametrize("where", ["start", "command", "update"])
def test_a_controller_that_raises_is_stopped_alone(faulty, manager, joints, where):
    failures = []
    manager.on_failure = lambda name, error: failures.append((name, str(error)))
    manager.load("faulty", {"type": "my/Faulty", "where": where})
    manager.switch(["faulty", "other"], [])
    manager.command("faulty", [1.0])
    manager.update(0.001)
    assert failures == [("faulty", repr(where))]
    assert (states(manager)["faulty"], states(manager)["other"]) == (STOPPED, RUNNING)
    assert ("release", ("left",)) in joints.calls and not manager.hardware.periodic
    manager.switch([], ["other"])
    manager.switch(["speed"], [])  # its joint is free


def test_without_a_function_for_them_exceptions_come_out(faulty, manager):
    manager.load("faulty", {"type": "my/Faulty", "where": "update"})
    manager.switch(["faulty"], [])
    with pytest.raises(KeyError):
        manager.update(0.001)
    with pytest.raises(ControllerError, match="'bad' cannot be configured.*TypeError: wrong"):
        manager.load("bad", {"type": "my/Faulty", "where": "configure"})
    assert "my/Faulty" in CONTROLLERS.names()


@pytest.mark.parametrize("attribute, value", [("interface", "torque"), ("configure", lambda *_: 3)])
def test_a_class_without_an_interface_or_a_configuration_is_refused(
    faulty, manager, monkeypatch, attribute, value
):
    monkeypatch.setattr(Faulty, attribute, value)
    with pytest.raises(ControllerError, match="'bad' has a class.*velocity, position, effort"):
        manager.load("bad", {"type": "my/Faulty"})


@pytest.mark.parametrize("base, value", [(ControllerConfig, {}), (PidConfig, {"gains": ()})])
def test_fields_of_a_configuration_need_no_default_and_are_asked_for_by_name(base, value):
    @dataclasses.dataclass(frozen=True)
    class Config(base):
        limits: ClassVar[Any]
        effort: float
        side: str = "left"

    with pytest.raises(TypeError, match=r"Config\(\) needs effort="):
        Config(name="arm", **value)
    config = Config(name="arm", effort=2.0, **value)
    assert (config.effort, config.side, config.publish_rate) == (2.0, "left", 50.0)
    right = Config(name="arm", effort=2.0, side="right", **value)
    assert dataclasses.replace(config, side="right") == right != config

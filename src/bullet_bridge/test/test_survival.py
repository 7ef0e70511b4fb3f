"""The loop survives what cannot be: bodies that are nowhere, gains and paces without measure."""

import math
from types import SimpleNamespace

import pytest
import rospy
from bullet_bridge.control.reconfigure import pid_server
from bullet_bridge.loop import server
from bullet_bridge.plugins import base as plugin_base
from bullet_bridge.robots import Robots
from bullet_bridge.transport.pid_gains import NAMES
from bullet_sim.controllers.pid import PidGains
from bullet_sim.errors import ControllerError
from bullet_sim.pose import Pose
from dynamic_reconfigure.encoding import encode_config
from dynamic_reconfigure.msg import GroupState
from fake_impl import FakeReceivedCounts, plugin_of
from geometry_msgs.msg import Twist
from test_outputs import CART, Topic
from test_server import Rig as Loop
from urdf_texts import link

GRAVITY = (0.0, 0.0, 0.0)

IMU = (
    f'<robot name="r">{link("base")}<gazebo reference="base"><sensor name="i" type="imu">'
    '<update_rate>100</update_rate><plugin name="p" filename="libgazebo_ros_imu_sensor.so">'
    "<topicName>{0}</topicName><frameName>base</frameName><updateRateHZ>100</updateRateHZ>"
    "</plugin></sensor></gazebo>"
    "</robot>"
)


class Topics(dict):
    """Topics by name, and what was logged."""

    def __init__(self, monkeypatch):
        super().__init__()
        self.logged, self._throttle = [], None

        def publisher(name, kind, **_):
            self[name] = Topic(name, kind)
            return self[name]

        monkeypatch.setattr(plugin_base, "publisher", publisher)
        monkeypatch.setattr(rospy, "logerr_throttle", self._log_throttled)
        monkeypatch.setattr(
            rospy, "logerr", lambda text, *rest: self.logged.append(text % rest if rest else text)
        )

    def _log_throttled(self, period, text, *_):
        self.logged.append((period, text))


@pytest.fixture(name="topics")
def _endpoints(monkeypatch):
    return Topics(monkeypatch)


def test_a_body_that_is_nowhere_stops_only_its_own_sensor(world, topics):
    cameras = SimpleNamespace(set_sources=lambda _: None, flush=lambda *_: None)
    made = Robots(SimpleNamespace(call=lambda job: job()), world, cameras, seed=0)
    for number, name in enumerate(("lost", "well")):
        made.connect(world.spawn_urdf(name, IMU.format(name), Pose((3.0 * number, 0, 0)), str))
    world.model("lost").body.set_pose((math.nan,) * 3, (math.nan,) * 4)
    world.step_count = 10
    made.publish(10, 0.01)
    assert (len(topics["/lost/lost"].messages), len(topics["/well/well"].messages)) == (0, 1)
    assert len(topics.logged) == 1 and topics.logged[0][0] == 5.0
    assert all(part in topics.logged[0][1] for part in ("'lost'", "/lost/lost", "nan"))
    assert made.next_watched() == (20, 10.0)
    world.model("lost").set_state(Pose((9.0, 0.0, 0.0)))
    made.publish(20, 0.02)
    assert (len(topics["/lost/lost"].messages), len(topics["/well/well"].messages)) == (1, 2)
    assert len(topics.logged) == 1


@pytest.mark.parametrize("value", [1.7e308, -1.1e9, math.inf])
def test_a_wheel_plugin_keeps_its_last_good_command(world, topics, value):
    cart = world.spawn_urdf("cart", CART.format(""), Pose(), str)
    received = FakeReceivedCounts()
    output = plugin_of(world, cart, cart.description.sensors[0], received=received)
    command = Twist()
    for command.angular.z in (0.5, value):
        received.take(command)
    assert output._command == (0.0, 0.5)
    (text,) = topics.logged
    assert str(value) in text and "1e+09" in text


# tuning -------------------------------------------------------------------------------------------
class Tuned:
    """A server of gains whose service is called as rospy calls it."""

    def __init__(self, monkeypatch):
        self.taken, self.parameters, self.fault = [], {}, None
        monkeypatch.setattr(rospy, "Publisher", lambda name, kind, **_: Topic(name, kind))
        monkeypatch.setattr(rospy, "Service", lambda *_: None)
        monkeypatch.setattr(rospy, "set_param", self.parameters.__setitem__)
        self.tuning = pid_server("/bot/arm/pid", PidGains(2.0, 0.5, 0.1, -1.0, 1.0), self.apply)

    def apply(self, gains):
        if self.fault is not None:
            raise self.fault
        self.taken.append(gains)

    def ask(self, **values):
        """Call set_parameters; the values that it responds with."""
        response = self.tuning._set_callback(SimpleNamespace(config=encode_config(values)))
        return {row.name: row.value for row in response.doubles}


@pytest.fixture(name="tuned")
def _tuned(monkeypatch, topics):
    tuned = Tuned(monkeypatch)
    tuned.logged = topics.logged
    return tuned


@pytest.mark.parametrize("name", NAMES[:-1])
def test_a_gain_that_is_no_number_is_refused(tuned, name):
    assert tuned.ask(p=3.0)["p"] == 3.0
    before = dict(tuned.parameters)
    response = tuned.ask(**{"p": 7.0, name: math.nan})
    assert response == {"p": 3.0, "i": 0.5, "d": 0.1, "i_clamp_min": -1.0, "i_clamp_max": 1.0}
    assert tuned.taken == [PidGains(3.0, 0.5, 0.1, -1.0, 1.0)]
    assert tuned.parameters == before
    assert tuned.logged == [
        f"/bot/arm/pid: {name} is nan, must be a finite number; the gains are unchanged"
    ]
    assert tuned.ask(p=4.0)["p"] == 4.0 and tuned.taken[-1].p == 4.0


def test_gains_that_the_simulation_refuses_are_not_shown_as_set(tuned):
    tuned.fault = ControllerError("gone")
    assert tuned.ask(p=5.0)["p"] == 2.0 and tuned.logged == ["/bot/arm/pid: gone"]


@pytest.mark.parametrize("values", [{"p": "x"}, {"": 1.0}, {"none": 1.0}, {"antiwindup": "yes"}])
def test_what_no_parameter_is_called_is_ignored_and_named(tuned, values):
    """A text in place of a number, or a group that is not there, was a traceback."""
    config = encode_config({**values, "i": 0.7})
    config.groups = [GroupState("none", True, 77, -5)]
    response = tuned.tuning._set_callback(SimpleNamespace(config=config))
    assert {row.name: row.value for row in response.doubles}["i"] == 0.7
    assert tuned.taken == [PidGains(2.0, 0.7, 0.1, -1.0, 1.0)]
    (line,) = tuned.logged
    assert "/bot/arm/pid" in line and all(f"'{name}'" in line for name in values)


# time ---------------------------------------------------------------------------------------------
@pytest.mark.parametrize("factor", [1e-5, 1e-13, 1e-320])
def test_a_slow_pace_waits_in_short_pieces(factor):
    loop = Loop(real_time_factor=factor)
    loop.run(0.01)  # the first step is due at once
    waits, jobs = [], loop.server._jobs
    pending = jobs.run_pending

    def run_pending(wait=0.0, budget=math.inf):
        waits.append(wait)
        return pending(wait, budget)

    jobs.run_pending = run_pending
    loop.run(2.0)
    assert 0 < max(waits) <= server.IDLE_WAIT and loop.world.step_count <= 2


def test_slow_steps_come_at_their_times():
    loop = Loop(real_time_factor=0.002)  # a step each half second
    loop.run(10.2)
    assert loop.world.step_count == pytest.approx(21, abs=1)

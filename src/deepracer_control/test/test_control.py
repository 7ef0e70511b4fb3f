"""CarControl on fake publishers, without a ROS master."""

import math

import pytest
import rospy
from deepracer_control.control import CarControl, Settings
from geometry_msgs.msg import Twist

from deepracer_control import control, topics

WHEELS = (
    topics.RIGHT_REAR_TOPIC,
    topics.LEFT_REAR_TOPIC,
    topics.RIGHT_FRONT_TOPIC,
    topics.LEFT_FRONT_TOPIC,
)
HINGES = (topics.LEFT_DIRECTION_TOPIC, topics.RIGHT_DIRECTION_TOPIC)


class FakeRos:
    """Fake of rospy: stores messages and errors; its clock is set by the test."""

    def __init__(self):
        self.sent, self.errors, self.subscribed, self.now = [], [], {}, 0.0
        self.timers, self.queues, self.hooks = [], {}, []

    def install(self, monkeypatch, parameters):
        fake = self

        class Publisher:
            def __init__(self, name, _type, queue_size=None):
                self.name = name
                fake.queues[name] = queue_size

            def publish(self, message):
                fake.sent.append((self.name, message.data))

        monkeypatch.setattr(rospy, "Publisher", Publisher)
        monkeypatch.setattr(
            rospy, "Subscriber", lambda name, _type, cb: fake.subscribed.update({name: cb})
        )
        monkeypatch.setattr(rospy, "on_shutdown", self.hooks.append)
        monkeypatch.setattr(rospy, "Rate", lambda hz: f"rate {hz}")
        monkeypatch.setattr(
            rospy, "Timer", lambda period, cb, reset: fake.timers.append((period.to_sec(), cb))
        )
        monkeypatch.setattr(rospy, "get_time", lambda: fake.now)
        monkeypatch.setattr(rospy, "logwarn", lambda *_: None)
        monkeypatch.setattr(rospy, "logerr_throttle", lambda _t, text: fake.errors.append(text))
        monkeypatch.setattr(rospy, "get_param", lambda name, default: parameters.get(name, default))

    def take(self):
        """Returns the last value of each topic since the last call."""
        values, self.sent = dict(self.sent), []
        return values


@pytest.fixture
def make(monkeypatch):
    def build(**parameters):
        fake = FakeRos()
        fake.install(monkeypatch, {"~" + key: value for key, value in parameters.items()})
        return CarControl(), fake

    return build


def twist(v, w):
    message = Twist()
    message.linear.x, message.angular.z = v, w
    return message


def test_attributes_of_the_public_interface(make):
    car, fake = make()
    for name in (
        "rightRearPub",
        "leftRearPub",
        "rightFrontPub",
        "leftFrontPub",
        "leftSteeringPub",
        "rightSteeringPub",
    ):
        assert fake.queues[getattr(car, name).name] == 10
    assert car.rate == "rate 10"
    assert fake.subscribed[topics.COMMANDED_DATA_TOPIC] == car.subscriberCb
    assert control.controlEngines is None and callable(control.main)


@pytest.mark.parametrize(
    "v, w, degrees_right",
    [(10, 0, 0), (-10, 0, 0), (10, 2, 30), (10, -2, -30), (10, -5, -60), (0, 5, 60), (3, 4, 60)],
)
def test_original_mode(make, v, w, degrees_right):
    car, fake = make()
    car.subscriberCb(twist(v, w))
    sent = fake.take()
    assert [sent[name] for name in WHEELS] == [v] * 4
    assert [sent[name] for name in HINGES] == pytest.approx([-math.radians(degrees_right)] * 2)


def test_linear_and_angular_drive_touch_only_their_topics(make):
    car, fake = make()
    car.linearDrive(7.5)
    assert fake.take() == {name: 7.5 for name in WHEELS}
    car.angularDrive(1.0)
    assert fake.take() == pytest.approx({name: -math.radians(15) for name in HINGES})


def test_ackermann_mode_is_metric_and_left_positive(make):
    car, fake = make(mode="ackermann")
    car.drive(0.3, 0.0)
    sent = fake.take()
    assert [sent[name] for name in WHEELS] == pytest.approx([10.0] * 4)
    car.angularDrive(0.5)
    sent = fake.take()
    assert sent[topics.LEFT_DIRECTION_TOPIC] > sent[topics.RIGHT_DIRECTION_TOPIC] > 0
    assert sent[topics.RIGHT_REAR_TOPIC] > sent[topics.LEFT_REAR_TOPIC] > 0


@pytest.mark.parametrize("mode", control.MODES)
@pytest.mark.parametrize(
    "v, w, message",
    [
        (math.nan, 1, "linear.x is nan"),
        (1, math.inf, "angular.z is inf"),
        (-math.inf, 1, "linear.x is -inf"),
    ],
)
def test_a_value_that_is_not_finite_stops_the_car_and_is_logged(make, mode, v, w, message):
    car, fake = make(mode=mode)
    car.drive(0.2, 0.1)
    fake.take()
    car.subscriberCb(twist(v, w))
    assert fake.take() == {name: 0.0 for name in WHEELS + HINGES}
    assert len(fake.errors) == 1 and message in fake.errors[0]
    car.subscriberCb(twist(2, 0))
    assert fake.take()[WHEELS[0]] > 0


def test_watchdog_stops_once_in_ros_time(make):
    car, fake = make(command_timeout=0.5)
    ((_, check_timeout),) = fake.timers
    check_timeout(None)
    assert fake.take() == {}
    fake.now = 10.0
    car.subscriberCb(twist(10, 0))
    fake.take()
    fake.now = 10.4
    check_timeout(None)
    assert fake.take() == {}
    fake.now = 10.5
    check_timeout(None)
    assert fake.take() == {name: 0.0 for name in WHEELS + HINGES}
    fake.now = 20.0
    check_timeout(None)
    assert fake.take() == {}


def test_watchdog_does_not_change_the_steering_of_a_car_at_rest(make):
    """The window's slider commands once, as the original's: the wheels keep their angle."""
    car, fake = make(command_timeout=0.5)
    ((_, check_timeout),) = fake.timers
    fake.now = 10.0
    car.subscriberCb(twist(10, 0))
    car.subscriberCb(twist(0, 2))
    fake.take()
    fake.now = 20.0
    check_timeout(None)
    assert fake.take() == {}


def test_watchdog_restarts_after_a_reset(make):
    car, fake = make(command_timeout=0.5)
    ((_, check_timeout),) = fake.timers
    fake.now = 10.0
    car.subscriberCb(twist(10, 0))
    fake.take()
    for fake.now, stopped in ((0.1, False), (0.5, False), (0.6, True)):
        check_timeout(None)
        assert bool(fake.take()) is stopped


def test_at_shutdown_the_car_stops_and_no_command_follows(make):
    car, fake = make(command_timeout=0.5)
    car.subscriberCb(twist(10, 1))
    fake.take()
    (close,) = fake.hooks
    close()
    assert fake.take() == {name: 0.0 for name in WHEELS + HINGES}
    car.subscriberCb(twist(10, 1))  # one that was being processed
    fake.now = 20.0
    fake.timers[0][1](None)
    assert fake.take() == {}


def test_no_watchdog_by_default(make):
    assert make()[1].timers == []


@pytest.mark.parametrize(
    "key, value, message",
    [
        ("mode", "sideways", "mode is 'sideways'"),
        ("command_timeout", -1, "command_timeout is -1"),
        ("wheelbase", "long", "wheelbase is 'long'"),
        ("wheel_radius", 0, "wheel_radius is 0"),
    ],
)
def test_invalid_parameters_are_named(make, key, value, message):
    with pytest.raises(ValueError, match=message):
        make(**{key: value})


def test_settings_may_be_passed(make):
    make()
    assert CarControl(Settings(mode="ackermann")).settings.mode == "ackermann"

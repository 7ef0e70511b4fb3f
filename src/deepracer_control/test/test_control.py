"""CarControl on fake publishers, without a ROS master."""

import math

import pytest
import rospy
from deepracer_control.control import CarControl, Settings
from fake_ros import FakeRos
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock

from deepracer_control import control, topics
from paddock_common import passed_time

WHEELS = (
    topics.RIGHT_REAR_TOPIC,
    topics.LEFT_REAR_TOPIC,
    topics.RIGHT_FRONT_TOPIC,
    topics.LEFT_FRONT_TOPIC,
)
HINGES = (topics.LEFT_DIRECTION_TOPIC, topics.RIGHT_DIRECTION_TOPIC)


SIMULATED = {"use_sim_time": True}


class Car(FakeRos):
    """Reads what was published as values."""

    def clock(self, *times, publisher="/gazebo"):
        """Messages on /clock at these times [s]."""
        for seconds in times:
            message = Clock(rospy.Time.from_sec(seconds))
            message._connection_header = {"callerid": publisher}
            self.subscribed["/clock"](message)

    def take(self):
        """Returns the last value of each topic since the last call."""
        values = {topic: message.data for topic, message in self.sent}
        self.sent.clear()
        return values


@pytest.fixture
def make(monkeypatch):
    def build(**parameters):
        fake = Car()
        fake.install(monkeypatch, parameters)
        monkeypatch.setattr(rospy, "Rate", lambda hz: f"rate {hz}")
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
        assert getattr(car, name).queue_size == 10
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
    assert len(fake.texts("err")) == 1 and message in fake.texts("err")[0]
    car.subscriberCb(twist(2, 0))
    assert fake.take()[WHEELS[0]] > 0


@pytest.fixture
def watched(make):
    """A car with the watchdog that has been commanded to move at 10 s."""
    car, fake = make(command_timeout=0.5, **SIMULATED)
    fake.clock(9.0, 10.0)
    assert fake.take() == {}
    car.subscriberCb(twist(10, 0))
    fake.take()
    return car, fake


STOPPED = {name: 0.0 for name in WHEELS + HINGES}


def test_watchdog_stops_once_in_ros_time(watched):
    _, fake = watched
    fake.clock(10.2, 10.4)
    assert fake.take() == {}
    fake.clock(10.5)
    assert fake.take() == STOPPED
    fake.clock(20.0)
    assert fake.take() == {}


def test_watchdog_does_not_change_the_steering_of_a_car_at_rest(watched):
    """The window's slider commands once, as the original's: the wheels keep their angle."""
    car, fake = watched
    car.subscriberCb(twist(0, 2))
    fake.take()
    fake.clock(20.0)
    assert fake.take() == {}


def test_watchdog_restarts_after_a_reset(watched):
    _, fake = watched
    for now, stopped in ((0.1, False), (0.5, False), (0.7, True)):
        fake.clock(now)
        assert bool(fake.take()) is stopped


@pytest.mark.parametrize("other", [0.0, 10.0, 1e6])
def test_a_second_publisher_of_the_clock_is_named_and_does_not_hold_the_watchdog(watched, other):
    """With zeros between them each message began the time-out anew, and the car drove on."""
    _, fake = watched
    for step in range(1, 60):
        fake.clock(other, publisher="/rogue")
        assert fake.take() == {}
        fake.clock(10.0 + 0.01 * step)
        if fake.take():
            break
    assert step in (50, 51)
    warning, _ = fake.texts("warn")
    assert "/rogue publishes /clock, too, besides /gazebo" in warning


def test_a_slow_clock_or_a_paused_one_does_not_stop_the_car(watched):
    _, fake = watched
    fake.clock(*[10.0] * 1000)
    assert fake.take() == {}


def test_without_simulated_time_the_watchdog_counts_wall_time(make, monkeypatch):
    car, fake = make(command_timeout=0.5)
    (check,) = fake.timers
    now = [100.0]
    monkeypatch.setattr(passed_time.time, "monotonic", lambda: now[0])
    car.subscriberCb(twist(10, 0))
    fake.take()
    for now[0], expected in ((100.4, {}), (100.6, STOPPED), (101.0, {})):
        check(None)
        assert fake.take() == expected
    assert fake.periods == [0.125]


def test_at_shutdown_the_car_stops_and_no_command_follows(make):
    car, fake = make(command_timeout=0.5, **SIMULATED)
    car.subscriberCb(twist(10, 1))
    fake.take()
    (close,) = fake.hooks
    close()
    assert fake.take() == {name: 0.0 for name in WHEELS + HINGES}
    car.subscriberCb(twist(10, 1))  # one that was being processed
    fake.clock(10.0, 20.0)
    assert fake.take() == {}


def test_no_watchdog_by_default(make):
    fake = make(**SIMULATED)[1]
    assert fake.timers == [] and "/clock" not in fake.subscribed


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

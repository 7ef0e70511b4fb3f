"""State topics: rates, subscribers and contents."""

import math

import pytest
from bullet_bridge.plugins import states as state_topics
from bullet_bridge.plugins.states import METRICS_PERIOD, PerformanceTopic, StateTopics
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from fake_impl import fake_publishers

URDF = (
    '<robot name="r"><link name="base"><inertial><mass value="1"/><inertia ixx="0.1" '
    'iyy="0.1" izz="0.1"/></inertial></link><link name="plate"/><joint name="weld" '
    'type="fixed"><parent link="base"/><child link="plate"/></joint></robot>'
)


@pytest.fixture(name="topics")
def _topics(monkeypatch):
    return fake_publishers(monkeypatch, state_topics, subscribers=0)


@pytest.fixture(name="world")
def _world():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.spawn(sdf.ground_plane())
    world.spawn_urdf("bot", URDF, Pose((1, 2, 3)), str)
    world.model("bot").set_state(Pose((1, 2, 3)), (0.1, 0, 0), (0, 0, 0.2))
    yield world
    world.close()


def run(world, reporter, steps):
    """Steps in batches up to what is due, as the server makes them."""
    end = world.step_count + steps
    while world.step_count < end:
        world.step(max(1, min(end, reporter.next_due()) - world.step_count))
        reporter.publish(world.step_count, world.time)


def test_without_subscribers_nothing_is_published(topics, world):
    reporter = StateTopics("/gazebo", world, 100.0)
    assert reporter.next_due() == math.inf
    run(world, reporter, 100)
    assert all(not topic.messages for topic in topics.values())


@pytest.mark.parametrize("rate, expected", [(100.0, 50), (30.0, 15), (5000.0, 500)])
def test_rate_is_kept_and_never_more_than_one_a_step(topics, world, rate, expected):
    reporter = StateTopics("/gazebo", world, rate)
    topics["/gazebo/model_states"].subscribers = 1
    run(world, reporter, 500)
    assert len(topics["/gazebo/model_states"].messages) == expected
    assert not topics["/gazebo/link_states"].messages


def test_contents(world):
    models, links = state_topics.model_states(world), state_topics.link_states(world)
    assert models.name == ["ground_plane", "bot"]
    assert links.name == ["ground_plane::link", "bot::base"]  # the plate is merged
    for message in (models, links):
        place, speed = message.pose[1].position, message.twist[1]
        assert (place.x, place.y, place.z) == pytest.approx((1, 2, 3))
        assert (speed.linear.x, speed.angular.z) == pytest.approx((0.1, 0.2))
        assert message.twist[0].linear.x == 0


def test_a_restart_goes_on_from_the_new_time(topics, world):
    reporter = StateTopics("/gazebo", world, 100.0)
    topics["/gazebo/link_states"].subscribers = 1
    run(world, reporter, 105)
    world.reset()
    reporter.restart()
    assert reporter.next_due() == 10
    run(world, reporter, 25)
    assert len(topics["/gazebo/link_states"].messages) == 10 + 2


def test_performance(topics, world):
    now, counts = [50.0], {}
    metrics = PerformanceTopic("/gazebo", world, lambda: counts, lambda: now[0])
    topic = topics["/gazebo/performance_metrics"]
    assert metrics.next_due() == math.inf
    topic.subscribers = 1
    world.step(100)
    counts["w::bot::base::imu"] = 5
    now[0] += METRICS_PERIOD / 2
    metrics.publish(world.step_count, world.time)
    assert not topic.messages
    world.step(100)
    counts["w::bot::base::imu"] = 20
    now[0] += METRICS_PERIOD / 2
    metrics.publish(world.step_count, world.time)
    message = topic.messages[0]
    assert message.real_time_factor == pytest.approx(0.2 / METRICS_PERIOD)
    sensor = message.sensors[0]
    assert (sensor.name, sensor.sim_update_rate) == ("w::bot::base::imu", pytest.approx(100))
    assert sensor.real_update_rate == pytest.approx(20 / METRICS_PERIOD)
    now[0] += METRICS_PERIOD
    metrics.publish(world.step_count, world.time)  # no simulated time has passed
    assert len(topic.messages) == 1

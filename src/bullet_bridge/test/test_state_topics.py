"""State topics: rates, subscribers and contents."""

import math

import pytest
from bullet_bridge.plugins import states as state_topics
from bullet_bridge.plugins.states import METRICS_PERIOD, PerformanceTopic, StateTopics
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from driving import drive_velocities
from fake_impl import fake_publishers
from urdf_texts import joint, link, robot

GRAVITY = (0.0, 0.0, 0.0)

URDF = robot(link("base"), '<link name="plate"/>', joint("weld", "fixed", "base", "plate"))


@pytest.fixture(name="topics")
def _topics(monkeypatch):
    return fake_publishers(monkeypatch, state_topics, subscribers=0)


@pytest.fixture(name="world")
def _world(world):
    world.spawn(sdf.ground_plane())
    world.spawn_urdf("bot", URDF, Pose((1, 2, 3)), str)
    world.model("bot").set_state(Pose((1, 2, 3)), (0.1, 0, 0), (0, 0, 0.2))
    return world


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


@pytest.mark.parametrize("rate, expected", [(100.0, 50), (30.0, 15), (5000.0, 500), (0.0, 500)])
def test_rate_is_kept_and_never_more_than_one_a_step(topics, world, rate, expected):
    reporter = StateTopics("/gazebo", world, rate)
    topics["/gazebo/model_states"].subscribers = 1
    run(world, reporter, 500)
    assert len(topics["/gazebo/model_states"].messages) == expected
    assert not topics["/gazebo/link_states"].messages


def test_contents(topics, world):
    reporter = StateTopics("/gazebo", world, 1000.0)
    for topic in topics.values():
        topic.subscribers = 1
    run(world, reporter, 1)
    models, links = (topics[f"/gazebo/{name}_states"].messages[-1] for name in ("model", "link"))
    assert models.name == ["ground_plane", "bot"]
    assert links.name == ["ground_plane::link", "bot::base"]  # the plate is merged
    for message in (models, links):
        place, speed = message.pose[1].position, message.twist[1]
        assert (place.x, place.y, place.z) == pytest.approx((1.0001, 2, 3))
        assert (speed.linear.x, speed.angular.z) == pytest.approx((0.1, 0.2), rel=1e-3)
        assert message.pose[0].orientation.w == 1.0 and message.twist[0].linear.x == 0


def test_models_that_come_and_go_and_are_loaded_again(topics, world):
    """Names and numbers belong together, whatever happened since the last message."""
    reporter = StateTopics("/gazebo", world, 1000.0)
    for topic in topics.values():
        topic.subscribers = 1
    for change, names in (
        (lambda: None, ["ground_plane", "bot"]),
        (lambda: world.spawn_urdf("other", URDF, Pose((4, 0, 1)), str), None),
        (world.reset, ["ground_plane", "bot", "other"]),
        (lambda: world.delete("bot"), ["ground_plane", "other"]),
        (lambda: world.spawn_urdf("bot", URDF, Pose((1, 5, 3)), str), None),
    ):
        change()
        reporter.restart()  # as the server does after a reset
        run(world, reporter, 1)
        models, links = (
            topics[f"/gazebo/{kind}_states"].messages[-1] for kind in ("model", "link")
        )
        assert models.name == (names or list(world.models))
        assert [name.partition("::")[0] for name in links.name] == models.name
        for index, name in enumerate(models.name):
            expected = world.models[name].pose.position
            for message in (models, links):
                place = message.pose[index].position
                assert (place.x, place.y, place.z) == pytest.approx(expected, abs=1e-9)


JOINTED = robot(
    link("base", 1, (0.1, 0.2, 0.1), center="0.1 0 0"),
    *(
        link(f"arm{i}", 0.5, 0.01, center="0 0.05 0")
        + f'<joint name="j{i}" type="continuous"><parent link="base"/><child link="arm{i}"/>'
        f'<origin xyz="0 {i} 0" rpy="0.3 0 0"/><axis xyz="0 0 1"/></joint>'
        for i in range(3)
    ),
)


def test_all_links_at_once_are_as_one_by_one(topics, world):
    model = world.spawn_urdf("arms", JOINTED, Pose((0, 0, 1)), str)
    model.set_state(Pose((0, 0, 1)), (0.3, 0.2, 0.1), (0.5, -0.4, 0.3))
    drive_velocities(model.joints, model.joints.names, (1.0, 2.0, 3.0))
    world.step(20)
    motions = dict(zip(model.bodies, model.body_motions()))
    assert len(motions) == 4
    for name, motion in motions.items():
        assert motion == model.link_motion(name)


def test_links_of_models_inside_a_model_are_not_in_link_states_as_in_gazebo(topics, world):
    """publishLinkStates goes through the children of a model that are links."""
    text = (
        '<sdf version="1.6"><model name="x"><model name="in"><link name="a"/></model>'
        '<link name="own"><pose>0 0 2 0 0 0</pose></link></model></sdf>'
    )
    world.spawn_sdf("out", text, Pose((1, 0, 1)), str)
    reporter = StateTopics("/gazebo", world, 0.0)
    topics["/gazebo/link_states"].subscribers = 1
    run(world, reporter, 1)
    message = topics["/gazebo/link_states"].messages[0]
    assert [name for name in message.name if name.startswith("out::")] == ["out::own"]
    assert len(message.pose) == len(message.name)
    assert message.pose[-1].position.z == pytest.approx(3.0, abs=1e-4)


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
    cameras = set()
    metrics = PerformanceTopic("/gazebo", world, lambda: counts, lambda: now[0], lambda: cameras)
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
    assert sensor.fps == -1.0, "it is no camera"
    now[0] += METRICS_PERIOD
    metrics.publish(world.step_count, world.time)  # no simulated time has passed
    assert len(topic.messages) == 1

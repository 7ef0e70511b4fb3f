"""A harness lowers a model and lets it go as in Gazebo 11.1; the topics of a projector."""

import gazebo_states
import numpy as np
import pytest
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.pose import Pose
from bullet_sim.world import World
from fake_impl import FakeReceivedCounts, plugin_of
from std_msgs.msg import Bool, Float32, Int32, String

TOLERANCE = 1e-6  # [m], of quaternions: 1
RECORDED = gazebo_states.recorded()


class Received(FakeReceivedCounts):
    """Callbacks by topic."""

    def __init__(self):
        self.topics = {}

    def subscribe(self, topic, kind, callback, **options):
        self.topics[topic] = kind, callback
        return super().subscribe(topic, kind, callback, **options)

    def hear(self, topic, value):
        kind, callback = self.topics[topic]
        callback(kind(value))


def held(name, solver="ode"):
    """A world with the model of a harness by ROS, and its plugin with its topics."""
    text = gazebo_states.model(name).replace("libHarnessPlugin.so", "libgazebo_ros_harness.so")
    world = World(solver=solver, gravity=gazebo_states.GRAVITY)
    world.spawn_sdf("bot", f'<sdf version="1.6">{text}</sdf>', Pose(), str)
    model, received = world.model("bot"), Received()
    return world, plugin_of(world, model, model.description.sensors[0], received=received), received


def drive(world, plugin, received, commands, steps=gazebo_states.STEPS):
    """Make steps with commands; yields the number of each that is recorded."""
    for step in range(steps):
        if step:  # Gazebo's plugin begins with the second one, too
            for at, _, kind, value, _ in commands:
                if at == step:
                    topic = "velocity" if kind == "winch" else "detach"
                    received.hear(f"/bot/harness/{topic}", value if kind == "winch" else True)
            plugin.update(world.time, world.time_step)
        world.step()
        if (step + 1) % gazebo_states.EVERY == 0:
            yield step + 1


@pytest.mark.parametrize("name", gazebo_states.HARNESSES)
def test_links_are_where_gazebo_has_them(name):
    world, plugin, received = held(name)
    differences, model = {}, plugin.model
    for step in drive(world, plugin, received, gazebo_states.HARNESSES[name][1]):
        for link, wanted in RECORDED[name][str(step)].items():
            part, offset = model.link_in_body(link)
            center = model.body.link_center(part)
            turned = np.array((Pose(*model.body.link_motion(part)[:2]) * offset).orientation)
            turned *= np.sign(turned @ wanted[3:])
            found = np.concatenate([center, turned])
            differences[step, link] = float(np.abs(found - wanted).max())
    world.close()
    assert max(differences.values()) < TOLERANCE, differences


def position(world):
    return world.model("bot").link_state("box")[0].position[2]


def test_only_true_lets_go_and_then_nothing_is_driven(caplog):
    world, plugin, received = held("a harness")
    assert sorted(received.topics) == ["/bot/harness/detach", "/bot/harness/velocity"]
    assert [kind for _, (kind, _) in sorted(received.topics.items())] == [Bool, Float32]
    received.hear("/bot/harness/detach", False)
    list(drive(world, plugin, received, ()))
    held_at = position(world)
    assert held_at > 1.48
    received.hear("/bot/harness/detach", True)
    list(drive(world, plugin, received, (), 200))
    assert held_at - position(world) == pytest.approx(0.5 * 9.8 * 0.2**2, rel=0.02), "it falls"
    received.hear("/bot/harness/velocity", 1.0)
    received.hear("/bot/harness/detach", True)
    list(drive(world, plugin, received, (), 2))
    world.close()


def test_a_velocity_that_is_no_number_is_refused():
    world, plugin, received = held("a harness")
    received.hear("/bot/harness/velocity", float("nan"))
    list(drive(world, plugin, received, (), 100))
    assert 1.48 < position(world) < 1.5
    world.close()


def test_a_reset_of_poses_leaves_its_joint_and_a_new_start_makes_it_again():
    world, plugin, received = held("a harness")
    list(drive(world, plugin, received, ((10, "bot", "winch", -0.3, 0),), 300))
    lower = position(world)
    world.reset_models()
    assert position(world) == pytest.approx(1.5)
    list(drive(world, plugin, received, (), 290))
    assert 1.5 - position(world) == pytest.approx(1.5 - lower, abs=0.005), "it goes on"
    received.hear("/bot/harness/detach", True)
    list(drive(world, plugin, received, (), 100))
    world.reset()
    plugin.reset(world.time)
    list(drive(world, plugin, received, (), 100))
    assert 1.49 < position(world) < 1.5
    world.close()


def test_it_holds_where_it_was_after_models_are_sorted():
    world, plugin, received = held("a harness")
    box = gazebo_states.model("a harness").partition("<plugin")[0] + "</model>"
    world.spawn_sdf("a", f'<sdf version="1.6">{box}</sdf>', Pose((2.0, 0.0, 0.0)), str)
    assert world.sort_before_start()
    list(drive(world, plugin, received, (), 100))
    assert position(world) == pytest.approx(RECORDED["a harness"]["100"]["box"][2], abs=1e-9)
    plugin.close()
    list(drive(world, plugin, received, (), 1))
    world.close()


def test_without_a_winch_it_lets_go_at_once():
    text = gazebo_states.model("a harness")
    start, end = text.index("<winch>"), text.index("</winch>")
    model = parse_model(f'<sdf version="1.6">{text[:start]}{text[end + 8 :]}</sdf>', str)[0]
    assert (model.sensors[0].winch, model.sensors[0].detach) == (-1, 0)
    assert "<winch/joint> '', must be one of winch; there is none" in model.warnings[-1]
    world = World(gravity=gazebo_states.GRAVITY)
    world.spawn_sdf("bot", f'<sdf version="1.6">{text[:start]}{text[end + 8 :]}</sdf>', Pose(), str)
    plugin = plugin_of(world, world.model("bot"), model.sensors[0])
    list(drive(world, plugin, Received(), (), 100))
    assert 1.5 - position(world) == pytest.approx(0.5 * 9.8 * 0.1**2, rel=0.05)
    world.close()


@pytest.mark.parametrize(
    "old, new, words",
    [
        ('type="prismatic"', 'type="ball"', "has type 'ball' and goes from 'world' to 'box'"),
        ("<child>box", "<child>bow", "goes from 'world' to 'bow'"),
        ("<parent>world", "<parent>roof", "goes from 'roof' to 'box'"),
    ],
)
def test_a_joint_that_cannot_be_made_is_left_out(old, new, words):
    text = gazebo_states.model("a harness").replace(old, new)
    model = parse_model(f'<sdf version="1.6">{text}</sdf>', str)[0]
    assert model.sensors == []
    assert any(words in each for each in model.warnings), model.warnings
    assert "has no <joint> that it can use" in model.warnings[-1]


def test_a_name_of_no_joint_is_the_first_one():
    text = gazebo_states.model("a harness").replace("<detach>winch", "<detach>rope")
    model = parse_model(f'<sdf version="1.6">{text}</sdf>', str)[0]
    assert model.sensors[0].detach == 0
    assert "<detach> 'rope', must be one of winch; 'winch' is used" in model.warnings[-1]
    assert model.sensors[0].topic == "", "Gazebo's own has no topics of ROS"


def test_with_bullet_it_holds_nothing():
    world, plugin, received = held("a harness", "bullet")
    list(drive(world, plugin, received, (), 100))
    assert position(world) < 1.46
    world.close()


def test_topics_of_a_projector():
    plugin = (
        '<plugin name="p" filename="libgazebo_ros_projector.so"><projector>link/it</projector>'
        "<robotNamespace>bot</robotNamespace><textureTopicName>texture</textureTopicName>"
        "<projectorTopicName>/switch</projectorTopicName></plugin></model>"
    )
    text = gazebo_states.model("a harness").partition("<plugin")[0] + plugin
    world, received = World(), Received()
    world.spawn_sdf("bot", f'<sdf version="1.6">{text}</sdf>', Pose(), str)
    model = world.model("bot")
    plugin_of(world, model, model.description.sensors[0], received=received)
    assert {topic: kind for topic, (kind, _) in received.topics.items()} == {
        "/bot/texture": String,
        "/switch": Int32,
    }
    received.hear("/switch", 1)
    received.hear("/bot/texture", "stereo.png")
    world.close()

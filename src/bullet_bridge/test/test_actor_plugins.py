"""Plugins that move actors, without a ROS master."""

import math

import numpy as np
import pytest
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.plugins.actors import entry, social_force
from bullet_sim.world import World
from fake_impl import plugin_of

ACTOR = (
    '<sdf version="1.7"><world name="w"><actor name="walker"><pose>0 1 1.25 1.57 0 3</pose>'
    '<skin><filename>walk.dae</filename></skin><animation name="walking"><filename>walk.dae'
    '</filename></animation><plugin name="p" filename="libActorPlugin.so">{}</plugin></actor>'
    "{}</world></sdf>"
)
BLOCK = (
    '<model name="block"><static>1</static><pose>{} 0 0 0</pose><link name="l"><collision name="c">'
    "<geometry><box><size>1 1 1</size></box></geometry></collision></link></model>"
)


def walk(tags, more, seconds):
    """Places of an actor with ActorPlugin, one every 0.05 s."""
    world = World()
    world.load(parse_world(ACTOR.format(tags, more), str))
    model = world.models["walker"]
    plugin = plugin_of(world, model, model.description.sensors[0])
    places = []
    for _ in range(round(seconds / 0.05)):
        world.step(50)
        plugin.update(world.time, 0.05)
        places.append((*model.pose.position[:2], model.pose.rpy[2]))
    world.close()
    return np.array(places)


def test_an_actor_turns_and_walks_to_its_target_by_gazebos_actor_plugin():
    places = walk("<target>0 -5 1.2138</target>", "", 9.0)
    turning = (abs(places[:, 1] - 1.0) < 1e-9).sum() * 0.05
    # a thousandth of what is left in each step of 1 ms, down to 10 degrees
    assert turning == pytest.approx(math.log(3.0 / math.radians(10.0)), abs=0.06)
    going = places[places[:, 1] < 0.9]
    speeds = -np.diff(going[:, 1]) / 0.05
    assert speeds[:50] == pytest.approx(1.15 * 0.8, rel=1e-3), "upstream's pace times the weight"
    assert going[10] == pytest.approx((0.0, going[10, 1], -math.pi / 2), abs=1e-3)
    assert going[:, 1].min() == pytest.approx(-5.0 + 0.3, abs=0.06), "then it has another target"


def test_an_actor_goes_around_what_it_does_not_ignore():
    block = BLOCK.format("0.3 -2 1.2138")
    around = walk("", block, 7.0)
    through = walk("<ignore_obstacles><model>block</model></ignore_obstacles>", block, 7.0)
    assert abs(through[:, 0]).max() < 0.01 < 0.3 < -around[:, 0].min()
    assert (around[:, 1] >= -10.0).all() and (around[:, 0] >= -3.0).all()


def test_targets_by_chance_are_two_metres_and_more_from_the_last_and_from_models():
    world = World()
    world.load(parse_world(ACTOR.format("", BLOCK.format("2 2 1.2138")), str))
    model = world.models["walker"]
    plugin = plugin_of(world, model, model.description.sensors[0])
    gaps = []
    for _ in range(200):
        last = plugin._target
        plugin._choose()
        gaps.append(min(math.dist(plugin._target, place) for place in (last, (2.0, 2.0, 1.2138))))
    world.close()
    assert 2.0 <= min(gaps) < 2.5


PERSON = (
    '<actor name="{0}"><pose>{1} 0 0 {2}</pose><skin><filename>walk.dae</filename></skin>'
    '<animation name="walking"><filename>walk.dae</filename></animation><plugin name="p" '
    'filename="libPedestrianSFMPlugin.so">{3}</plugin></actor>'
)
WAY = "<trajectory><cyclic>{}</cyclic><waypoint>{}</waypoint><waypoint>{}</waypoint></trajectory>"


def people(persons, more, seconds):
    """Places of actors with PedestrianSFMPlugin, one every 0.05 s: (n, actors, 3)."""
    world = World()
    text = "".join(PERSON.format(*person) for person in persons)
    world.load(parse_world(f'<sdf version="1.7"><world name="w">{text}{more}</world></sdf>', str))
    models = [world.models[person[0]] for person in persons]
    plugins = [plugin_of(world, model, model.description.sensors[0]) for model in models]
    places = []
    for _ in range(round(seconds / 0.05)):
        world.step(50)
        for plugin in plugins:
            plugin.update(world.time, 0.05)
        places.append([(*model.pose.position[:2], model.pose.rpy[2]) for model in models])
    world.close()
    return np.array(places)


def test_a_pedestrian_walks_from_goal_to_goal():
    tags = "<velocity>1.2</velocity>" + WAY.format("true", "15 20 0", "12 20 0")
    places = people([("a", "10 20 1", 1.5707, tags)], "", 13.0)[:, 0]
    speeds = np.linalg.norm(np.diff(places[:, :2], axis=0), axis=1) / 0.05
    # dv/dt = (2 * 1.2 - 2 v) / 0.5 s: 1 - exp(-4 t) of 1.2 m/s
    assert places[9, 0] - 10.0 == pytest.approx(1.2 * (0.5 - (1 - math.exp(-2.0)) / 4), abs=0.01)
    assert speeds.max() == pytest.approx(1.2, rel=1e-3)
    assert places[:, 0].max() == pytest.approx(15.0 - 0.3, abs=0.35)
    turned = places[:, 0].argmax()
    assert places[turned:, 0].min() < 12.4 < places[-1, 0], "and to the first goal again"
    assert abs(places[:, 1] - 20.0).max() < 1e-3


def test_a_pedestrian_keeps_away_from_a_model_and_from_another():
    goal = WAY.format("false", "20 20 0", "21 20 0")
    away = people([("a", "14 20 1", 1.5707, goal)], "", 5.0)[:, 0]
    wall = (
        '<model name="wall"><static>1</static><pose>17.5 20.3 0.5 0 0 0</pose><link name="l">'
        '<collision name="c"><geometry><box><size>1 1 3</size></box></geometry></collision></link>'
        "</model>"
    )
    around = people([("a", "14 20 1", 1.5707, goal)], wall, 5.0)[:, 0]
    ignoring = goal + "<ignore_obstacles><model>wall</model></ignore_obstacles>"
    through = people([("a", "14 20 1", 1.5707, ignoring)], wall, 5.0)[:, 0]
    assert np.array_equal(through, away) and abs(away[:, 1] - 20.0).max() < 1e-3
    inside = (abs(around[:, 0] - 17.5) < 0.5) & (abs(around[:, 1] - 20.3) < 0.5)
    assert not inside.any() and (abs(away[:, 0] - 17.5) < 0.5).any()
    back = WAY.format("false", "10 20.1 0", "9 20 0")
    two = people([("a", "12 20 1", 1.5707, goal), ("b", "18 20.1 1", -1.5707, back)], "", 7.0)
    apart = np.linalg.norm(two[:, 0, :2] - two[:, 1, :2], axis=1)
    assert 0.25 < apart.min() < apart[-1], "they pass each other"


def test_a_group_stays_together():
    goal = WAY.format("false", "30 20 0", "31 20 0")
    pairs = {}
    for group in ("", "<group><model>{}</model></group>"):
        persons = [
            ("a", "10 20 1", 1.5707, goal + group.format("b")),
            ("b", "10 23 1", 1.5707, goal + group.format("a")),
        ]
        places = people(persons, "", 6.0)[:, :, :2]
        pairs[group != ""] = np.linalg.norm(places[:, 0] - places[:, 1], axis=1)
    assert pairs[True][-1] < 0.75 * pairs[False][-1]


def test_the_force_of_another_slows_and_turns_away():
    ahead = social_force(np.array((2.0, 0.0)), np.array((1.0, 0.0)))
    reach = 0.35 * 3.0  # straight ahead: of lambda 2 times 1 m/s and the direction
    assert ahead == pytest.approx((-math.exp(-2.0 / reach), 0.0))
    left = social_force(np.array((2.0, 0.4)), np.array((1.0, 0.0)))
    assert left[0] < 0.0 and left[1] < 0.0, "away to the right"


def test_a_line_enters_a_box_where_it_meets_it():
    box = np.array((2.0, -1.0, 0.0)), np.array((4.0, 1.0, 3.0))
    assert entry(np.zeros(3), np.array((3.0, 0.0, 0.0)), *box) == pytest.approx((2.0, 0.0, 0.0))
    assert entry(np.array((3.0, 0.0, 1.0)), np.array((3.0, 0.0, 0.0)), *box) is None
    assert entry(np.array((0.0, 5.0, 1.0)), np.array((3.0, 4.0, 1.0)), *box) is None


def test_the_animation_factor_is_how_fast_limbs_move_for_the_way():
    """Upstream adds the way times the factor, 4.5 without one, to the animation's time."""
    angles = []
    factor = "<animation_factor>{}</animation_factor>"
    for tags in ("", factor.format(4.5), factor.format(0)):
        world = World()
        world.load(parse_world(ACTOR.format(tags, ""), str))
        model = world.models["walker"]
        plugin = plugin_of(world, model, model.description.sensors[0])
        world.step(20000)
        plugin.update(world.time, 20.0)
        angles.append(model.body.joint_positions())
        world.close()
    default, same, standing = angles
    assert default == same != standing

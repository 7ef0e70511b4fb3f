"""Links that fixed joints hold, in the world or on each other in an SDF: bodies on joints, as in
Gazebo, or parts where `fixed_joints` says so. How far they yield: gazebo_states.py."""

import gazebo_states as g
import numpy as np
import pytest
from bullet_sim.errors import ModelError
from bullet_sim.models.changes import link_properties, set_link_properties
from bullet_sim.pose import Pose
from bullet_sim.world import World

HELD_FIRST = g.connected("held", "fixed", "world", "base")
RIG = g.robot(
    '<link name="world"/>',
    g.joint("held", "fixed", "world", "base", "0 0 0.5"),
    g.link("base", 2.0, 0.01, '<box size="0.2 0.2 0.2"/>', center="0.05 0 0"),
    g.joint("hinge", "continuous", "base", "arm"),
    g.link("arm", 5.0, 0.2, center="1 0 0"),
    g.joint("wrist", "continuous", "arm", "tip", "1.5 0 0"),
    g.link("tip", 4.0, 0.2, center="0.5 0 0.2"),
)


@pytest.fixture(name="make")
def _make():
    made = []

    def make(**given):
        made.append(World(gravity=g.GRAVITY, **given))
        return made[-1]

    yield make
    for world in made:
        world.close()


def spawned(world, text):
    if text.startswith("<robot"):
        return world.spawn_urdf("m", text, Pose((1.0, 2.0, 0.0)), str)
    text = f'<sdf version="1.6"><model name="m">{text}</model></sdf>'
    return world.spawn_sdf("m", text, Pose((1.0, 2.0, 0.0)), str)


def yielding(world, model, link="base"):
    """How far a link goes while an arm falls [m]."""
    before, most = np.array(model.link_state(link)[0].position), 0.0
    for _ in range(300):
        world.step()
        now = np.array(model.link_state(link)[0].position)
        most = max(most, float(np.abs(now - before).max()))
    return most


@pytest.mark.parametrize("text", [RIG, g.LONG_ARMS + HELD_FIRST], ids=["urdf", "sdf"])
def test_a_base_that_the_world_holds_yields_unless_it_is_merged(make, text):
    world = make()
    model = spawned(world, text)
    assert 0.0 < yielding(world, model) < 1e-2
    world = make(fixed_joints="merge")
    assert yielding(world, spawned(world, text)) == 0.0


BODIES = g.body("a", "0 0 1 0 0 0", g.CUBE) + g.body("b", "0.3 0 1 0 0 0", g.CUBE)


def test_links_on_a_fixed_joint_of_an_sdf_are_two_bodies(make):
    text = BODIES + g.connected("weld", "fixed", "a", "b")
    assert list(spawned(make(), text).rigid_parts) == ["a", "b"]
    for given in ({"fixed_joints": "merge"}, {"solver": "bullet"}):
        assert list(spawned(make(**given), text).rigid_parts) == ["a"]


def test_a_static_model_is_one_body(make):
    text = "<static>1</static>" + BODIES + g.connected("weld", "fixed", "a", "b")
    assert list(spawned(make(), text).rigid_parts) == ["a"]


def test_the_links_of_a_urdf_on_fixed_joints_are_one_body(make):
    """So sdformat merges them: the number of bodies of our own robots stays."""
    text = RIG.replace('type="continuous"', 'type="fixed"')
    assert list(spawned(make(), text).rigid_parts) == ["base"]


def test_a_base_without_mass_is_a_part_of_the_world(make):
    text = RIG.replace('<mass value="2.0"', '<mass value="0"')
    world = make(massless_links="keep")
    assert yielding(world, spawned(world, text)) == 0.0


def test_the_joint_pulls_what_is_put_elsewhere_back(make):
    """As ODE's fixed joint, whose place in the world stays."""
    world = make()
    model = spawned(world, g.LONG_ARMS + HELD_FIRST)
    model.set_state(Pose((1.05, 2.0, 0.0)))
    world.step(300)
    assert model.pose.position == pytest.approx((1.0, 2.0, 0.0), abs=1e-3)


def test_several_links_that_are_held_stay_each_at_its_place(make):
    world = make()
    text = (
        BODIES
        + g.body("c", "0 0.5 1 0 0 0", g.CUBE)
        + "".join(g.connected(f"held {n}", "fixed", "world", n) for n in "ac")
    )
    model = spawned(world, text)
    before = {name: model.link_state(name)[0].position for name in "abc"}
    world.step(50)
    for name, fall in (("a", 0.0), ("b", 0.5 * 9.8 * 0.05**2), ("c", 0.0)):
        wanted = np.subtract(before[name], (0.0, 0.0, fall))
        assert model.link_state(name)[0].position == pytest.approx(wanted, abs=1e-3)


def test_a_state_is_restored_to_the_bit(make):
    world = make()
    model = spawned(world, RIG)
    world.step(50)
    saved = world.save_state()
    found = []
    for _ in range(2):
        world.restore_state(saved)
        world.step(50)
        found.append(model.body.rows.copy())
    assert (found[0] == found[1]).all()


def test_mirrors_have_it_where_it_is(make):
    world = make()
    model = spawned(world, RIG)
    world.step(100)
    state = model.state()
    assert state.position == model.body.pose()[0] and not model.source.fixed_base
    there, _ = world.engine.mirror.client.link_frame((model.body.number, "base"))
    assert there == pytest.approx(model.pose.position, abs=1e-6)


def test_properties_of_a_held_link_are_in_its_own_frame(make):
    model = spawned(make(), RIG.replace('xyz="0 0 0.5"', 'xyz="0 0 0.5" rpy="0 0 1.5707963"'))
    mass, center, inertia, gravity = link_properties(model, "base")
    assert center == pytest.approx((0.05, 0.0, 0.0), abs=1e-6)
    set_link_properties(model, "base", mass, center, np.diag((0.01, 0.02, 0.03)), gravity)
    assert link_properties(model, "base")[2] == pytest.approx(np.diag((0.01, 0.02, 0.03)), abs=1e-9)
    assert model.rigid_parts["base"].inertia[0, 0] == pytest.approx(0.02, abs=1e-9)


def test_an_unknown_way_is_an_error(make):
    with pytest.raises(ModelError, match="fixed_joints is 'rigid', must be keep or merge"):
        make(fixed_joints="rigid")

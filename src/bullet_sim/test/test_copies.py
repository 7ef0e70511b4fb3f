"""PyBullet's copies of bodies that the solver 'ode' moves: made late, equal, without an effect."""

import itertools

import pytest
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World

INERTIAL = (
    '<inertial><origin xyz="0.1 -0.2 0.3" rpy="0 0 0.4"/><mass value="1"/>'
    '<inertia ixx="1" ixy="0" ixz="0" iyy="1.1" iyz="0" izz="0.9"/></inertial>'
)
SHAPE = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
LIMIT = '<limit lower="-1" upper="1" effort="10" velocity="10"/>'


def joint(name, kind, parent, child):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>{LIMIT}</joint>'
    )


@pytest.fixture(name="nobody_connects")
def _nobody_connects(monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("a client of PyBullet was connected")

    monkeypatch.setattr("pybullet.connect", refuse)


ARM = (
    '<robot name="arm"><link name="base">{0}{1}</link><link name="one">{0}{1}</link>'
    '<link name="two">{0}{1}</link>{2}{3}</robot>'
).format(
    INERTIAL,
    SHAPE,
    joint("a", "revolute", "base", "one"),
    joint("b", "prismatic", "one", "two"),
)


def scene():
    """A world of a ground, a box that never moves, and two arms of which one is held."""
    world = World()
    world.spawn(sdf.ground_plane())
    still = ARM.replace("</robot>", "<gazebo><static>true</static></gazebo></robot>")
    world.spawn_urdf("still", still, Pose((4.0, 0.0, 1.0)), str)
    world.spawn_urdf("free", ARM, Pose((0.0, 0.0, 1.0)), str)
    fixed = ARM.replace(
        '<robot name="arm">',
        '<robot name="arm"><link name="world"/>' + joint("held", "fixed", "world", "base"),
    )
    world.spawn_urdf("held", fixed, Pose((2.0, 0.0, 1.0)), str)
    return world


def act(world):
    """What changes the bodies between steps."""
    world.step(5)
    free, held = world.models["free"], world.models["held"]
    free.set_state(Pose.from_xyz_rpy((0.0, 1.0, 0.8), (0.1, 0.2, 0.3)), (1.0, 0, 0), (0, 0, 2.0))
    held.joints.set_positions({"a": 0.5})
    world.step(20)
    free.joints.set_positions({"b": 0.1})
    world.models["still"].set_state(Pose((0.4, 1.0, 0.1)))
    world.step(300)


def motions(world):
    """All links' motions."""
    return [
        (name, model.body.link_motion(part))
        for name, model in world.models.items()
        for part in model.rigid_parts
    ]


def test_nothing_of_this_needs_pybullet(nobody_connects):
    world = scene()
    act(world)
    state = world.save_state()
    world.step(10)
    world.restore_state(state)
    world.reset()
    world.delete("free")
    world.close()


def test_copies_change_no_bit():
    plain, asked = scene(), scene()
    assert asked.engine.mirror.client
    for world in (plain, asked):
        act(world)
    assert asked.engine.mirror.client
    assert motions(plain) == motions(asked)
    for world in (plain, asked):
        world.close()


def test_copies_are_where_the_bodies_are():
    world = scene()
    act(world)
    engine = world.engine

    def check():
        for model in world.models.values():
            for part in model.rigid_parts:
                there, turned = engine.mirror.client.link_frame((model.body.number, part))
                place, turn, *_ = model.body.link_motion(part)
                assert there == pytest.approx(place, abs=1e-5), (model.name, part)
                same = abs(sum(a * b for a, b in zip(turned, turn)))
                assert same == pytest.approx(1.0, abs=1e-6)

    check()
    act(world)
    check()
    world.models["still"].set_state(Pose((3.0, 3.0, 1.0)))  # without a step after it
    world.models["free"].set_state(Pose((0.0, -3.0, 1.0)))
    check()
    world.close()


def test_a_state_is_the_same_whoever_has_asked_for_copies():
    """Saved and restored before and after something has asked for them."""
    world = scene()
    act(world)
    found = []
    for before, after in itertools.product((False, True), repeat=2):
        if before:
            assert world.engine.mirror.client
        state = world.save_state()
        if after:
            assert world.engine.mirror.client
        world.models["still"].set_state(Pose((9.0, 0.0, 1.0)))
        world.step(50)
        world.restore_state(state)
        assert world.models["still"].pose.position == (0.4, 1.0, 0.1)
        world.step(50)
        found.append(motions(world))
        world.restore_state(state)
    assert found.count(found[0]) == 4
    world.close()


def test_what_is_no_number_stays_where_it_was_put():
    world = scene()
    free = world.models["free"]
    world.engine.refresh()  # its arrays
    world.engine.rows[:, :3] = float("nan")
    world.step(1)
    position, _, linear, _ = free.body.link_motion(free.root)
    assert position == pytest.approx((0.0, 0.0, 1.0)) and linear[0] != linear[0]
    position, *_ = free.body.link_motion("two")
    assert position[2] == pytest.approx(2.0, abs=1e-3)
    world.close()

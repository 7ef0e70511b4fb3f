"""PyBullet's copies of bodies that the solver 'ode' moves: made late, equal, without an effect."""

import itertools
import random

import pytest
from bullet_sim.engine import Engine, make_engine
from bullet_sim.errors import ModelError
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World

INERTIAL = (
    '<inertial><origin xyz="0.1 -0.2 0.3" rpy="0 0 0.4"/><mass value="1"/>'
    '<inertia ixx="1" ixy="0" ixz="0" iyy="1.1" iyz="0" izz="0.9"/></inertial>'
)
SHAPE = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
KINDS = ("revolute", "continuous", "prismatic", "fixed")
LIMIT = '<limit lower="-1" upper="1" effort="10" velocity="10"/>'


def joint(name, kind, parent, child):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>{LIMIT}</joint>'
    )


def tree(seed):
    """URDF of a tree of links, elements in any order."""
    rng = random.Random(seed)
    count = rng.randint(2, 9)
    parts = [f'<link name="l{k}">{INERTIAL}{SHAPE}</link>' for k in range(count)]
    parts += [
        joint(f"j{k}", rng.choice(KINDS), f"l{rng.randrange(k)}", f"l{k}") for k in range(1, count)
    ]
    rng.shuffle(parts)
    return '<robot name="tree">\n' + "\n".join(parts) + "\n</robot>\n"


@pytest.fixture(name="nobody_connects")
def _nobody_connects(monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("a client of PyBullet was connected")

    monkeypatch.setattr("pybullet.connect", refuse)


@pytest.fixture(name="engines")
def _engines():
    made = make_engine("ode"), Engine()
    yield made
    for engine in made:
        engine.close()


@pytest.mark.parametrize("seed", range(8))
def test_links_and_joints_have_pybullets_order(engines, tmp_path, seed):
    path = tmp_path / "tree.urdf"
    path.write_text(tree(seed))
    ours, theirs = (engine.load(str(path), (1.0, 2.0, 3.0)) for engine in engines)
    ode, bullet = engines
    assert list(ode.link_indices(ours).items()) == list(bullet.link_indices(theirs).items())
    assert ode.joint_names(ours) == bullet.joint_names(theirs)
    assert ode.movable[ours] == bullet.movable[theirs]
    assert ode.layout == bullet.layout
    for one, other in zip(ode.link_motion(ours, -1), bullet.link_motion(theirs, -1)):
        assert one == pytest.approx(other, abs=1e-12)


@pytest.mark.parametrize(
    "text, words",
    [
        ("<robot", "cannot be loaded"),
        ('<robot name="r"/>', "there are 0 links without a joint above them"),
        ('<robot name="r"><link name="a"/><link name="b"/></robot>', "there are 2 links"),
        (
            f'<robot name="r"><link name="a"/>{joint("j", "fixed", "a", "b")}</robot>',
            "joint 'j' has the links 'a' and 'b'; links are a",
        ),
    ],
)
def test_files_that_are_no_tree_of_links(engines, tmp_path, text, words):
    path = tmp_path / "bad.urdf"
    path.write_text(text)
    with pytest.raises(ModelError, match=words):
        engines[0].load(str(path))


def test_numbers_of_bodies_are_pybullets(engines, tmp_path):
    path = tmp_path / "tree.urdf"
    path.write_text(tree(1))
    found = [[] for _ in engines]
    for engine, numbers in zip(engines, found):
        numbers += [engine.load(str(path)) for _ in range(5)]
        for body in (1, 3, 0):
            engine.remove(body)
        numbers.append(engine.load(str(path)))
    ode, bullet = engines
    for body in (0, 2, 4):  # the first connects, while some numbers are free
        assert Engine.link_indices(ode, body) == ode.link_indices(body)
    for engine, numbers in zip(engines, found):
        numbers += [engine.load(str(path)) for _ in range(3)]
    assert found[0] == found[1]
    assert ode.layout == bullet.layout


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
        (name, world.engine.link_motion(model.body, index))
        for name, model in world.models.items()
        for index in model.engine.link_indices(model.body).values()
        if not model.is_static or index < 0
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
    assert asked.engine.client >= 0
    for world in (plain, asked):
        act(world)
    asked.engine.client  # noqa: B018
    assert motions(plain) == motions(asked)
    for world in (plain, asked):
        world.close()


def test_copies_are_where_the_bodies_are():
    world = scene()
    act(world)
    engine = world.engine

    def check():
        for model in world.models.values():
            places, turns = engine.link_poses(model.body)
            for index in range(-1, len(places) - 1):
                place, turn, *_ = engine.link_motion(model.body, index)
                assert places[index + 1] == pytest.approx(place, abs=1e-5), (model.name, index)
                same = abs(sum(a * b for a, b in zip(turns[index + 1], turn)))
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
            assert world.engine.client >= 0
        state = world.save_state()
        if after:
            assert world.engine.client >= 0
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
    world.engine.ode.refresh()  # its arrays
    world.engine.ode.bodies[:, :3] = float("nan")
    world.step(1)
    position, _, linear, _ = world.engine.link_motion(free.body, -1)
    assert position == pytest.approx((0.0, 0.0, 1.0)) and linear[0] != linear[0]
    position, *_ = world.engine.link_motion(free.body, 1)
    assert position[2] == pytest.approx(2.0, abs=1e-3)
    world.close()

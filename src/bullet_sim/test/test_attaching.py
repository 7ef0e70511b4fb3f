"""Links of two models that are attached to each other, and let go again."""

import math

import pytest
from bullet_sim.errors import ModelError, WorldError
from bullet_sim.formats.sdf.world import ground_plane
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import joint, link, robot

SIZE = 0.2


def block(mass=1.0, static=False, center=0.0):
    moment = mass * SIZE**2 / 6.0
    inertia = "".join(f"<{key}>{moment}</{key}>" for key in ("ixx", "iyy", "izz"))
    return (
        f'<sdf version="1.6"><model name="m"><static>{int(static)}</static><link name="l">'
        f"<inertial><pose>{center} 0 0 0 0 0</pose><mass>{mass}</mass><inertia>{inertia}</inertia>"
        f'</inertial><collision name="c"><geometry><box><size>{SIZE} {SIZE} {SIZE}</size></box>'
        "</geometry></collision></link></model></sdf>"
    )


ARM = robot(
    '<link name="world"/>', link("post", 5, 1), joint("f", "fixed", "world", "post"),
    link("hand", 2, center="0.3 0 0"), joint("j", "continuous", "post", "hand"),
)  # fmt: skip
SOLVERS = ("ode", "bullet")


def spawned(world, name, place, rpy=(0.0, 0.0, 0.0), **values):
    return world.spawn_sdf(name, block(**values), Pose.from_xyz_rpy(place, rpy), str)


def relative(one, other):
    return one.pose.inverse() * other.pose


def angle(pose):
    """Of its rotation [rad]."""
    return 2.0 * math.acos(min(1.0, abs(pose.orientation[3])))


def test_what_hangs_on_a_post_stays_where_it_is_until_it_is_let_go(world):
    spawned(world, "post", (0.0, 0.0, 2.0), static=True)
    load = spawned(world, "load", (0.5, 0.2, 1.8), (0.3, -0.2, 0.9), center=0.05)
    before = load.pose
    world.attach("key", "post", "l", "load", "l")
    world.step(1000)
    assert load.pose.position == pytest.approx(before.position, abs=2e-3)
    assert angle(before.inverse() * load.pose) < 5e-3
    assert world.engine.detach("key")
    world.step(400)
    assert load.pose.position[2] == pytest.approx(before.position[2] - 0.5 * 9.81 * 0.16, abs=0.03)


def test_two_bodies_fall_and_turn_as_one(world):
    one = spawned(world, "one", (0.0, 0.0, 3.0), (0.1, 0.2, 0.3))
    two = spawned(world, "two", (0.4, 0.1, 3.1), (0.0, -0.5, 0.2), mass=0.5, center=-0.03)
    there = relative(one, two)
    world.attach("key", "one", "l", "two", "l")
    two.set_velocity((0.0, 1.0, 0.5), (0.0, 0.0, 2.0))
    world.step(500)
    assert relative(one, two).position == pytest.approx(there.position, abs=5e-3)
    assert angle(there.inverse() * relative(one, two)) < 0.02
    middle = [(a + 0.5 * b) / 1.5 for a, b in zip(one.pose.position, two.pose.position)]
    assert middle[1] == pytest.approx(0.1 / 3 + 0.5 / 3, abs=0.02)  # a third of the mass had 1 m/s


def test_attached_bodies_do_not_collide(world):
    """They overlap, and are not pushed apart, until they are let go."""
    world.spawn(ground_plane())
    one = spawned(world, "one", (0.0, 0.0, 0.1))
    two = spawned(world, "two", (0.15, 0.0, 0.1))
    world.attach("key", "one", "l", "two", "l")
    world.step(500)
    gap = two.pose.position[0] - one.pose.position[0]
    assert gap == pytest.approx(0.15, abs=3e-3)
    world.engine.detach("key")
    world.step(2000)
    assert two.pose.position[0] - one.pose.position[0] > 0.155


def test_it_hangs_on_a_moving_arm_and_loads_its_joint():
    world = World()
    world.spawn_urdf("arm", ARM, Pose((0.0, 0.0, 2.0)), str)
    arm = world.models["arm"]
    load = spawned(world, "load", (0.6, 0.0, 2.0))
    world.attach("key", "arm", "hand", "load", "l")
    there = arm.link_state("hand")[0].inverse() * load.pose
    arm.joints.set_motor("j", 1.0, 100.0)
    world.step(1000)
    hand = arm.link_state("hand")[0]
    assert arm.joints.state()[0]["j"] == pytest.approx(1.0, abs=0.01)
    assert (hand.inverse() * load.pose).position == pytest.approx(there.position, abs=3e-3)
    arm.body.motor(arm.body.joints[0]).track_velocity(0.0, 100.0)
    world.step(500)
    turned = math.cos(arm.joints.state()[0]["j"])
    moment = 9.81 * (2.0 * 0.3 + 1.0 * 0.6) * turned
    assert abs(arm.body.motor("j").load()[2]) == pytest.approx(moment, rel=0.02)
    world.close()


def test_a_position_that_is_imposed_moves_what_is_attached_below():
    world = World(gravity=(0.0, 0.0, 0.0))
    arm = world.spawn_urdf("arm", ARM, Pose((0.0, 0.0, 2.0)), str)
    load = spawned(world, "load", (0.6, 0.0, 2.0))
    chain = spawned(world, "chain", (0.9, 0.0, 2.0))
    world.attach("second", "load", "l", "chain", "l")  # before the first: the order has no effect
    world.attach("first", "arm", "hand", "load", "l")
    arm.body.motor(arm.body.joints[0]).track_position(-0.5, 100.0, 1e3)
    world.step(10)
    for model, radius in ((load, 0.6), (chain, 0.9)):
        expected = (radius * math.cos(0.5), 0.0, 2.0 + radius * math.sin(0.5))
        assert model.pose.position == pytest.approx(expected, abs=0.01)
    world.close()


def test_attached_again_it_comes_back_to_where_it_was_first():
    world = World(gravity=(0.0, 0.0, 0.0))
    spawned(world, "post", (0.0, 0.0, 2.0), static=True)
    load = spawned(world, "load", (0.5, 0.0, 2.0))
    world.attach("key", "post", "l", "load", "l")
    world.engine.detach("key")
    load.set_velocity((0.1, 0.0, 0.0))
    world.step(1000)
    assert load.pose.position[0] == pytest.approx(0.6, abs=1e-3)
    assert world.engine.attach_again("key")
    world.step(1000)
    assert load.pose.position[0] == pytest.approx(0.5, abs=5e-3)
    world.close()


def test_states_have_it():
    world = World()
    spawned(world, "post", (0.0, 0.0, 2.0), static=True)
    load = spawned(world, "load", (0.5, 0.0, 2.0))
    free = world.save_state()
    world.attach("key", "post", "l", "load", "l")
    world.step(10)
    held = world.save_state()
    world.step(50)
    there = load.pose
    assert world.restore_state(held) == ""
    world.step(50)
    assert load.pose == there
    world.restore_state(free)
    world.step(100)
    assert load.pose.position[2] < 1.96
    world.restore_state(held)
    world.step(100)
    assert load.pose.position[2] == pytest.approx(2.0, abs=2e-3)
    world.close()


def test_saving_disturbs_nothing_and_what_is_restored_goes_on_to_the_bit():
    """Two blocks, one held at the other's side, fall onto the ground and rock."""
    paths = []
    for saves in (False, True):
        world = World()
        world.spawn(ground_plane())
        spawned(world, "one", (0.0, 0.0, 0.2))
        other = spawned(world, "other", (0.19, 0.0, 0.25))
        world.attach("key", "one", "l", "other", "l")
        world.step(150)
        state = world.save_state() if saves else None
        world.step(100)
        paths.append(other.pose)
        if saves:
            assert world.restore_state(state) == ""
            world.step(100)
            paths.append(other.pose)
        world.close()
    assert paths[0] == paths[1] == paths[2]


def test_it_lasts_when_models_are_sorted_before_the_first_step(world):
    other = spawned(world, "z", (0.5, 0.0, 2.0))
    spawned(world, "a", (0.0, 0.0, 2.0), static=True)
    world.attach("key", "a", "l", "z", "l")
    assert world.sort_before_start()
    world.step(500)
    assert other.pose.position == pytest.approx((0.5, 0.0, 2.0), abs=2e-3)
    assert list(world.engine.attachments()) == ["key"]
    world.engine.detach("key")
    assert world.engine.attachments() == {}


def test_deleted_models_hold_nothing(world):
    spawned(world, "post", (0.0, 0.0, 2.0), static=True)
    spawned(world, "load", (0.5, 0.0, 2.0))
    other = spawned(world, "other", (0.8, 0.0, 2.0))
    world.attach("key", "load", "l", "other", "l")
    world.delete("load")
    assert not world.engine.detach("key")
    world.step(100)
    assert other.pose.position[2] < 1.96


def test_what_rests_wakes_and_stays_awake_while_it_is_attached():
    world = World()
    world.spawn(ground_plane())
    post = spawned(world, "post", (0.0, 0.0, 2.0), static=True)
    load = spawned(world, "load", (0.5, 0.0, 0.1))
    world.step(3000)
    assert load.body.is_resting() and post
    world.attach("key", "post", "l", "load", "l")
    assert not load.body.is_resting()
    world.engine.set_gravity((0.0, 0.0, 9.81))
    world.step(3000)
    assert load.pose.position == pytest.approx((0.5, 0.0, 0.1), abs=2e-3)
    assert not load.body.is_resting()
    world.close()


def test_unknown_names_are_refused(world):
    spawned(world, "one", (0.0, 0.0, 2.0))
    with pytest.raises(WorldError, match="'two' does not exist"):
        world.attach("key", "one", "l", "two", "l")
    spawned(world, "two", (0.0, 0.0, 3.0))
    with pytest.raises(ModelError, match="no link 'x'"):
        world.attach("key", "one", "x", "two", "l")
    assert not world.engine.attach_again("key") and not world.engine.detach("key")

"""Spawned inside something, masks of what may touch, weightless links, models that go astray."""

import functools
import math

import pytest
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.models.release import SPEED
from bullet_sim.pose import Pose
from contact_scenes import friction, ground, nowhere, sdf_box, skid_base, world_of

world_of = functools.partial(world_of, solver="bullet")

RADIUS = 0.2


def heights(world, name, time, every=20):
    """Heights [m] of a model's root link over some time [s]."""
    found = []
    for _ in range(round(time / world.time_step / every)):
        world.step(every)
        found.append(world.models[name].pose.position[2])
    return found


@pytest.mark.parametrize("depth", [0.002, 0.02, 0.1, 0.235])
@pytest.mark.parametrize("step", [0.001, 0.004])
def test_a_base_spawned_in_the_ground_comes_up_gently(depth, step):
    base = skid_base(48.0, 0.3, 0.3, RADIUS, 1.0)
    world = world_of((ground(), None), (base, Pose((1, 2, RADIUS - depth))), step=step)
    found = heights(world, "skid", 3.0)
    x, y, z = world.models["skid"].pose.position
    world.close()
    assert max(found) < RADIUS + 0.05
    assert max(b - a for a, b in zip(found, found[1:])) < 1.5 * SPEED * 20 * step
    assert z == pytest.approx(RADIUS, abs=0.002)
    assert (x, y) == pytest.approx((1.0, 2.0), abs=0.02)


@pytest.mark.parametrize("height", [RADIUS - 0.02, 0.1, 0.0, -0.05, -0.09])
def test_a_base_spawned_in_a_thin_slab_is_not_trapped(height):
    slab = sdf_box("slab", (5.0, 5.0, 0.1), static=True)
    base = skid_base(20.0, 0.3, 0.3, RADIUS, 1.0)
    world = world_of((slab, Pose((0, 0, -0.05))), (base, Pose((0, 0, height))))
    found = heights(world, "skid", 4.0)
    world.close()
    assert max(found) < RADIUS + 0.05
    assert found[-1] == pytest.approx(RADIUS, abs=0.002)


def test_a_box_spawned_in_a_wall_leaves_it_sideways():
    wall = sdf_box("wall", (0.2, 4.0, 2.0), static=True)
    box = sdf_box("box", (0.4, 0.4, 0.4))
    world = world_of((ground(), None), (wall, Pose((0, 0, 1.0))), (box, Pose((0.25, 0, 0.2))))
    found = heights(world, "box", 3.0)
    x, y, _ = world.models["box"].pose.position
    world.close()
    assert max(found) < 0.25
    assert x == pytest.approx(0.3, abs=0.02) and y == pytest.approx(0.0, abs=0.02)


def test_two_boxes_in_one_place_part_slowly():
    boxes = [sdf_box(name, (0.4, 0.4, 0.2)) for name in ("a", "b")]
    world = world_of((ground(), None), *((box, Pose((0, 0, 0.1))) for box in boxes))
    highest = 0.0
    for _ in range(200):
        world.step(20)
        highest = max(highest, *(world.models[n].pose.position[2] for n in "ab"))
    a, b = (world.models[n].pose.position for n in "ab")
    world.close()
    assert highest < 0.15
    assert 0.39 < math.dist(a, b) < 0.6


def test_max_vel_of_the_file_counts():
    slow = "<contact><ode><max_vel>0.02</max_vel></ode></contact>" + friction(1.0)
    world = world_of(
        (ground(), None), (sdf_box("box", (0.4, 0.4, 0.4), surface=slow), Pose((0, 0, 0.1)))
    )
    found = heights(world, "box", 2.0)
    assert found[-1] == pytest.approx(0.1 + 2.0 * 0.02, abs=0.005)
    found = heights(world, "box", 5.0)
    world.close()
    assert found[-1] == pytest.approx(0.2, abs=0.002)


def test_min_depth_is_left_alone():
    deep = "<contact><ode><min_depth>0.03</min_depth></ode></contact>"
    box = sdf_box("box", (0.4, 0.4, 0.4), surface=deep)
    world = world_of((ground(), None), (box, Pose((0, 0, 0.18))), gravity=(0, 0, -0.001))
    world.step(1)
    velocity = world.models["box"].link_motion("l")[2]
    world.close()
    assert velocity[2] != pytest.approx(SPEED, rel=0.5)  # it is not being moved out


def test_a_model_that_is_set_into_the_ground_comes_up_too():
    world = world_of((ground(), None), (sdf_box("box", (0.4, 0.4, 0.4)), Pose((0, 0, 0.2))))
    world.step(100)
    world.models["box"].set_state(Pose((1, 1, 0.0)))
    found = heights(world, "box", 3.0)
    world.close()
    assert max(found) < 0.25 and found[-1] == pytest.approx(0.2, abs=0.002)


def mask(bits):
    return f"<contact><collide_bitmask>{bits}</collide_bitmask></contact>"


@pytest.mark.parametrize(
    "first, second, touch",
    [
        ("0x01", "0x02", False),
        ("0x01", "0x01", True),
        ("0x01", "0x03", True),
        ("1", "2", False),
        (None, "0x02", True),
        (None, "0x00", False),
    ],
)
def test_bitmasks(first, second, touch):
    """A box falls onto another, or through it."""
    surfaces = ["" if bits is None else mask(bits) for bits in (first, second)]
    lower = sdf_box("lower", (0.4, 0.4, 0.2), mass=10.0, surface=surfaces[0])
    upper = sdf_box("upper", (0.2, 0.2, 0.2), surface=surfaces[1])
    world = world_of((ground(), None), (lower, Pose((0, 0, 0.1))), (upper, Pose((0, 0, 0.4))))
    world.step(1000)
    z = world.models["upper"].pose.position[2]
    world.close()
    if second == "0x00":
        assert z < -1.0  # touches not even the ground
    else:
        assert z == pytest.approx(0.3 if touch else 0.1, abs=0.005)


def test_cars_with_masks_of_their_own_stand_in_one_place():
    cars = [sdf_box(f"car{bit}", (0.4, 0.2, 0.2), surface=mask(hex(1 << bit))) for bit in range(4)]
    world = world_of((ground(), None), *((car, Pose((0, 0, 0.1))) for car in cars))
    world.step(1000)
    places = [world.models[f"car{bit}"].pose.position for bit in range(4)]
    world.close()
    for place in places:
        assert place == pytest.approx((0.0, 0.0, 0.1), abs=1e-3)


def test_a_link_without_gravity_floats_and_a_model_has_the_weight_of_the_others():
    world = world_of(
        (sdf_box("balloon", (0.2, 0.2, 0.2), more="<gravity>false</gravity>"), Pose((0, 0, 5))),
        (sdf_box("stone", (0.2, 0.2, 0.2)), Pose((2, 0, 5))),
    )
    two = (
        '<sdf version="1.6"><model name="two">'
        + "".join(
            f'<link name="{name}"><pose>{x} 0 0 0 0 0</pose><gravity>{on}</gravity><inertial><mass>'
            "1</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>"
            "</link>"
            for name, x, on in (("a", 0, "true"), ("b", 1, "false"))
        )
        + '<joint name="j" type="fixed"><parent>a</parent><child>b</child></joint></model></sdf>'
    )
    world.spawn(parse_model(two, nowhere, "two")[0], Pose((4, 0, 5)))
    world.step(500)
    drop = {name: 5 - model.pose.position[2] for name, model in world.models.items()}
    turn = world.models["two"].link_motion("a")[3]
    world.close()
    assert drop["stone"] == pytest.approx(0.5 * 9.81 * 0.25, rel=0.01)
    assert abs(drop["balloon"]) < 1e-9
    # half the weight at one end: it falls at half of g and turns to that side
    assert turn[1] < -1.0


@pytest.mark.parametrize(
    "state, words",
    [
        ((Pose((0, 0, 5)), (0, 0, 900.0)), "moves at"),
        ((Pose((0, 0, -5000.0)), (0, 0, 0)), "has left"),
    ],
)
def test_a_model_that_goes_astray_is_said_once(state, words):
    world = world_of((sdf_box("kite", (0.1, 0.1, 0.1)), Pose((0, 0, 5))))
    said = []
    world.contacts.on_implausible = said.append
    world.step(300)
    assert said == []
    world.models["kite"].set_state(*state)
    world.step(2000)
    assert len(said) == 1 and "'kite'" in said[0] and words in said[0]
    world.reset()
    world.models["kite"].set_state(*state)
    world.step(600)
    world.close()
    assert len(said) == 2


def test_release_is_the_same_after_a_reset():
    world = world_of((ground(), None), (sdf_box("box", (0.4, 0.4, 0.4)), Pose((0, 0, 0.05))))
    first = heights(world, "box", 1.0)
    world.reset()
    assert heights(world, "box", 1.0) == first
    world.close()

"""Contacts: forces that carry weights, and which shape of a merged link is meant."""

import numpy as np
import pytest
from bullet_sim.description.collisions import collision_names
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.contacts import ContactSpec
from bullet_sim.pose import Pose
from bullet_sim.sensors.contact import distance, nearest, watched
from bullet_sim.world import World
from urdf_texts import inertial

pytestmark = pytest.mark.usefixtures("sketches")

MASS = inertial(2, 0.02)
ROBOT = (
    f'<robot name="r"><link name="base">{MASS}<collision><geometry><box size="0.4 0.2 0.1"/>'
    '</geometry></collision></link><link name="bumper"><collision><geometry>'
    '<box size="0.02 0.2 0.1"/></geometry></collision><collision><origin xyz="0 0 0.2"/>'
    '<geometry><sphere radius="0.05"/></geometry></collision></link>'
    '<joint name="j" type="fixed"><parent link="base"/><child link="bumper"/>'
    '<origin xyz="0.21 0 0"/></joint></robot>'
)


@pytest.fixture(name="world", params=["ode", "bullet"])
def _world(request):
    world = World(solver=request.param)
    world.spawn(sdf.ground_plane())
    yield world
    world.close()


def test_contact_forces_carry_the_weight(world):
    model = world.spawn_urdf("r", ROBOT, Pose((0.0, 0.0, 0.05)), str)
    world.step(500)
    totals = []
    for _ in range(200):  # the force of a single step is as far as the solver has come in it
        world.step()
        contacts = model.body.contacts(model.link_in_body("base")[0])
        totals.append(sum(contact.force for contact in contacts))
    assert np.mean(totals, axis=0) == pytest.approx((0, 0, 2 * 9.81), abs=0.2)
    for contact in contacts:
        np.testing.assert_allclose(contact.normal, (0, 0, 1), atol=1e-6)
        assert contact.position[2] == pytest.approx(0, abs=0.002)
        assert abs(contact.depth) < 0.002


def test_friction_acts_against_the_motion(world):
    model = world.spawn_urdf("r", ROBOT, Pose((0.0, 0.0, 0.05)), str)
    world.step(200)
    model.set_state(model.pose, (1.0, 0.0, 0.0))
    world.step(5)
    contacts = model.body.contacts(model.link_in_body("base")[0])
    assert sum(contact.force for contact in contacts)[0] < -1.0


def test_a_dropped_box_without_an_inertia_comes_to_rest_on_the_ground(world):
    shape = "<collision><geometry><box size='0.4 0.4 0.4'/></geometry></collision>"
    text = f"<robot name='box'><link name='base'><inertial/>{shape}</link></robot>"
    model = world.spawn_urdf("box", text, Pose((3.0, 0.0, 1.0)), str)
    world.step(1000)
    assert model.pose.position[2] == pytest.approx(0.2, abs=0.002)


def test_no_contact_in_the_air(world):
    model = world.spawn_urdf("r", ROBOT, Pose((0.0, 0.0, 2.0)), str)
    world.step(10)
    assert model.body.contacts(model.root) == []


PLAIN = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
LUMP = "base_fixed_joint_lump__bumper_collision"


@pytest.mark.parametrize(
    "names, expected, missing",
    [
        ((), {f"base::{LUMP}_1", f"base::{LUMP}_2"}, []),
        (("base_collision",), {"base::base_collision"}, []),
        (("r::base::base_collision",), set(), ["r::base::base_collision"]),
        (("bumper_collision",), set(), ["bumper_collision"]),
        (("bumper_collision_1",), set(), ["bumper_collision_1"]),
        ((f"{LUMP}_1",), {f"base::{LUMP}_1"}, []),
        (("nose", f"{LUMP}_2", "base_collision"), {f"base::{LUMP}_2", "base::base_collision"},
         ["nose"]),
        (("__default__",), set(), ["__default__"]),
    ],
)  # fmt: skip
def test_names_of_collisions_are_those_of_the_sensors_link_in_gazebo(names, expected, missing):
    """Gazebo 11.1: sensors of other names are silent, all of them alike."""
    found = watched(ContactSpec("s", "bumper", names), parse_urdf(ROBOT, str))
    assert found == (expected, missing)


def test_a_collision_of_another_link_is_none_of_the_sensors():
    arm = PLAIN.join((f'<link name="arm">{MASS}', "</link>"))
    joint = '<joint name="a" type="continuous"><parent link="base"/><child link="arm"/></joint>'
    model = parse_urdf(ROBOT.replace("</robot>", f"{arm}{joint}</robot>"), str)
    assert watched(ContactSpec("s", "base", ("arm_collision",)), model) == (
        set(),
        ["arm_collision"],
    )
    assert watched(ContactSpec("s", "arm", ("arm_collision",)), model)[0] == {"arm::arm_collision"}


@pytest.mark.parametrize(
    "point, name",
    [
        ((0.221, 0.0, 0.0), "bumper_collision"),
        ((-0.2, 0.05, 0.0), "base_collision"),
        ((0.21, 0.0, 0.251), "bumper_collision_1"),
        ((0.0, 0.0, -0.05), "base_collision"),
    ],
)
def test_point_belongs_to_the_shape_it_is_on(world, point, name):
    model = world.spawn_urdf("r", ROBOT, Pose((0.0, 0.0, 1.0)), str)
    link, _ = model.link_in_body("bumper")
    shape = nearest(model.rigid_parts[link].collisions, point)
    assert link == "base" and shape.name == name
    assert distance(shape, point) < 0.0011


GIVEN = '<collision name="{}"><geometry><box size="1 1 1"/></geometry></collision>'
MISSING = '<collision><geometry><mesh filename="/no/such/file.stl"/></geometry></collision>'


def test_names_of_a_urdfs_collisions_are_sdformats():
    """Expected: gz sdf -p of Gazebo 11.1 of this text."""
    shapes = {
        "base": PLAIN + GIVEN.format("base_b") + GIVEN.format("foo") + MISSING,
        "mid": PLAIN,
        "top": GIVEN.format("rubber") + PLAIN,
        "a": PLAIN,
    }
    links = "".join(f'<link name="{name}">{MASS}{each}</link>' for name, each in shapes.items())
    fixed = '<joint name="{}" type="fixed"><parent link="{}"/><child link="{}"/></joint>'
    joints = "".join(
        fixed.format(*each)
        for each in (("z", "base", "mid"), ("y", "mid", "top"), ("b", "base", "a"))
    )
    model = parse_urdf(f'<robot name="r">{links}{joints}</robot>', str)
    assert list(collision_names(model).values()) == [
        "base::base_collision",
        "base::base_b_collision_1",
        "base::base_fixed_joint_lump__foo_collision_2",
        "base::base_collision_3",
        "base::base_fixed_joint_lump__a_collision_4",
        "base::base_fixed_joint_lump__mid_collision_5",
        "base::base_fixed_joint_lump__rubber_collision_6",
        "base::base_fixed_joint_lump__top_collision_7",
    ]


def test_a_collision_whose_mesh_is_missing_has_a_name_and_no_shape():
    mesh = "<geometry><mesh><uri>/no/such/file.stl</uri></mesh></geometry>"
    box = "<geometry><box><size>1 1 1</size></box></geometry>"
    text = (
        f"<sdf version='1.6'><model name='m'><link name='k'><collision name='one'>{mesh}"
        f"</collision><collision name='two'>{box}</collision></link></model></sdf>"
    )
    model, _ = sdf.parse_model(text, str, "m")
    assert list(collision_names(model).values()) == ["k::one", "k::two"]
    assert [shape.name for shape in model.links["k"].collisions] == ["two"]


def grate(name, count, along):
    """SDF of a model of parallel bars [m]."""
    size, place = ("1 0.1 0.1", "0 {} 0") if along == "x" else ("0.1 1 0.1", "{} 0 0")
    bars = "".join(
        f'<collision name="{bar}"><pose>{place.format(0.2 * bar)} 0 0 0</pose><geometry><box>'
        f"<size>{size}</size></box></geometry></collision>"
        for bar in range(count)
    )
    return f'<sdf version="1.6"><model name="{name}"><link name="l">{bars}</link></model></sdf>'


@pytest.mark.parametrize("below, above", [(2, 3), (3, 2)])
def test_shapes_of_the_model_that_has_fewer_are_gone_through_once(below, above):
    """As in ODE, where the space with fewer shapes is that of the outer loop."""
    world = World(gravity=(0.0, 0.0, 0.0))
    world.spawn_sdf("below", grate("below", below, "x"), Pose(), str)
    world.spawn_sdf("above", grate("above", above, "y"), Pose((0.0, 0.0, 0.099)), str)
    world.step()
    places = world.engine.all_contacts()[0] / 0.2
    world.close()
    outer = np.rint(places[:, 1 if below < above else 0]).astype(int)
    assert outer.tolist() == [1] * 12 + [0] * 12

"""Scenes and views of a world: what pages and recorders show."""

import json

import numpy as np
import pytest
from bullet_sim.description.world import ground_plane
from bullet_sim.pose import Pose
from bullet_sim.sensors import scenes
from bullet_sim.sensors.scenes import WorldViews
from bullet_sim.world import World

CART = """<robot name="cart">
  <link name="chassis"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><box size="0.4 0.2 0.1"/></geometry></visual></link>
  <link name="mast"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
  <joint name="bolt" type="fixed"><parent link="chassis"/><child link="mast"/>
    <origin xyz="0 0 0.5"/></joint>
  <link name="slide"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="rail" type="prismatic"><parent link="chassis"/><child link="slide"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="10" velocity="1"/></joint>
</robot>"""

BLOCK = """<robot name="block"><link name="l">
  <inertial><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link></robot>"""


@pytest.fixture
def world():
    made = World()
    made.spawn(ground_plane())
    made.spawn_urdf("cart", CART, Pose((1.0, 0.0, 2.0)), str)
    yield made
    made.close()


def test_a_view_has_what_can_move(world):
    views = WorldViews(world)
    world.model("cart").body.set_joint_positions([0.25])
    view = views.view()
    assert (view["time"], view["scene"]) == (0.0, 1)
    (row,) = view["bodies"]
    assert row == pytest.approx([2, 1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.25])
    world.step(100)
    later = views.view()
    assert later["time"] == pytest.approx(0.1)
    assert later["bodies"][0][3] < 2.0 and later["scene"] == 1
    assert json.loads(json.dumps(later)) == later


def test_a_scene_has_links_joints_and_merged_frames(world):
    scene = json.loads(json.dumps(WorldViews(world).scene()))
    ground, cart = scene["bodies"]
    assert (ground["name"], ground["static"], cart["static"]) == ("ground_plane", True, False)
    (floor,) = ground["links"][0]["shapes"]
    assert floor["color"] == [0.7, 0.7, 0.7, 1.0]  # Gazebo/Grey
    chassis, slide = cart["links"]
    assert [len(link["shapes"]) for link in cart["links"]] == [2, 0]
    assert (slide["name"], slide["joint"], slide["kind"], slide["parent"]) == (
        "slide",
        "rail",
        "prismatic",
        0,
    )
    assert cart["frames"]["mast"] == [0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0]
    assert cart["frames"]["slide"][0] == 1
    assert scene["light"]["lights"][0]["name"] == "sun"


def test_the_number_changes_with_the_models_and_with_fixed_ones_that_are_moved(world):
    views = WorldViews(world)
    assert [views.view()["scene"], views.scene()["number"], views.view()["scene"]] == [1, 1, 1]
    world.step(10)
    assert views.view()["scene"] == 1
    world.spawn_urdf("other", CART, Pose((5.0, 0.0, 1.0)), str)
    assert views.view()["scene"] == 2
    world.delete("other")
    assert views.scene()["number"] == 3
    world.model("ground_plane").set_state(Pose((0.0, 0.0, -1.0)))
    assert views.view()["scene"] == 4
    assert views.scene()["bodies"][0]["state"][3] == -1.0


def test_a_body_whose_place_is_no_number_is_left_out(world, monkeypatch):
    views = WorldViews(world)
    broken = world.model("cart").state()
    broken = type(broken)(broken.key, (float("nan"), 0.0, 0.0), broken.orientation, broken.joints)
    monkeypatch.setattr(world.model("cart"), "state", lambda: broken)
    assert views.view()["bodies"] == []


def test_contacts_are_where_bodies_press(world):
    views = WorldViews(world)
    assert views.contacts() == {"contacts": []}  # it is still in the air
    world.spawn_urdf("block", BLOCK, Pose((5.0, 1.0, 0.1)), str)
    world.step(200)
    own = [row for row in views.contacts()["contacts"] if row[0] > 4.0]
    assert own == sorted(own, key=lambda row: -row[6])
    for x, y, z, nx, ny, nz, force in own:
        assert (abs(x - 5.0), abs(y - 1.0)) == pytest.approx((0.1, 0.1), abs=0.005)
        assert z == pytest.approx(0.0, abs=1e-3)
        assert (nx, ny, abs(nz)) == pytest.approx((0.0, 0.0, 1.0), abs=1e-3)
        assert force > 0.0
    assert sum(row[6] for row in own) == pytest.approx(9.81, rel=0.05)
    assert json.loads(json.dumps(views.contacts())) == views.contacts()


def test_contacts_have_numbers_and_a_bound(world, monkeypatch):
    count = scenes.MAX_CONTACTS + 5
    forces = np.arange(1.0, count + 1)
    places, normals = np.zeros((count, 3)), np.tile([0.0, 0.0, 1.0], (count, 1))
    places[-1, 0] = np.nan
    monkeypatch.setattr(world.engine, "all_contacts", lambda: (places, normals, forces))
    rows = WorldViews(world).contacts()["contacts"]
    assert len(rows) == scenes.MAX_CONTACTS
    assert [row[6] for row in rows[:2]] == [count - 1, count - 2]


def test_looking_changes_nothing():
    def heights(look):
        world = World()
        try:
            world.spawn(ground_plane())
            world.spawn_urdf("cart", CART, Pose((0.0, 0.0, 0.3)), str)
            views, found = WorldViews(world), []
            for _ in range(50):
                world.step(10)
                if look:
                    views.view()
                    views.scene()
                    views.contacts()
                found.append(world.model("cart").state())
            return found
        finally:
            world.close()

    assert heights(False) == heights(True)

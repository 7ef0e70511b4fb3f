"""Scenes and views of a world: what pages and recorders show."""

import json

import pytest
from bullet_sim.description.world import ground_plane
from bullet_sim.pose import Pose
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


@pytest.fixture
def world():
    made = World()
    made.spawn(ground_plane())
    made.spawn_urdf("cart", CART, Pose((1.0, 0.0, 2.0)), str)
    yield made
    made.close()


def test_a_view_has_what_can_move(world):
    views = WorldViews(world)
    world.engine.set_joint_positions(world.model("cart").body, [0.25])
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
                found.append(world.model("cart").state())
            return found
        finally:
            world.close()

    assert heights(False) == heights(True)

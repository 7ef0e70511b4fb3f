"""Links that no joint connects with the others of their model: bodies of their own."""

import numpy as np
import pytest
from bullet_sim.engine.api import Rays
from bullet_sim.kinematics import Kinematics, pose_matrix
from bullet_sim.pose import Pose
from bullet_sim.world import World

LINK = (
    '<link name="{0}"><pose>{1}</pose><inertial><mass>1</mass><inertia><ixx>0.01</ixx><iyy>0.01'
    '</iyy><izz>0.01</izz></inertia></inertial><collision name="c"><geometry><box><size>0.2 0.2 0.2'
    '</size></box></geometry></collision><visual name="v"><geometry><box><size>0.2 0.2 0.2</size>'
    "</box></geometry></visual></link>"
)
SDF = (
    '<sdf version="1.6"><model name="m">'
    + LINK.format("a", "0 0 2 0 0 0")
    + LINK.format("b", "1 0 3 0.3 0.2 0.1")
    + LINK.format("c", "-1 0 2 0 0 0.4")
    + LINK.format("d", "-1 0.5 2 0 0 0.4")
    + '<joint name="swing" type="revolute"><parent>c</parent><child>d</child><axis><xyz>0 1 0</xyz>'
    "</axis></joint></model></sdf>"
)
FALL = 0.5 * 9.81 * 0.1**2  # [m] in 0.1 s


def spawned(world, text=SDF):
    return world.spawn_sdf("m", text, Pose(), str)


def places(model):
    """Positions of all links (n, 3) [m]."""
    return np.array([model.link_state(name)[0].position for name in model.link_names])


def test_a_push_moves_one_alone_with_what_hangs_on_it(world):
    world.engine.set_gravity((0.0, 0.0, 0.0))
    model = spawned(world)
    before = places(model)
    for _ in range(100):
        model.apply_wrench("c", (0.0, 10.0, 0.0), (0.0, 0.0, 0.0))
        world.step()
    moved = places(model) - before
    assert np.abs(moved[:2]).max() < 1e-12
    assert moved[2:, 1].min() > 0.02


def test_a_models_pose_moves_all_and_they_stay_where_they_are_relative_to_each_other(world):
    model = spawned(world)
    model.set_link_state("b", Pose((1.0, 0.5, 3.0)), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    world.step(50)
    root = model.pose
    before = [root.inverse() * model.link_state(name)[0] for name in model.link_names]
    target = Pose.from_xyz_rpy((3.0, -2.0, 4.0), (0.1, 0.2, 0.7))
    model.set_state(target, (0.5, 0.0, 0.0))
    for name, there in zip(model.link_names, before):
        pose, linear, angular = model.link_state(name)
        wanted = target * there
        assert pose.position == pytest.approx(wanted.position, abs=1e-9)
        assert abs(np.dot(pose.orientation, wanted.orientation)) == pytest.approx(1.0)
        assert linear == pytest.approx((0.5, 0.0, 0.0)) and angular == pytest.approx((0, 0, 0))


def test_a_link_is_put_by_itself(world):
    model = spawned(world)
    before = places(model)
    model.set_link_state("b", Pose((5.0, 0.0, 1.0)), (0.0, 1.0, 0.0), (0.0, 0.0, 2.0))
    pose, linear, angular = model.link_state("b")
    assert pose.position == pytest.approx((5.0, 0.0, 1.0))
    assert linear == pytest.approx((0, 1, 0)) and angular == pytest.approx((0, 0, 2))
    assert np.delete(places(model) - before, 1, axis=0) == pytest.approx(np.zeros((3, 3)))


def test_a_reset_of_the_world_keeps_them_apart_and_one_of_the_simulation_puts_them_back(world):
    model = spawned(world)
    before = places(model)
    model.set_link_state("b", Pose((5.0, 0.0, 1.0)), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    world.step(20)
    apart = places(model) - places(model)[0]
    world.reset_models()
    assert places(model) - places(model)[0] == pytest.approx(apart, abs=1e-9)
    assert places(model)[0] == pytest.approx(before[0], abs=1e-9)
    world.start_over()
    assert places(model) == pytest.approx(before, abs=1e-9)
    assert np.abs(model.link_state("b")[1]).max() == 0.0


def test_saved_states_bring_them_back_to_the_bit(world):
    model = spawned(world)
    world.step(30)
    state = world.save_state()
    world.step(30)
    wanted = places(model)
    world.restore_state(state)
    world.step(30)
    assert (places(model) == wanted).all()
    world.reset()
    world.step(60)
    assert (places(model) == wanted).all()


def test_mirrors_and_rays_see_them_where_they_are(world):
    model = spawned(world)
    turned = Pose.from_xyz_rpy((2.0, 0.3, 2.5), (0.4, -0.3, 1.0))
    model.set_link_state("b", turned, (0.0, 0.0, 0.0), (3.0, 0.0, 0.0))
    world.step(40)
    source = world.sources()[0]
    mirror = Kinematics({source.key: source.links})
    mirror.apply(world.snapshot())
    seen = [
        pose @ pose_matrix(shape.pose)
        for pose, link in zip(mirror.poses, source.links)
        for shape in link.shapes
    ]
    poses = [model.link_state(name)[0] for name in model.link_names]
    wanted = {tuple(np.round(pose.position, 6)) for pose in poses}
    assert {tuple(np.round(pose[:3, 3], 6)) for pose in seen} == wanted
    b = next(pose for pose in seen if pose[0, 3] > 1.5)
    assert b[:3, :3] == pytest.approx(model.link_state("b")[0].matrix, abs=1e-6)
    center = np.array(model.link_state("b")[0].position)
    start = center + (0.0, 0.0, 2.0)
    hit = world.engine.cast_rays(Rays(start, np.array([[0.0, 0.0, -1.0]]), 0.0, 5.0))
    assert 1.8 < hit[0] < 1.95
    position, _ = world.engine.mirror.client.link_frame((model.body.number, "b"))
    assert position == pytest.approx(center, abs=1e-6)  # in PyBullet, too


def test_beside_a_root_that_is_held_they_fall_and_are_put_back(world):
    held = '<joint name="held" type="fixed"><parent>world</parent><child>{}</child></joint></model>'
    model = spawned(world, SDF.replace("</model>", held.format("c")))
    before = places(model)
    world.step(100)
    assert (before - places(model))[:3, 2] == pytest.approx([FALL, FALL, 0.0], abs=1e-3)
    world.start_over()
    assert places(model) == pytest.approx(before, abs=1e-9)
    assert np.abs(model.link_state("a")[1]).max() == 0.0


def test_each_sleeps_by_itself(world):
    ground = (
        '<sdf version="1.6"><model name="g"><static>1</static><link name="l"><collision name="c">'
        "<geometry><plane/></geometry></collision></link></model></sdf>"
    )
    world.spawn_sdf("g", ground, Pose(), str)
    links = LINK.format("a", "0 0 0 0 0 0") + LINK.format("b", "1 0 19.9 0 0 0")
    text = f'<sdf version="1.6"><model name="m"><pose>0 0 0.1 0 0 0</pose>{links}</model></sdf>'
    model = spawned(world, text)
    world.step(1500)
    assert places(model)[0, 2] == pytest.approx(0.1, abs=1e-3)
    assert places(model)[1, 2] == pytest.approx(20 - 0.5 * 9.81 * 1.5**2, abs=0.05)
    assert not model.body.is_resting()


def test_with_bullet_they_are_fixed_with_a_warning():
    world = World(solver="bullet")
    model = spawned(world)
    before = places(model)
    world.step(50)
    apart = places(model)[1] - places(model)[0]
    assert apart == pytest.approx(before[1] - before[0], abs=1e-4)
    assert "link 'b' of 'm' has no joint" in model.description.warnings[0]
    world.close()

"""Solver 'ode': the search for contacts of two meshes by planes of large triangles."""

import gazebo_states
import numpy as np
import trimesh
from bullet_sim.engine.quickstep.layout import B_CENTER, B_COLUMNS, B_ROTATION, MAX_CONTACTS
from bullet_sim.engine.quickstep.mesh_pairs import mesh_with_mesh
from bullet_sim.pose import Pose
from bullet_sim.world import World
from sdf_texts import static_mesh, write_triangles

BALL = gazebo_states.robot(gazebo_states.link("base", 1.0, 0.01, '<sphere radius="0.05"/>'))


def test_the_planes_of_few_large_triangles_leave_out_no_contact(tmp_path):
    """Wheels at random places of a ground with steps: the same contacts as of all boxes."""
    world = World(solver="ode")
    generator = np.random.default_rng(4711)
    heights = [0.0, 0.0, 0.01, 0.01, 0.0, 0.3, 0.3]
    strips = [
        [[x, -2, a], [x + 0.4, -2, b], [x + 0.4, 2, b], [x, -2, a], [x + 0.4, 2, b], [x, 2, a]]
        for x, a, b in zip(np.arange(-1.2, 1.2, 0.4), heights[:-1], heights[1:])
    ]
    write_triangles(tmp_path / "ground.stl", strips)
    trimesh.creation.cylinder(0.08, 0.05, sections=48).subdivide().export(tmp_path / "wheel.stl")
    for name in ("ground", "wheel"):
        world.spawn_sdf(name, static_mesh(name, tmp_path), Pose(), lambda uri: uri[7:])
    world.spawn_urdf("ball", BALL, Pose((0, 0, 9)), str)
    world.step()
    scene = world.engine.arrays.state.scene
    ground, wheel = scene.roots[:2]
    assert min(ground, wheel) >= 0 and ground != wheel
    plain = scene.trees._replace(near=np.zeros(0, np.int64))  # no room: all boxes are compared
    still, one = np.zeros(B_COLUMNS), np.zeros(B_COLUMNS)
    still[B_ROTATION:] = np.eye(3).ravel()
    touching = 0
    for _ in range(400):
        one[B_CENTER : B_CENTER + 3] = generator.uniform((-1.1, -1.5, 0.0), (1.1, 1.5, 0.35))
        one[B_ROTATION:] = trimesh.transformations.random_rotation_matrix(generator.random(3))[
            :3, :3
        ].ravel()
        for pair in ((still, ground, one, wheel), (one, wheel, still, ground)):
            found, others = np.zeros_like(plain.found), np.zeros_like(plain.found)
            count = mesh_with_mesh(*pair, scene.trees, found, MAX_CONTACTS)
            assert count == mesh_with_mesh(*pair, plain, others, MAX_CONTACTS)
            np.testing.assert_array_equal(found, others)
            touching += count > 0
    assert 100 < touching < 700
    world.close()

"""Solver 'ode': meshes that move or not, as triangles. That they are Gazebo's: gazebo_states.py."""

import gazebo_states
import numpy as np
import pytest
import trimesh
from bullet_sim.formats.sdf.world import ground_plane
from bullet_sim.pose import Pose
from bullet_sim.world import World
from sdf_texts import static_mesh, write_triangles

SHAPES = {
    "sphere": '<sphere radius="0.05"/>',
    "cylinder": '<cylinder radius="0.05" length="0.1"/>',
    "box": '<box size="0.1 0.1 0.1"/>',
    "mesh": '<mesh filename="file://{folder}/small.stl"/>',
}
WORLD = {"gravity": gazebo_states.GRAVITY}


def bot(shape, mass=1.0):
    return gazebo_states.robot(gazebo_states.link("base", mass, 0.01 * mass, shape))


def spawn(world, name, text, place, folder):
    text = text.replace("{folder}", str(folder))
    return world.spawn_urdf(name, text, Pose(place), lambda uri: uri[7:])


def tree_of(world, folder, triangles):
    """The trees of a world with one mesh, whose root is 0."""
    write_triangles(folder / "mesh.stl", triangles)
    world.spawn_sdf("mesh", static_mesh("mesh", folder), Pose(), lambda uri: uri[7:])
    spawn(world, "ball", bot(SHAPES["sphere"]), (0, 0, 9), folder)
    world.step()
    scene = world.engine.arrays.state.scene
    assert scene.roots[0] == 0
    return scene.trees


@pytest.mark.parametrize("shape", SHAPES)
def test_what_is_dropped_into_a_tray_stays_in_it(world, tmp_path, shape):
    """The tray moves, too: it falls 5 cm on the ground. The hull of both would be on top."""
    gazebo_states.write_meshes(tmp_path)
    trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / "small.stl")
    ground = f'<sdf version="1.6">{gazebo_states.ground("")}</sdf>'
    world.spawn_sdf("ground", ground, Pose(), str)
    tray = spawn(
        world,
        "tray",
        bot('<mesh filename="file://{folder}/tray.stl"/>', 3.0),
        (0, 0, 0.05),
        tmp_path,
    )
    thing = spawn(world, "thing", bot(SHAPES[shape], 0.5), (0.11, 0.07, 0.25), tmp_path)
    world.step(2000)
    x, y, z = thing.pose.position
    assert z == pytest.approx(0.08, abs=2e-3)  # the floor's 3 cm, and half its size
    assert max(abs(x), abs(y)) < 0.22
    assert tray.pose.position[2] == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize("shape", SHAPES)
def test_meshes_of_one_triangle_and_without_area_are_safe(world, tmp_path, shape):
    """A ground of one triangle, one of which all corners are one point, and one that is a line."""
    trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / "small.stl")
    grounds = {
        "one": [[(-1, -1, 0), (1, -1, 0), (0, 1, 0)]],
        "some": [
            [(-1, -1, 0), (1, -1, 0), (0, 1, 0)],
            [(0, 0, 0), (0, 0, 0), (0, 0, 0)],
            [(0, 0, 0), (1, 0, 0), (2, 0, 0)],
        ],
    }
    things = []
    for i, (name, triangles) in enumerate(grounds.items()):
        write_triangles(tmp_path / f"{name}.stl", triangles)
        world.spawn_sdf(
            name, static_mesh(name, tmp_path), Pose((5.0 * i, 0, 0)), lambda uri: uri[7:]
        )
        things.append(spawn(world, f"on_{name}", bot(SHAPES[shape]), (5.0 * i, 0, 0.06), tmp_path))
    world.step(500)
    for thing in things:
        assert np.isfinite(thing.pose.position).all()
        assert abs(thing.pose.position[2] - 0.05) < 0.02, thing.name


def test_a_tree_has_each_triangle_once_in_boxes_that_contain_it(world, tmp_path):
    triangles = trimesh.creation.icosphere(subdivisions=3).triangles
    trees = tree_of(world, tmp_path, triangles)
    corners = trees.corners.reshape(-1, 3, 3)
    assert sorted(np.round(corners, 5).tolist()) == sorted(np.round(triangles, 5).tolist())
    assert trees.depth[0] < 20
    seen, waiting = [], [0]
    while waiting:
        node = waiting.pop()
        box = trees.nodes[node]
        low, high = box[:3] - box[3:] - 1e-6, box[:3] + box[3:] + 1e-6
        for child in trees.children[node]:
            if child >= 0:
                waiting.append(child)
                inner = trees.nodes[child]
                assert (inner[:3] - inner[3:] >= low).all()
                assert (inner[:3] + inner[3:] <= high).all()
            else:
                seen.append(-1 - child)
                assert (corners[-1 - child] >= low).all()
                assert (corners[-1 - child] <= high).all()
    assert sorted(seen) == list(range(len(triangles)))


def test_a_tree_of_equal_triangles_is_split_in_halves(world, tmp_path):
    trees = tree_of(world, tmp_path, [[(0, 0, 0), (1, 0, 0), (0, 1, 0)]] * 1024)
    leaves = trees.children[trees.children < 0]
    assert sorted(-1 - leaves) == list(range(1024))
    assert trees.depth[0] == 10


def height_of_a_comb(folder, teeth, spike):
    """Where a mesh of teeth, 1 cm in the ground, and of a spike [m] after them is a step later."""
    triangles = []
    for tooth in range(teeth):
        x, y = 0.01 * (tooth % 20), 0.01 * (tooth // 20)
        triangles.append([(x, y, 0), (x + 0.004, y, 1), (x, y + 0.004, 1)])
    triangles.append([(0.1, 0.1, -spike), (0.101, 0.1, 1), (0.1, 0.101, 1)])
    name = f"comb_{teeth}_{spike}"
    write_triangles(folder / f"{name}.stl", triangles)
    world = World(solver="ode")
    world.spawn(ground_plane())
    shape = f'<mesh filename="file://{folder}/{name}.stl"/>'
    comb = spawn(world, "comb", bot(shape), (0.0, 0.0, -0.01), folder)
    world.engine.step()
    height = comb.body.rows[0, 2]
    world.close()
    return height


def test_of_a_mesh_in_the_ground_the_first_250_vertices_count(tmp_path):
    heights = {
        teeth: [height_of_a_comb(tmp_path, teeth, spike) for spike in (0.0, 0.2)]
        for teeth in (200, 300)
    }
    assert heights[200][0] != heights[200][1] and heights[300][0] == heights[300][1]

"""Solver 'ode': meshes that move or not, as triangles. That they are Gazebo's: gazebo_states.py."""

import gazebo_states
import numpy as np
import pytest
import trimesh
from bullet_sim.engine.quickstep.layout import NO_CHILD
from bullet_sim.engine.quickstep.trees import build_tree
from bullet_sim.pose import Pose
from bullet_sim.world import World

SHAPES = {
    "sphere": '<sphere radius="0.05"/>',
    "cylinder": '<cylinder radius="0.05" length="0.1"/>',
    "box": '<box size="0.1 0.1 0.1"/>',
    "mesh": '<mesh filename="file://{folder}/small.stl"/>',
}


@pytest.fixture(name="world")
def _world():
    made = World(solver="ode", gravity=gazebo_states.GRAVITY)
    yield made
    made.close()


def bot(shape, mass=1.0):
    return gazebo_states.robot(gazebo_states.link("base", mass, 0.01 * mass, shape))


def spawn(world, name, text, place, folder):
    text = text.replace("{folder}", str(folder))
    return world.spawn_urdf(name, text, Pose(place), lambda uri: uri[7:])


def tree_of(triangles):
    """Order, nodes, children and depth."""
    corners = np.asarray(triangles, np.float32)
    count = len(corners)
    order, nodes = np.empty(count, np.int64), np.empty((max(1, count - 1), 6))
    children = np.full((max(1, count - 1), 2), NO_CHILD, np.int64)
    return order, nodes, children, build_tree(corners, order, nodes, children)


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
        vertices = np.array(triangles, float).reshape(-1, 3)
        faces = np.arange(len(vertices)).reshape(-1, 3)
        trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / f"{name}.stl")
        sdf = (
            f'<sdf version="1.6"><model name="m"><static>1</static><link name="l"><collision '
            f'name="c"><geometry><mesh><uri>file://{tmp_path}/{name}.stl</uri></mesh></geometry>'
            "</collision></link></model></sdf>"
        )
        world.spawn_sdf(name, sdf, Pose((5.0 * i, 0, 0)), lambda uri: uri[7:])
        things.append(spawn(world, f"on_{name}", bot(SHAPES[shape]), (5.0 * i, 0, 0.06), tmp_path))
    world.step(500)
    for thing in things:
        assert np.isfinite(thing.pose.position).all()
        assert abs(thing.pose.position[2] - 0.05) < 0.02, thing.name


def test_a_tree_has_each_triangle_once_in_boxes_that_contain_it():
    triangles = trimesh.creation.icosphere(subdivisions=3).triangles
    order, nodes, children, depth = tree_of(triangles)
    assert sorted(order) == list(range(len(triangles)))
    assert depth < 20
    seen, waiting = [], [0]
    while waiting:
        node = waiting.pop()
        for child in children[node]:
            low, high = nodes[node, :3] - nodes[node, 3:], nodes[node, :3] + nodes[node, 3:]
            if child >= 0:
                waiting.append(child)
                inner = nodes[child]
                assert (inner[:3] - inner[3:] >= low - 1e-6).all()
                assert (inner[:3] + inner[3:] <= high + 1e-6).all()
            else:
                seen.append(-1 - child)
                corners = triangles[order[-1 - child]]
                assert (corners >= low - 1e-6).all()
                assert (corners <= high + 1e-6).all()
    assert sorted(seen) == list(range(len(triangles)))


def test_a_tree_of_equal_triangles_is_split_in_halves():
    order, _, children, depth = tree_of([[(0, 0, 0), (1, 0, 0), (0, 1, 0)]] * 1024)
    assert sorted(order) == list(range(1024))
    assert depth == 10
    assert NO_CHILD not in children

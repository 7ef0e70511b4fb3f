"""What lidars of the type gpu_ray see: visuals, where those of the type ray see collisions."""

import math
from dataclasses import replace

import numpy as np
import pytest
from bullet_sim.kinematics import matrices, quaternions
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Pose
from bullet_sim.sensors.lidar import LayeredLidar, Lidar
from bullet_sim.world import World

BOX = "<box><size>1 1 1</size></box>"
MASS = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"


def spawn(world, name, place, static=True, yaw=0.0, **parts):
    """A model of one link; parts: visual or collision -> content of its element."""
    shapes = "".join(f'<{tag} name="{tag}">{inner}</{tag}>' for tag, inner in parts.items())
    text = (
        f'<sdf version="1.6"><model name="m"><static>{int(static)}</static><link name="l">{MASS}'
        f"{shapes}</link></model></sdf>"
    )
    return world.spawn_sdf(name, text, Pose.from_xyz_rpy(place, (0.0, 0.0, yaw)), str)


def shape(geometry, more=""):
    return f"<geometry>{geometry}</geometry>{more}"


WORLD = {"gravity": (0.0, 0.0, 0.0)}


AHEAD = RaySpec("l", "l", samples=3, min_angle=-math.pi / 2, max_angle=math.pi / 2)
SEEING = replace(AHEAD, sees_visuals=True)


def seen(world, spec=SEEING, kind=Lidar, turn=(0.0, 0.0, 0.0, 1.0)):
    """Ranges and intensities from the origin: to the right, ahead and to the left."""
    lidar = kind(spec)
    scene = world.visible if spec.sees_visuals else world.engine
    ranges = lidar.scan(scene, (0, 0, 0), turn)
    return ranges.tolist(), lidar.intensities(world.models.values())


def test_a_wall_to_be_seen_and_a_wall_to_collide_with(world):
    spawn(world, "seen", (2.0, 0.0, 0.0), visual=shape(BOX))
    spawn(world, "solid", (0.0, 3.0, 0.0), collision=shape(BOX))
    assert seen(world)[0] == pytest.approx([math.inf, 1.5, math.inf])
    assert seen(world, AHEAD)[0] == pytest.approx([math.inf, math.inf, 2.5])


@pytest.mark.parametrize("static", [True, False])
def test_visuals_are_seen_where_their_link_is(world, static):
    model = spawn(world, "m", (2.0, 0.0, 0.0), static, visual=shape(BOX))
    assert seen(world)[0][1] == pytest.approx(1.5)
    model.set_state(Pose.from_xyz_rpy((4.0, 0.0, 0.0), (0.0, 0.0, math.pi / 4)))
    assert seen(world)[0][1] == pytest.approx(4.0 - math.sqrt(0.5), abs=1e-6)
    world.delete("m")
    assert seen(world)[0][1] == math.inf
    spawn(world, "other", (0.0, 2.0, 0.0), static, visual=shape(BOX))
    assert seen(world)[0] == pytest.approx([math.inf, math.inf, 1.5])


def test_what_falls_is_seen_where_it_falls():
    world = World()
    spawn(world, "m", (2.0, 0.0, 0.5), static=False, visual=shape(BOX))
    assert seen(world)[0][1] == pytest.approx(1.5)
    world.step(500)
    assert seen(world)[0][1] == math.inf
    world.close()


@pytest.mark.parametrize(
    "geometry, expected",
    [
        (BOX, 1.5),
        ("<sphere><radius>0.5</radius></sphere>", 1.5),
        ("<cylinder><radius>0.5</radius><length>1</length></cylinder>", 1.5),
        ("<plane><normal>-1 0 0</normal><size>1 1</size></plane>", 2.0),
        ("<plane><normal>1 0 0</normal><size>1 1</size></plane>", 2.0),  # its back
    ],
)
def test_shapes_of_all_kinds(world, geometry, expected):
    spawn(world, "m", (2.0, 0.0, 0.0), visual=shape(geometry))
    assert seen(world)[0][1] == pytest.approx(expected, abs=2e-3)


def test_round_shapes_have_the_polygons_that_gazebo_renders(world):
    spawn(world, "c", (2.0, 0.0, 0.0), yaw=math.pi / 32,
          visual=shape("<cylinder><radius>1</radius><length>1</length></cylinder>"))  # fmt: skip
    assert seen(world)[0][1] == pytest.approx(2.0 - math.cos(math.pi / 32), abs=1e-6)


def test_a_housing_hides_what_is_outside_unless_it_is_nearer_than_the_minimum(world):
    spawn(world, "wall", (3.0, 0.0, 0.0), visual=shape(BOX))
    spawn(world, "housing", (0.0, 0.0, 0.0), visual=shape("<box><size>0.4 0.4 0.4</size></box>"))
    assert seen(world)[0] == pytest.approx([0.2, 0.2, 0.2])
    assert seen(world, replace(SEEING, range_min=0.3))[0] == pytest.approx(
        [math.inf, 2.5, math.inf]
    )


def test_what_is_translucent_is_seen(world):
    spawn(world, "m", (2.0, 0.0, 0.0), visual=shape(BOX, "<transparency>1</transparency>"))
    assert seen(world)[0][1] == pytest.approx(1.5)


@pytest.mark.parametrize("flags, expected", [("1", math.inf), ("3", math.inf), ("4", 1.5)])
def test_flags_of_gazebos_window_hide_a_visual(world, flags, expected):
    tag = f"<visibility_flags>{flags}</visibility_flags>"
    spawn(world, "m", (2.0, 0.0, 0.0), visual=shape(BOX, tag))
    assert seen(world)[0][1] == pytest.approx(expected)


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder"])
def test_the_intensity_is_the_retro_of_the_visual(world, kind):
    geometry = {
        "box": BOX, "sphere": "<sphere><radius>0.5</radius></sphere>",
        "cylinder": "<cylinder><radius>0.5</radius><length>1</length></cylinder>",
    }[kind]  # fmt: skip
    for name, place, retros in (
        ("a", (2.0, 0.0, 0.0), {"visual": 80, "collision": 20}), ("b", (0.0, 2.0, 0.0), {}),
    ):  # fmt: skip
        spawn(world, name, place, yaw=0.1, **{
            tag: shape(geometry, f"<laser_retro>{retros.get(tag, 0)}</laser_retro>")
            for tag in ("visual", "collision")
        })  # fmt: skip
    assert seen(world)[1].tolist() == [0.0, 80.0, 0.0]
    assert seen(world, AHEAD)[1].tolist() == [0.0, 20.0, 0.0]


def test_clouds_have_them(world):
    spawn(world, "m", (2.0, 0.0, 0.0), visual=shape(BOX, "<laser_retro>7</laser_retro>"))
    spec = RaySpec("l", "l", samples=1, min_angle=0.0, max_angle=0.0, layers=3,
                       min_elevation=-0.5, max_elevation=0.5, sees_visuals=True)  # fmt: skip
    ranges, found = seen(world, spec, LayeredLidar)
    assert ranges[1] == pytest.approx(1.5) and found.tolist() == [0.0, 7.0, 0.0]


def test_a_mesh_and_its_submesh(world, tmp_path):
    """Two boxes in one file, at x = 0 and 1."""
    corners = [(x, y, z) for x in (-0.1, 0.1) for y in (-1, 1) for z in (-1, 1)]
    faces = ["1 2 4", "1 4 3", "5 7 8", "5 8 6", "1 5 6", "1 6 2", "3 4 8", "3 8 7"]
    lines = []
    for number, shift in enumerate((0.0, 1.0)):
        lines += [f"o part{number}", *(f"v {x + shift} {y} {z}" for x, y, z in corners)]
        lines += ["f " + " ".join(str(int(v) + 8 * number) for v in face.split()) for face in faces]
    path = tmp_path / "two.obj"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    scale = "<scale>2 1 1</scale>"
    mesh = f"<mesh><uri>{path}</uri>{scale}</mesh>"
    part = f"<mesh><uri>{path}</uri>{scale}<submesh><name>part1</name></submesh></mesh>"
    spawn(world, "m", (2.0, 0.0, 0.0), visual=shape(mesh))
    assert seen(world)[0][1] == pytest.approx(1.8)
    world.delete("m")
    spawn(world, "m", (2.0, 0.0, 0.0), visual=shape(part))
    assert seen(world)[0][1] == pytest.approx(3.8)


def test_links_below_joints_are_seen_where_they_turn(world):
    arm = (
        '<sdf version="1.6"><model name="arm"><link name="base">' + MASS + "</link>"
        f'<link name="hand">{MASS}<visual name="v"><pose>2 0 0 0 0 0</pose>{shape(BOX)}</visual>'
        '</link><joint name="j" type="revolute"><parent>base</parent><child>hand</child><axis>'
        "<xyz>0 0 1</xyz></axis></joint></model></sdf>"
    )
    model = world.spawn_sdf("arm", arm, Pose(), str)
    assert seen(world)[0] == pytest.approx([math.inf, 1.5, math.inf])
    model.joints.set_positions({"j": math.pi / 2})
    assert seen(world)[0] == pytest.approx([math.inf, math.inf, 1.5])


def test_with_the_solver_bullet_they_see_what_collides():
    world = World(solver="bullet")
    spawn(world, "solid", (2.0, 0.0, 0.0), collision=shape(BOX))
    assert world.visible is world.engine
    assert seen(world)[0][1] == pytest.approx(1.5, abs=1e-3)
    world.close()


def test_quaternions_of_matrices():
    random = np.random.default_rng(0).normal(size=(200, 4))
    wanted = np.concatenate([random, np.eye(4), -np.eye(4)])
    wanted /= np.linalg.norm(wanted, axis=1)[:, None]
    found = quaternions(matrices(np.zeros((len(wanted), 3)), wanted))
    assert np.abs((found * wanted).sum(axis=1)) == pytest.approx(np.ones(len(wanted)), abs=1e-12)

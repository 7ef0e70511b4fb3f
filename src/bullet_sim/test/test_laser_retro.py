"""<laser_retro>: the intensity that a lidar measures of what it hits."""

import math

import numpy as np
import pytest
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Pose
from bullet_sim.sensors.lidar import LayeredLidar, Lidar

pytestmark = pytest.mark.usefixtures("sketches")

SHAPES = {
    "box": "<box><size>1 1 1</size></box>",
    "sphere": "<sphere><radius>0.5</radius></sphere>",
    "cylinder": "<cylinder><radius>0.5</radius><length>1</length></cylinder>",
}


def spawn(world, name, geometry, place, retro="", static=True):
    inertia = "<inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>"
    tag = f"<laser_retro>{retro}</laser_retro>" if retro else ""
    text = (
        f'<sdf version="1.6"><model name="m"><static>{int(static)}</static><link name="l">'
        f'<inertial><mass>1</mass>{inertia}</inertial><collision name="c">{tag}<geometry>{geometry}'
        "</geometry></collision></link></model></sdf>"
    )
    return world.spawn_sdf(name, text, Pose(place), str)


WORLD = {"gravity": (0.0, 0.0, 0.0)}


def measured(world, lidar, noise=None):
    """Ranges and intensities from the origin."""
    ranges = lidar.scan(world.engine, (0, 0, 0), (0, 0, 0, 1), noise)
    return ranges, lidar.intensities(world.models.values())


def ahead_and_aside(**values):
    """A lidar with rays to the right, ahead and to the left."""
    return RaySpec("l", "l", samples=3, min_angle=-math.pi / 2, max_angle=math.pi / 2, **values)


@pytest.mark.parametrize("static", [True, False])
@pytest.mark.parametrize("kind", SHAPES)
def test_the_retro_of_what_is_hit(world, kind, static):
    spawn(world, "reflector", SHAPES[kind], (2.0, 0.0, 0.0), 127, static)
    spawn(world, "wall", SHAPES[kind], (0.0, 2.0, 0.0), "", static)
    ranges, found = measured(world, Lidar(ahead_and_aside()))
    assert ranges[1:].tolist() == pytest.approx([1.5, 1.5], abs=1e-3) and np.isinf(ranges[0])
    assert found.dtype == np.float32 and found.tolist() == [0.0, 127.0, 0.0]


def test_what_stands_before_a_reflector_hides_it(world):
    spawn(world, "reflector", SHAPES["box"], (3.0, 0.0, 0.0), 127)
    spawn(world, "wall", SHAPES["box"], (1.5, 0.0, 0.0))
    assert measured(world, Lidar(ahead_and_aside()))[1].tolist() == [0.0, 0.0, 0.0]


def test_noise_of_the_ranges_does_not_change_it(world):
    spawn(world, "reflector", SHAPES["box"], (2.0, 0.0, 0.0), 12.5)
    lidar = Lidar(ahead_and_aside(noise_stddev=0.2))
    ranges, found = measured(world, lidar, np.random.default_rng(1))
    assert abs(ranges[1] - 1.5) > 1e-3 and found[1] == 12.5


def test_without_any_there_are_none(world):
    spawn(world, "wall", SHAPES["box"], (2.0, 0.0, 0.0))
    assert measured(world, Lidar(ahead_and_aside()))[1] is None


def test_layers_have_them(world):
    spawn(world, "reflector", SHAPES["box"], (2.0, 0.0, 0.0), 127)
    spec = RaySpec("l", "l", samples=1, min_angle=0.0, max_angle=0.0, layers=3,
                       min_elevation=-0.5, max_elevation=0.5)  # fmt: skip
    assert measured(world, LayeredLidar(spec))[1].tolist() == [0.0, 127.0, 0.0]


def test_the_tag_of_a_urdf_holds_for_its_links_shapes():
    shape = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    text = (
        f'<robot name="r"><link name="a">{shape}{shape}</link><link name="b">{shape}</link>'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
        '<gazebo reference="a"><laserRetro>200</laserRetro></gazebo></robot>'
    )
    model = parse_urdf(text, str, "r")
    assert model.warnings == []
    assert [shape.laser_retro for shape in model.links["a"].collisions] == [200.0, 200.0]
    assert [shape.laser_retro for shape in model.links["b"].collisions] == [0.0]

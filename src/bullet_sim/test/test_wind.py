"""Gazebo's WindPlugin beyond what test_gazebo_states.py holds."""

import gazebo_states
import pytest
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.world import World

FACTOR = "<force_approximation_scaling_factor>2</force_approximation_scaling_factor>"
LINK = gazebo_states.body("a", "0 0 3 0 0 0", gazebo_states.CUBE, 2.0)


def described(plugin, model=""):
    return parse_world(
        '<sdf version="1.6"><world name="w"><gravity>0 0 0</gravity><wind><linear_velocity>3 4 0.5'
        f'</linear_velocity></wind><plugin name="p" filename="libWindPlugin.so">{plugin}</plugin>'
        f'<model name="m">{gazebo_states.WINDY}{LINK}</model>{model}</world></sdf>',
        str,
    )


def velocity(world):
    return world.model("m").link_state("a")[1]


@pytest.mark.parametrize("factor", ["", FACTOR.replace("2", "0"), FACTOR.replace("2", "x")])
def test_without_a_factor_there_is_no_wind_as_in_gazebo(factor):
    """Gazebo 11.1 prints an error, also of its own wind_demo.world."""
    found = described(factor)
    assert found.wind is None
    assert any("force_approximation_scaling_factor" in each for each in found.warnings)
    assert described(FACTOR).warnings == []


def test_its_noise_is_of_the_speed_the_direction_and_the_height():
    noise = '<noise type="gaussian"><mean>{}</mean><stddev>{}</stddev></noise>'
    spec = described(
        f"{FACTOR}<horizontal><magnitude>{noise.format(1, 0.1)}</magnitude><direction>"
        f"{noise.format(0, 5)}</direction></horizontal><vertical>{noise.format(0, 0.3)}</vertical>"
    ).wind
    assert spec.noise == ((1.0, 0.1), (0.0, 5.0), (0.0, 0.3))
    world = World()
    world.load(described(f"{FACTOR}<horizontal><magnitude>{noise.format(1, 0)}</magnitude>"
                         "</horizontal>"))  # fmt: skip
    world.step()
    assert velocity(world)[0] == pytest.approx(2.0 * 1e-3, rel=0.02), "1 m/s at once, factor 2"
    world.close()


def test_links_of_a_urdf_have_it_with_what_is_merged_into_them():
    """Gazebo 11.1: gz sdf -p writes it into the link that the other one is merged into."""
    mass = (
        '<inertial><mass value="{}"/><inertia ixx="0.1" iyy="0.1" izz="0.1"'
        ' ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    text = (
        f'<robot name="r"><link name="base">{mass.format(1)}</link><link name="top">'
        f'{mass.format(3)}</link><joint name="j" type="fixed"><parent link="base"/>'
        '<child link="top"/></joint><gazebo reference="top"><enable_wind>true</enable_wind>'
        "</gazebo></robot>"
    )
    model = parse_urdf(text, str)
    assert {name: link.wind for name, link in model.links.items()} == {"base": True, "top": True}
    assert model.warnings == []
    world = World()
    world.load(described(FACTOR))
    world.spawn_urdf("r", text, Pose((9.0, 0.0, 3.0)), str)
    world.step(100)
    found = world.model("r").link_state("base")[1]
    assert found == pytest.approx(velocity(world), rel=0.03), "its wind is half a step later"
    world.close()

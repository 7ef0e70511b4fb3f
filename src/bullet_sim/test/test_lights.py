"""Lights, background and fog of world files."""

import math

import pytest
from bullet_sim.description.lump import lump
from bullet_sim.description.world import SUN, Fog
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.formats.urdf import parse_urdf

pytestmark = pytest.mark.usefixtures("sketches")


def scene_of(text):
    world = parse_world(f'<sdf version="1.6"><world name="w">{text}</world></sdf>', str, "w")
    assert world.warnings == []
    return world.scene


def test_a_world_without_lights_has_ambient_light_alone():
    scene = scene_of("")
    assert scene.lights == () and scene.ambient == (0.4, 0.4, 0.4)
    assert scene.background == (0.7, 0.7, 0.7) and scene.shadows and scene.fog is None


def test_scene():
    scene = scene_of(
        "<scene><ambient>0.1 0.2 0.3 1</ambient><background>0.5 0.6 0.7 1</background>"
        "<shadows>false</shadows><fog><type>linear</type><color>1 0 0 1</color><start>2</start>"
        "<end>9</end></fog></scene>"
    )
    assert scene.ambient == (0.1, 0.2, 0.3) and scene.background == (0.5, 0.6, 0.7)
    assert not scene.shadows and scene.fog == Fog("linear", (1.0, 0.0, 0.0), 2.0, 9.0)
    assert scene_of("<scene><background>0 0 0</background><sky/></scene>").background is None
    assert scene_of("<scene><sky/></scene>").background is None
    assert scene_of("<scene><sky/></scene>").daytime == (10.0, 6.0, 20.0)
    evening = "<scene><sky><time>19.5</time><sunrise>-3</sunrise><sunset>21</sunset></sky></scene>"
    assert scene_of(evening).daytime == (19.5, 0.0, 21.0)
    assert scene_of("<scene><ambient>1 1 1</ambient></scene>").background == (0.7, 0.7, 0.7)
    assert scene_of("<scene><fog><type>none</type></fog></scene>").fog is None


def test_sun_and_light_of_an_include(tmp_path):
    assert scene_of("<include><uri>model://sun</uri></include>").lights == (SUN,)
    (tmp_path / "lamp.sdf").write_text(
        '<sdf version="1.6"><light name="lamp" type="point"><pose>1 2 3 0 0 0</pose></light></sdf>'
    )
    include = f"<include><uri>{tmp_path}/lamp.sdf</uri><pose>4 5 6 0 0 0</pose></include>"
    (light,) = scene_of(include).lights
    assert (light.name, light.kind, light.position) == ("lamp", "point", (4.0, 5.0, 6.0))


def test_a_spot_is_turned_by_its_pose():
    (light,) = scene_of(
        '<light name="s" type="spot"><pose>0 0 2 0 1.5707963 0</pose><direction>0 0 -2</direction>'
        "<diffuse>1 0.5 0 1</diffuse><attenuation><range>20</range><constant>0.5</constant>"
        "<linear>0.1</linear><quadratic>0.01</quadratic></attenuation><spot>"
        "<inner_angle>0.2</inner_angle><outer_angle>0.9</outer_angle><falloff>1.5</falloff></spot>"
        "<cast_shadows>true</cast_shadows></light>"
    ).lights
    assert light.direction == pytest.approx((-1.0, 0.0, 0.0), abs=1e-6)
    assert math.hypot(*light.direction) == pytest.approx(1.0)
    assert light.diffuse == (1.0, 0.5, 0.0) and light.cast_shadows
    assert (light.reach, light.constant, light.linear, light.quadratic) == (20, 0.5, 0.1, 0.01)
    assert (light.inner, light.outer, light.falloff) == (0.2, 0.9, 1.5)


def test_a_light_of_an_unknown_type_is_said():
    text = '<sdf version="1.6"><world name="w"><light name="l" type="laser"/></world></sdf>'
    world = parse_world(text, str, "w")
    assert world.scene.lights[0].kind == "point"
    assert "has type 'laser', known are directional, point, spot" in world.warnings[0]


LAMP = (
    '<light name="torch" type="spot"><pose>1 0 0 0 1.5707963267948966 0</pose>'
    "<direction>0 0 -1</direction></light>"
)


def test_a_light_of_a_link_shines_in_its_frame():
    text = (
        '<sdf version="1.7"><world name="w"><model name="m"><link name="a">'
        f"<pose>0 0 5 0 0 0</pose>{LAMP}</link></model></world></sdf>"
    )
    world = parse_world(text, str, "w")
    assert world.warnings == [] and world.scene.lights == ()
    (light,) = lump(world.models[0][0]).links["a"].lights  # in the model's frame
    assert light.kind == "spot" and light.position == pytest.approx((1.0, 0.0, 5.0))
    assert light.direction == pytest.approx((-1.0, 0.0, 0.0), abs=1e-6)


def test_a_light_of_a_link_that_is_merged_is_in_the_frame_of_what_remains():
    """As `gz sdf -p` of Gazebo 11.1 has it, which moves sensors alone (sdformat up to 9.8)."""
    robot = parse_urdf(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed">'
        '<origin xyz="0 2 0"/><parent link="a"/><child link="b"/></joint>'
        f'<gazebo reference="b">{LAMP}</gazebo></robot>',
        str,
        "r",
    )
    assert robot.warnings == []
    (light,) = lump(robot).links["a"].lights
    assert light.position == pytest.approx((1.0, 0.0, 0.0)) and light.name == "torch"

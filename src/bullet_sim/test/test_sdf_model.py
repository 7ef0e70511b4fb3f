"""SDF models: frames, nested models, joints, sensors, materials; worlds' odd elements."""

import math

import numpy as np
import pytest
from bullet_sim.engine.bullet.camera import PyBulletCamera
from bullet_sim.engine.bullet.client import Client
from bullet_sim.engine.bullet.urdf import visual_urdf
from bullet_sim.formats.ogre import complete, look, read_script
from bullet_sim.formats.sdf.world import parse_model, parse_world
from bullet_sim.pose import Pose
from bullet_sim.sensors import camera
from bullet_sim.world import World
from PIL import Image

MASS = (
    "<inertial><mass>1</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia>"
    "</inertial>"
)


def model_of(content, version="1.6", resolve=str):
    """ModelDescription of an SDF document."""
    return parse_model(
        f'<sdf version="{version}"><model name="m">{content}</model></sdf>', resolve, "file"
    )[0]


def world_of(content, resolve=str):
    """WorldDescription."""
    return parse_world(
        f'<sdf version="1.6"><world name="w">{content}</world></sdf>', resolve, "my.world"
    )


def joint(content="", kind="revolute", parent="a", child="b", name="j"):
    """A <joint>."""
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>'
        f"{content}</joint>"
    )


WORLD = {"gravity": (0.0, 0.0, 0.0)}


def test_poses_relative_to_other_parts():
    model = model_of(
        '<link name="a"/><frame name="f" attached_to="a"><pose>1 0 0 0 0 1.5707963267948966'
        '</pose></frame><link name="b"><pose relative_to="f">2 0 0 0 0 0</pose></link>'
        '<link name="c"><pose relative_to="b">0 0 3 0 0 0</pose></link>',
        "1.7",
    )
    origins = {name: pose.position for name, pose in model.loose.items()}
    assert origins["b"] == pytest.approx((1, 2, 0)) and origins["c"] == pytest.approx((1, 2, 3))


def test_a_model_within_a_model_is_placed_without_frames_as_in_gazebo():
    """Measured in Gazebo 11.1, which reads the numbers of its <pose> alone."""
    model = model_of(
        '<frame name="f"><pose>1 0 0 0 0 1</pose></frame><link name="a"/><model name="in">'
        '<pose relative_to="f">0 2 0 0 0 0</pose><frame name="g"><pose>0 0 3 0 0 0</pose></frame>'
        '<link name="b"><pose relative_to="g">0 0 1 0 0 0</pose></link></model>',
        "1.7",
    )
    assert model.loose["in::b"].position == pytest.approx((0, 2, 4))


def test_frames_of_a_world(tmp_path):
    """Poses of models and includes relative to frames, models and includes, as sdformat 9."""
    (tmp_path / "post.sdf").write_text(
        '<sdf version="1.7"><model name="post"><pose>0 0 9 0 0 0</pose><link name="l"/></model>'
        "</sdf>"
    )
    post = f"<uri>{tmp_path}/post.sdf</uri>"
    world = world_of(
        '<frame name="f"><pose>1 0 0 0 0 1.5707963267948966</pose></frame>'
        '<model name="a"><pose relative_to="f">2 0 0 0 0 0</pose><link name="l"/></model>'
        '<frame name="on_a" attached_to="a"><pose>0 0 3 0 0 0</pose></frame>'
        f'<include>{post}<name>b</name><pose relative_to="on_a">1 0 0 0 0 0</pose></include>'
        f"<include>{post}</include>"
        '<model name="c"><pose relative_to="post">0 1 0 0 0 0</pose><link name="l"/></model>'
    )
    assert world.warnings == []
    poses = {model.name: pose.position for model, pose in world.models}
    assert poses["a"] == pytest.approx((1, 2, 0)) and poses["b"] == pytest.approx((1, 3, 3))
    assert poses["post"] == pytest.approx((0, 0, 9)) and poses["c"] == pytest.approx((0, 1, 9))


def test_a_frame_that_a_world_does_not_have_is_the_world():
    world = world_of(
        '<model name="a"><pose relative_to="none">2 0 0 0 0 0</pose><link name="l"/></model>'
    )
    assert world.models[0][1].position == (2.0, 0.0, 0.0)
    assert "world 'w' has no frame 'none'" in world.warnings[0]


def test_nested_models_are_flattened():
    model = model_of(
        '<link name="a"/><model name="arm"><pose>0 0 1 0 0 0</pose><link name="x"><pose>1 0 0 0 0 0'
        '</pose></link><link name="y"/>'
        + joint(parent="x", child="y")
        + "</model>"
        + joint("", "fixed", "a", "arm::x")
    )
    assert list(model.links) == ["a", "arm::x", "arm::y"]
    assert set(model.joints) == {"arm::j", "j"}
    assert model.joints["j"].origin.position == (1, 0, 1)
    assert model.joints["arm::j"].origin.position == (-1, 0, 0)


def test_joint_turns_about_its_own_pose(world):
    """A door of 2 m whose hinge is at its edge, 1 m from its middle."""
    model = world.spawn(
        model_of(
            f'<link name="a">{MASS}</link><link name="b"><pose>1 0 0 0 0 0</pose>{MASS}</link>'
            + joint("<pose>-1 0 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis>")
            + joint("", "fixed", "world", "a", "k")
        ),
    )
    model.body.set_joint_positions([math.pi / 2])
    pose = model.link_state("b")[0]
    assert pose.position == pytest.approx((0, 1, 0), abs=1e-6)
    assert pose.rpy[2] == pytest.approx(math.pi / 2)


@pytest.mark.parametrize(
    "version, tag, axis",
    [
        ("1.6", "<xyz>1 0 0</xyz>", (1, 0, 0)),
        ("1.6", "<xyz>1 0 0</xyz><use_parent_model_frame>1</use_parent_model_frame>", (0, -1, 0)),
        ("1.4", "<xyz>1 0 0</xyz>", (0, -1, 0)),
        ("1.7", '<xyz expressed_in="__model__">1 0 0</xyz>', (0, -1, 0)),
    ],
)
def test_axis_frames(version, tag, axis):
    model = model_of(
        f'<link name="a"/><link name="b"><pose>0 0 0 0 0 {math.pi / 2}</pose></link>'
        + joint(f"<axis>{tag}</axis>"),
        version,
    )
    assert model.joints["j"].axis == pytest.approx(axis, abs=1e-9)


def test_limits_and_kinds():
    limits = "<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>"
    links = '<link name="a"/><link name="b"/>'
    assert model_of(links + joint(limits)).joints["j"].lower == -1
    assert model_of(links + joint(limits, "continuous")).joints["j"].lower is None
    assert (
        model_of(
            links + joint("<axis><limit><lower>-1e16</lower><upper>1e16</upper></limit></axis>")
        )
        .joints["j"]
        .lower
        is None
    )


def test_world_as_parent_holds_a_link_whose_joint_turns(world):
    world.engine.set_gravity((0, 0, -9.81))
    model = world.spawn(
        model_of(
            f'<link name="a"><pose>0 0 1 0 0 0</pose>{MASS}</link>'
            + joint("<axis><xyz>0 0 1</xyz></axis>", parent="world", child="a")
        ),
    )
    world.step(100)
    assert model.link_state("a")[0].position == pytest.approx((0, 0, 1), abs=1e-6)
    assert list(model.joints.names) == ["j"]


def test_the_joint_that_closes_a_loop_is_that_whose_child_hangs_already():
    model = model_of(
        '<link name="a"/><link name="b"/><link name="c"/>'
        + joint(child="b")
        + joint(child="c", name="k")
        + joint(parent="b", child="c", name="l")
    )
    assert [joint.closes for joint in model.joints.values()] == [False, False, True]
    assert not model.warnings and model.root == "a" and not model.loose


def test_sensor_of_a_root_link_off_the_models_frame(world):
    text = (
        '<link name="a"><pose>0 0 2 0 0 0</pose><sensor name="s" type="imu"><pose>1 0 0 0 0 0'
        '</pose><plugin filename="libgazebo_ros_imu_sensor.so"><frameName>a</frameName></plugin>'
        '</sensor></link><plugin filename="libgazebo_ros_p3d.so"><bodyName>a</bodyName>'
        "<topicName>t</topicName></plugin>"
    )
    model = model_of(text)
    assert [spec.link for spec in model.sensors] == ["a", "a"]
    assert model.sensors[0].pose[0] == (1, 0, 0) and model.warnings == []
    at = world.spawn(model, Pose((0.0, 0.0, 1.0))).link_state("a")[0]
    assert at.position == pytest.approx((0.0, 0.0, 3.0))
    assert model.sensors[0].topic == "/m/imu_data"


@pytest.mark.parametrize(
    "geometry, tag",
    [("<image/>", "image"), ("<cone/>", "cone")],
)
def test_unknown_shapes_are_named_once(geometry, tag):
    model = model_of(
        f'<link name="a"><visual name="v"><geometry>{geometry}</geometry></visual>'
        '<visual name="w"><geometry><empty/></geometry></visual></link>'
    )
    assert len(model.warnings) == 1 and f"<{tag}>" in model.warnings[0]


def test_unknown_tags_and_plugins_are_named_once():
    model = model_of(
        '<link name="a"/><zipper name="g"/><zipper name="h"/>'
        '<plugin name="p" filename="libparty.so"/>'
    )
    assert len(model.warnings) == 2
    assert "<zipper>" in model.warnings[0] and "libparty.so" in model.warnings[1]


def test_world_elements_that_mean_nothing():
    world = world_of(
        '<scene/><gui/><light name="l" type="point"/><actor name="walker"/><road name="r"/>'
        '<plugin name="p" filename="libworld.so"/><plugin name="q" filename="libworld.so"/>'
        '<spherical_coordinates/><model name="box"><pose>1 0 0 0 0 0</pose><link name="l"/></model>'
        '<state world_name="w"><model name="box"><pose>5 6 7 0 0 0</pose></model></state>'
    )
    assert len(world.warnings) == 2
    for word, text in zip(("road 'r' has 0 points", "libworld.so"), world.warnings):
        assert word in text and "my.world" in text
    assert world.models[0][1].position == (1, 0, 0)  # where a reset puts it
    assert world.starts["box"].position == (5, 6, 7)  # as Gazebo saved it


def test_roads_are_seen_and_touch_nothing():
    world = world_of(
        '<road name="r"><width>2</width><point>0 0 0.02</point><point>9 0 0.02</point></road>'
        '<road name="s"><point>0 0 0.02</point><point>far</point></road>'
    )
    (road,) = world.scene.roads
    assert road.geometry.size == (2.0,) and len(road.geometry.points) == 2 and road.painted
    assert world.models == [] and len(world.warnings) == 1 and "'far'" in world.warnings[0]


@pytest.mark.parametrize(
    "physics, factor",
    [
        ("", 1.0),
        (
            "<physics><max_step_size>0.002</max_step_size><real_time_update_rate>1000"
            "</real_time_update_rate></physics>",
            2.0,
        ),
        ("<physics><real_time_update_rate>0</real_time_update_rate></physics>", 0.0),
    ],
)
def test_pace_of_a_world(physics, factor):
    assert world_of(physics).real_time_factor == pytest.approx(factor)


def test_models_that_include_models(tmp_path):
    (tmp_path / "wheel.sdf").write_text(
        '<sdf version="1.6"><model name="wheel"><link name="rim"/></model></sdf>'
    )
    (tmp_path / "loop.sdf").write_text(
        f'<sdf version="1.6"><model name="l"><link name="a"/><include><uri>{tmp_path}/loop.sdf'
        "</uri></include></model></sdf>"
    )
    model = model_of(
        f'<link name="a"/><include><uri>{tmp_path}/wheel.sdf</uri><name>left</name>'
        f"<pose>0 1 0 0 0 0</pose></include>" + joint("", "fixed", "a", "left::rim")
    )
    assert model.joints["j"].origin.position == (0, 1, 0)
    world = world_of(
        f"<include><uri>{tmp_path}/loop.sdf</uri></include>"
        f"<include><uri>{tmp_path}/gone.sdf</uri></include>"
    )
    assert any("circle" in text for text in world.warnings)
    assert "gone.sdf" in world.warnings[-1]


WHEEL = (
    '<sdf version="1.4"><model name="wheel"><pose>9 9 9 0 0 0</pose>'
    '<link name="hub"><pose>0 0 0.5 0 0 0</pose>{inertia}</link>'
    '<link name="rim"><pose>0 0 1 0 0 0</pose>{inertia}<sensor name="s" type="contact"><contact>'
    '<collision>rim</collision></contact><plugin filename="libgazebo_ros_bumper.so"/></sensor>'
    '</link><joint name="spin" type="revolute"><parent>hub</parent><child>rim</child><axis>'
    "<xyz>1 0 0</xyz></axis></joint>"
    '<plugin name="p" filename="libgazebo_ros_joint_state_publisher.so"><jointName>spin'
    "</jointName></plugin></model></sdf>"
).format(inertia="<inertial><mass>1</mass></inertial>")


def test_an_included_model_is_copied_under_its_prefix_as_sdformat_9_does(tmp_path):
    """Names of links and joints also in plugins and sensors; poses and axes in the nested frame."""
    (tmp_path / "wheel.sdf").write_text(WHEEL)
    (tmp_path / "arm.sdf").write_text(
        f'<sdf version="1.7"><model name="arm"><link name="rim"/><include><uri>{tmp_path}/wheel.sdf'
        '</uri><name>w</name><pose>0 2 0 0 0 0</pose></include><joint name="j" type="fixed">'
        "<parent>rim</parent><child>w::hub</child></joint></model></sdf>"
    )
    model = model_of(
        f'<link name="a"/><include><uri>{tmp_path}/arm.sdf</uri><name>arm</name>'
        f'<pose>1 0 0 0 0 {math.pi / 2}</pose></include><frame name="tip" attached_to="arm::rim">'
        "<pose>0 0 3 0 0 0</pose></frame><link name='b'><pose relative_to='tip'/></link>"
        + joint("", "fixed", "a", "arm::rim")
        + '<joint name="k" type="fixed"><parent>a</parent><child>b</child></joint>'
    )
    assert model.warnings == []
    assert set(model.links) == {"a", "b", "arm::rim", "arm::w::hub", "arm::w::rim"}
    spin = model.joints["arm::w::spin"]
    assert (spin.parent, spin.child) == ("arm::w::hub", "arm::w::rim")
    assert spin.axis == pytest.approx((1, 0, 0)), "version 1.4: in the frame of the wheel"
    bumper, states = sorted(model.sensors, key=lambda spec: type(spec).__name__)
    assert states.joints == ("arm::w::spin",) and bumper.link == "arm::w::rim"
    assert bumper.collisions == ("arm::w::rim",), "a text that is a link's name"
    assert model.joints["arm::j"].origin.position == pytest.approx((0, 2, 0.5))
    assert model.joints["k"].origin.position == pytest.approx((1, 0, 3))


def test_axes_of_an_old_included_model_are_in_its_own_frame(tmp_path):
    (tmp_path / "wheel.sdf").write_text(WHEEL)
    model = model_of(
        f'<link name="a"/><include><uri>{tmp_path}/wheel.sdf</uri><pose>0 0 0 0 0 {math.pi / 2}'
        "</pose></include>" + joint("", "fixed", "a", "wheel::hub")
    )
    assert model.joints["wheel::spin"].axis == pytest.approx((1, 0, 0))


def test_plugins_of_a_model_within_a_model_name_its_own_joints():
    text = (
        '<link name="a"/><model name="arm"><link name="l"/><link name="m"/>'
        '<joint name="turn" type="revolute"><parent>l</parent><child>m</child><axis>'
        '<xyz>0 0 1</xyz></axis></joint><plugin filename="libgazebo_ros_joint_state_publisher.so">'
        "<jointName>turn</jointName></plugin><plugin filename='libgazebo_ros_p3d.so'>"
        "<bodyName>m</bodyName><topicName>truth</topicName></plugin></model>"
        + joint("", "fixed", "a", "arm::l")
    )
    states, truth = model_of(text).sensors
    assert (states.joints, states.topic) == (("arm::turn",), "/arm/joint_states")
    assert truth.link == "arm::m"


@pytest.mark.parametrize(
    "outer, included, expected",
    [
        ("", "", True),  # what AWS's worlds are made of
        ("<static>0</static>", "", False),
        ("", "<static>0</static>", False),
    ],
)
def test_a_model_that_includes_a_static_one_is_static(tmp_path, outer, included, expected):
    (tmp_path / "lamp.sdf").write_text(
        '<sdf version="1.6"><model name="lamp"><link name="a"/><static>1</static></model></sdf>'
    )
    world = world_of(
        f'<model name="lamp_1">{outer}<include><uri>{tmp_path}/lamp.sdf</uri>{included}</include>'
        "<pose>0 0 3 0 0 0</pose></model>"
    )
    ((model, pose),) = world.models
    assert model.static is expected and pose.position == (0, 0, 3)


SCRIPT = """
// a comment
material Base { technique { pass { ambient 0.1 0.1 0.1 1 diffuse 1 0 0 1
} } }
material Park/Grass
{
  technique
  {
    pass
    {
      ambient 0.5 0.5 0.5 1.0
      diffuse 0.2 0.9 0.2
      texture_unit
      {
        texture grass.png
        scale 2 2
      }
    }
  }
}
material "Park/Pale" : Park/Grass { }
"""


def test_links_are_where_the_state_has_them():
    """Poses of links in a <state> are the world's; where joints hold links they stay."""
    text = (
        '<model name="lamp"><static>1</static>{joint}'
        '<link name="post"><pose>9 9 9 0 0 0</pose></link>'
        '<link name="head"><pose relative_to="post">0 0 4 0 0 0</pose></link></model>'
        '<state world_name="w"><model name="lamp"><pose>5 6 0 0 0 1.5707963</pose>'
        '<link name="post"><pose>5 6 0 0 0 1.5707963</pose></link>'
        '<link name="head"><pose>5 7 1.5 0 0 1.5707963</pose></link><link name="x"/>'
        "</model></state>"
    )
    world = world_of(text.format(joint=""))
    ((model, _),) = world.models
    assert world.starts["lamp"].position == (5, 6, 0) and model.warnings == []
    assert model.loose["head"].position == pytest.approx((1.0, 0.0, 1.5), abs=1e-6)
    held = '<joint name="j" type="fixed"><parent>post</parent><child>head</child></joint>'
    ((model, _),) = world_of(text.format(joint=held)).models
    assert model.root_pose.position == (9, 9, 9)
    assert model.joints["j"].origin.position == pytest.approx((0.0, 0.0, 4.0), abs=1e-6)


@pytest.mark.parametrize(
    "geometry, scale, height",
    [
        ("<sphere><radius>0.1</radius></sphere>", "2 2 2", 0.2),
        ("<cylinder><radius>0.1</radius><length>0.2</length></cylinder>", "2 2 3", 0.3),
        ("<box><size>0.3 0.2 0.1</size></box>", "1 2 3", 0.15),
        ("<cylinder><radius>0.1</radius><length>0.6</length></cylinder>", "3 2 1", 0.3),
    ],
)
def test_shapes_have_the_scale_of_the_state(geometry, scale, height):
    """They rest at the heights that Gazebo 11.1 has; the last one lies on its side."""
    pose = "<pose>0 0 0 1.5707963 0 0</pose>" if scale == "3 2 1" else ""
    world = World()
    world.load(
        world_of(
            '<model name="ground"><static>1</static><link name="l"><collision name="c"><geometry>'
            "<plane><normal>0 0 1</normal></plane></geometry></collision></link></model>"
            '<model name="m"><link name="l"><inertial><mass>1</mass></inertial><collision name="c">'
            f"{pose}<geometry>{geometry}</geometry></collision></link></model>"
            f'<state world_name="w"><model name="m"><pose>0 0 {height + 0.1} 0 0 0</pose>'
            f"<scale>{scale}</scale></model></state>"
        )
    )
    world.step(1000)
    assert world.model("m").pose.position[2] == pytest.approx(height, abs=1e-4)
    world.close()


def test_models_of_one_name_get_numbers():
    world = world_of('<model name="cone"><link name="a"/></model>' * 3)
    assert [model.name for model, _ in world.models] == ["cone", "cone_1", "cone_2"]
    assert len(world.warnings) == 2 and "'cone_2'" in world.warnings[1]


def test_material_scripts():
    sections = read_script(SCRIPT.replace("1 diffuse", "1\ndiffuse"))
    materials = {section.name: section for section in sections}
    found = {name: look(complete(name, materials)) for name in materials}
    assert (found["Base"].texture, found["Base"].color) == ("", (1, 0, 0, 1))
    assert found["Base"].finish.ambient == (0.1, 0.1, 0.1)
    grass = found["Park/Grass"]
    assert (grass.texture, grass.color) == ("grass.png", (0.2, 0.9, 0.2, 1.0))
    assert found["Park/Pale"] == grass


def visual(material, geometry="<plane><size>4 2</size></plane>"):
    """A model with one visual."""
    return (
        f'<static>true</static><link name="a"><visual name="v"><geometry>{geometry}</geometry>'
        f"{material}</visual></link>"
    )


def scripted(name):
    """A <material> by script name."""
    return (
        f"<material><script><uri>model://park/materials/scripts</uri><uri>model://park/"
        f"materials/textures</uri><name>{name}</name></script></material>"
    )


@pytest.fixture(name="park")
def _park(tmp_path):
    """A model folder with a script and a picture; a resolver for it."""
    for name in ("scripts", "textures"):
        (tmp_path / "materials" / name).mkdir(parents=True)
    (tmp_path / "materials" / "scripts" / "p.material").write_text(SCRIPT)
    Image.new("RGB", (10, 6), (0, 200, 0)).save(tmp_path / "materials" / "textures" / "grass.png")

    def resolve(uri):
        if not uri.startswith("model://park"):
            raise ValueError("searched nowhere")
        return uri.replace("model://park", str(tmp_path))

    return resolve


def test_picture_of_a_script_is_drawn(park, tmp_path):
    model = model_of(visual(scripted("Park/Grass")), resolve=park)
    assert model.warnings == []
    assert model.links["a"].visuals[0].texture == str(
        tmp_path / "materials" / "textures" / "grass.png"
    )
    world, client = World(), Client(draw=True)
    source = world.spawn(model).source
    client.load_text(source.key, visual_urdf(source.links, source.converted), "0")
    view = camera.view_matrix(
        (0, 0, 3), np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    )
    projection = camera.projection_matrix(0.5, 4 / 3, 0.1, 10)
    picture, _ = PyBulletCamera(client).render(64, 48, view, projection)
    client.close()
    world.close()
    red, green, blue = picture[24, 32].astype(int)
    assert green > 60 and red < green / 3 and blue < green / 3


@pytest.mark.parametrize(
    "material, color, warned",
    [
        ("", (1, 1, 1, 1), ""),
        ("<material><ambient>1 0 0 1</ambient></material>", (1, 1, 1, 1), ""),
        (
            "<material><ambient>1 0 0 1</ambient><diffuse>0 1 0 1</diffuse></material>",
            (0, 1, 0, 1),
            "",
        ),
        (
            "<material><diffuse>0 1 0 1</diffuse></material><transparency>0.25</transparency>",
            (0, 1, 0, 0.75),
            "",
        ),
        (scripted("Park/Nothing"), (1, 1, 1, 1), "Park/Nothing"),
        (
            "<material><script><uri>file://media/materials/scripts/gazebo.material</uri><name>Gazebo/White"
            "</name></script></material>",
            (1, 1, 1, 1),
            "",
        ),
    ],
)
def test_colours(park, material, color, warned):
    model = model_of(visual(material), resolve=park)
    assert model.links["a"].visuals[0].color == pytest.approx(color)
    assert [warned in text for text in model.warnings] == ([True] if warned else [])


def test_a_road_has_the_material_of_its_script(park):
    points = "<width>2</width><point>0 0 0</point><point>9 0 0</point>"
    world = world_of(f'<road name="r">{points}{scripted("Park/Grass")}</road>', park)
    assert world.warnings == [] and world.scene.roads[0].texture.endswith("grass.png")


def test_plane_with_a_normal():
    model = model_of(visual("", "<plane><normal>0 1 0</normal><size>4 2</size></plane>"))
    shape = model.links["a"].visuals[0]
    np.testing.assert_allclose(shape.pose.matrix @ (0, 0, 1), (0, 1, 0), atol=1e-12)


def test_a_robot_in_a_world_file():
    world = world_of(
        f'<model name="bot"><link name="a">{MASS}<sensor name="l" type="gpu_ray">'
        "<update_rate>10</update_rate><ray><range><min>0.1</min><max>5</max></range>"
        '</ray><plugin filename="libgazebo_ros_gpu_laser.so"><topicName>scan'
        "</topicName></plugin></sensor></link></model>"
    )
    model, _ = world.models[0]
    assert model.sensors[0].topic == "/scan" and model.warnings == []


def test_static_models_may_be_any_pose(world):
    model = world.spawn(
        model_of(
            '<static>true</static><link name="a"><pose>0 0 1 0 0 0</pose>'
            '<collision name="c"><geometry><box/></geometry></collision>'
            '</link><link name="b"><pose>0 3 0 0 0 0</pose></link>'
        ),
    )
    assert model.description.warnings == []
    assert model.link_state("b")[0] == Pose((0.0, 3.0, 0.0))

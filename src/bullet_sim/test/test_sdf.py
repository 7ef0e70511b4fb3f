"""The SDF subset: worlds and models."""

import pytest
from bullet_sim.description.world import OdeSettings
from bullet_sim.errors import ModelError
from bullet_sim.formats.resolve import Resolver
from bullet_sim.formats.sdf import world as sdf_world
from bullet_sim.formats.sdf.world import parse_model, parse_world
from bullet_sim.pose import Pose
from bullet_sim.world import World

BOX_MODEL = (
    '<model name="crate"><static>true</static><pose>1 2 3 0 0 0</pose><link name="l">'
    '<collision name="c"><geometry><box><size>1 2 3</size></box></geometry><surface>'
    "<friction><ode><mu>0.3</mu></ode></friction></surface></collision></link></model>"
)
MESH_MODEL = (
    '<model name="hall"><static>true</static><link name="l"><collision name="c">'
    "<geometry><mesh><uri>/no/hall.stl</uri></mesh></geometry></collision>"
    '<visual name="v"><geometry><sphere><radius>2</radius></sphere></geometry></visual>'
    "</link></model>"
)


def include(uri, extra=""):
    """An <include>."""
    return f"<include><uri>{uri}</uri>{extra}</include>"


def world_of(content):
    """The WorldDescription of a world with the given content."""
    text = f'<?xml version="1.0"?><sdf version="1.6"><world name="w">{content}</world></sdf>'

    def resolve(uri):
        if uri.startswith("model://"):
            raise ValueError("searched nowhere")
        return uri

    return parse_world(text, resolve, "my.world")


def test_world_with_everything():
    world = world_of(
        include("model://sun")
        + include("model://ground_plane", "<pose>0 0 -1 0 0 0</pose>")
        + '<gravity>0 0 -1.6</gravity><physics type="ode"><max_step_size>0.002</max_step_size>'
        "</physics>" + BOX_MODEL + MESH_MODEL
    )
    assert (world.name, world.gravity, world.step) == ("w", (0, 0, -1.6), 0.002)
    (ground, ground_pose), (crate, crate_pose), (hall, _) = world.models
    assert (ground.name, ground.static) == ("ground_plane", True)
    assert ground_pose.position == (0, 0, -1)
    assert crate.static and crate_pose.position == (1, 2, 3)
    link = crate.links["l"]
    assert link.collisions[0].geometry.size == (1, 2, 3) and link.surface.friction == 0.3
    assert hall.links["l"].collisions == [] and len(hall.links["l"].visuals) == 1
    assert len(hall.warnings) == 1 and "/no/hall.stl" in hall.warnings[0]
    assert world.warnings == hall.warnings  # all models of a file share one list


def test_defaults():
    world = world_of("")
    assert (world.gravity, world.step, world.models) == ((0, 0, -9.8), 0.001, [])


def test_settings_of_ode():
    world = world_of(
        "<physics type='ode'><ode><solver><iters>150</iters><sor>1.4</sor>"
        "<use_dynamic_moi_rescaling>1</use_dynamic_moi_rescaling></solver><constraints>"
        "<cfm>1e-5</cfm><erp>0.3</erp><contact_max_correcting_vel>20</contact_max_correcting_vel>"
        "</constraints></ode></physics>"
    )
    assert world.ode == OdeSettings(150, 1.4, 1e-5, 0.3, 20.0, True)
    answered = (
        "<physics><max_contacts>500</max_contacts><ode><solver><precon_iters>4</precon_iters>"
        "</solver><constraints><contact_surface_layer>0.01</contact_surface_layer></constraints>"
        "</ode></physics>"
    )
    expected = OdeSettings(max_contacts=500, surface_layer=0.01, precon_iterations=4)
    assert world_of(answered).ode == expected, "get_physics_properties answers them"
    many = "<physics><ode><solver><iters>1e12</iters><sor>-1</sor></solver></ode></physics>"
    assert world_of(many).ode == OdeSettings(iterations=10_000, relaxation=0.0)


def test_include_of_an_unknown_model_is_a_warning():
    world = world_of(include("model://castle") + BOX_MODEL)
    assert [model.name for model, _ in world.models] == ["crate"]
    assert len(world.warnings) == 1
    assert "model://castle" in world.warnings[0] and "searched nowhere" in world.warnings[0]


def test_included_file_with_name_and_pose(tmp_path):
    path = tmp_path / "model.sdf"
    path.write_text(f"<sdf>{BOX_MODEL}</sdf>", encoding="utf-8")
    (own, own_pose), (named, named_pose) = world_of(
        include(path)
        + include(path, "<name>b</name><pose>0 0 9 0 0 0</pose><static>false</static>")
    ).models
    assert (own.name, own.static, own_pose.position) == ("crate", True, (1, 2, 3))
    assert (named.name, named.static, named_pose.position) == ("b", False, (0, 0, 9))


def test_a_world_includes_a_urdf_that_a_model_config_names(tmp_path):
    """As sdformat's readFile converts it; a model cannot include one here."""
    (tmp_path / "model.config").write_text("<model><sdf version='1.5'>bot.urdf</sdf></model>")
    moments = "ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'"
    mass = f"<inertial><mass value='1'/><inertia {moments}/></inertial>"
    (tmp_path / "bot.urdf").write_text(
        f"<robot name='bot'><link name='base'>{mass}</link><link name='cam'>{mass}</link><joint "
        "name='j' type='fixed'><parent link='base'/><child link='cam'/></joint></robot>"
    )
    p3d = "<bodyName>base</bodyName><topicName>t</topicName>"
    plugin = f"<plugin name='p' filename='libgazebo_ros_p3d.so'>{p3d}</plugin>"
    more = f"<name>b</name><pose>0 0 9 0 0 0</pose><static>true</static>{plugin}"
    inner = f"<model name='m'><link name='l'/>{include(tmp_path)}</model>"
    world = parse_world(
        f"<sdf version='1.6'><world name='w'>{include(tmp_path)}{include(tmp_path, more)}{inner}"
        "</world></sdf>",
        Resolver(),
    )
    (own, own_pose), (named, named_pose), _ = world.models
    assert (own.name, own.is_urdf, own.static, own_pose) == ("bot", True, False, Pose())
    assert (named.name, named.static, named_pose.position) == ("b", True, (0, 0, 9))
    assert len(named.sensors) == 1 and not own.sensors
    assert [w for w in world.warnings if "only a <world> can include" in w]


def test_a_file_is_read_once_for_each_include(tmp_path, monkeypatch):
    """Also where the pose is that of its model, and its name is asked for by another one."""
    path = tmp_path / "model.sdf"
    path.write_text(f"<sdf>{BOX_MODEL}</sdf>", encoding="utf-8")
    files, read = [], sdf_world.read_file
    monkeypatch.setattr(
        sdf_world, "read_file", lambda *words: (files.append(words[0]), read(*words))[1]
    )
    beside = '<model name="m"><pose relative_to="crate">0 1 0 0 0 0</pose><link name="l"/></model>'
    (_, pose), (_, its_pose) = world_of(beside + include(path)).models
    assert (pose.position, its_pose.position) == ((1, 3, 3), (1, 2, 3))
    assert files == [str(path)]


def test_a_link_without_joint_is_loose():
    model, _ = parse_model(
        '<model name="m"><link name="a"/><link name="b"><pose>0 1 0 0 0 0</pose></link></model>',
        str,
    )
    assert (model.root, model.joints) == ("a", {})
    assert {name: pose.position for name, pose in model.loose.items()} == {"b": (0, 1, 0)}


def test_root_link_off_the_models_frame():
    model, _ = parse_model(
        '<model name="m"><link name="a"><pose>0 0 2 0 0 0</pose><collision '
        'name="c"><geometry><box/></geometry></collision></link></model>',
        str,
    )
    assert model.root_pose.position == (0, 0, 2)
    world = World()
    spawned = world.spawn(model, Pose((1.0, 0.0, 1.0)))
    assert spawned.pose.position == (1.0, 0.0, 1.0)
    assert spawned.link_state("a")[0].position == pytest.approx((1.0, 0.0, 3.0))
    spawned.set_state(Pose((1.0, 0.0, 1.0)), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    assert spawned.motion()[2] == pytest.approx((0.0, 0.0, 0.0))  # as in Gazebo: the link's
    assert spawned.link_state("a")[1] == pytest.approx((0.0, 0.0, 0.0))
    world.close()


LINKS = '<link name="a"/><link name="b"/>'


def model_with(joint):
    """A model with links a and b."""
    return f'<model name="m">{LINKS}{joint}</model>'


REFUSED = [
    ("<broken", ["my.world", "not well-formed", "line 1"]),
    ("<a></b>", ["my.world", "mismatched tag", "line 1"]),
]


@pytest.mark.parametrize("content, parts", REFUSED, ids=[" ".join(p) for _, p in REFUSED])
def test_bad_worlds_are_refused(content, parts):
    with pytest.raises(ModelError) as error:
        world_of(content)
    for part in parts:
        assert part in str(error.value)


def test_axis_gets_unit_length():
    model, _ = parse_model(
        model_with(
            '<joint name="j" type="revolute"><parent>a</parent><child>b'
            "</child><axis><xyz>0 3 4</xyz></axis></joint>"
        ),
        str,
    )
    assert model.joints["j"].axis == pytest.approx((0, 0.6, 0.8))


def test_file_without_a_world_is_refused():
    with pytest.raises(ModelError, match="no <world>"):
        parse_world("<sdf/>", str, "my.world")


def test_of_several_physics_the_default_counts():
    first, second = (
        f"<physics name='{name}'{default}><max_step_size>{step}</max_step_size></physics>"
        for name, default, step in (("slow", "", 0.01), ("fast", " default='1'", 0.002))
    )
    assert world_of(first + second).step == 0.002
    assert world_of(first + second.replace("'1'", "'0'")).step == 0.01


@pytest.mark.parametrize(
    "time, expected",
    [("12 500000000", 12.5), ("3", 3.0), ("", 0.0), ("soon", 0.0), ("-1 0", 0.0), ("1e300 0", 0.0)],
)
def test_time_of_a_saved_world(time, expected):
    state = f"<state world_name='w'><sim_time>{time}</sim_time></state>"
    assert world_of(state).time == expected


def test_lights_are_where_the_state_has_them():
    light = '<light name="l" type="point"><pose>1 2 3 0 0 0</pose></light>'
    state = '<state world_name="w"><light name="l"><pose>4 5 6 0 0 0</pose></light></state>'
    assert world_of(light).scene.lights[0].position == (1, 2, 3)
    assert world_of(light + state).scene.lights[0].position == (4, 5, 6)

"""What of several <gazebo> elements of a URDF counts, as `gz sdf -p` of Gazebo 11.1 shows it."""

import pytest
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import inertial

MASS = inertial(1, 1)
BOX = '<geometry><box size="1 1 1"/></geometry>'
BODY = f"{MASS}<visual>{BOX}</visual><collision>{BOX}</collision>"
LINKS = (
    f'<link name="base">{BODY}</link><link name="plate">{BODY}</link><link name="arm">{BODY}</link>'
    '<joint name="f" type="fixed"><parent link="base"/><child link="plate"/></joint>'
    '<joint name="j" type="continuous"><origin xyz="1 0 0"/><parent link="plate"/>'
    '<child link="arm"/></joint>'
)


def read(*elements):
    """A description of a robot with (reference, content) of <gazebo> elements."""
    text = "".join(
        f"<gazebo{f' reference={name!r}' if name else ''}>{content}</gazebo>"
        for name, content in elements
    )
    return parse_urdf(f'<robot name="r">{LINKS}{text}</robot>', str, "bot")


@pytest.mark.parametrize("name", ["base", "plate"])
def test_a_pose_moves_the_first_link_in_its_model(name):
    """Also one that is said of what is merged into it; the links behind it move along."""
    model = read((name, "<pose>0 0 3 0 0 0</pose>"))
    assert model.root_pose.position == (0, 0, 3) and model.warnings == []
    world = World()
    spawned = world.spawn(model, Pose((0, 0, 1)))
    assert spawned.pose.position == (0, 0, 1)
    for link, place in (("base", (0, 0, 4)), ("arm", (1, 0, 4))):
        assert spawned.link_state(link)[0].position == pytest.approx(place)
    world.close()


def test_a_pose_of_a_link_on_a_joint_has_no_effect():
    model = read(("arm", "<pose>0 0 3 0 0 0</pose>"))
    assert model.root_pose == Pose() and model.poses()["arm"].position == (1, 0, 0)
    (warning,) = model.warnings
    assert "<pose> has no effect, as in Gazebo" in warning and "<origin>" in warning


# elements of <gazebo>, attribute of the link, what it is
FLAGS = {
    "gravity alone": ((("base", "<gravity>0</gravity>"),), "gravity", True),
    "gravity before another element": (
        (("base", "<gravity>0</gravity>"), ("base", "<mu1>1</mu1>")),
        "gravity",
        False,
    ),
    "gravity before an element of a merged link": (
        (("plate", "<mu1>1</mu1>"), ("base", "<gravity>0</gravity>")),
        "gravity",
        False,
    ),
    "the last turnGravityOff of an element": (
        (("base", "<turnGravityOff>0</turnGravityOff><turnGravityOff>1</turnGravityOff>"),),
        "gravity",
        False,
    ),
    "no word that sdformat knows": (
        (("base", "<turnGravityOff>maybe</turnGravityOff>"),),
        "gravity",
        False,
    ),
    "a decay behind an element without": (
        (("base", "<mu1>1</mu1>"), ("base", "<dampingFactor>0.1</dampingFactor>")),
        "decay",
        (0.0, 0.0),
    ),
    "the first kinematic": (
        (("base", "<kinematic>1</kinematic>"), ("plate", "<kinematic>0</kinematic>")),
        "kinematic",
        True,
    ),
    "self_collide before selfCollide": (
        (("base", "<self_collide>1</self_collide>"), ("base", "<selfCollide>0</selfCollide>")),
        "self_collide",
        False,
    ),
    "selfCollide before self_collide": (
        (("base", "<selfCollide>0</selfCollide><self_collide>1</self_collide>"),),
        "self_collide",
        False,
    ),
    "wind of the model": (((None, "<enable_wind>1</enable_wind>"),), "wind", True),
}


@pytest.mark.parametrize("elements, name, expected", FLAGS.values(), ids=FLAGS)
def test_which_of_several_flags_counts(elements, name, expected):
    model = read(*elements)
    assert getattr(model.links["base"], name) == expected


def test_whether_a_model_is_static_is_what_its_last_element_says():
    """sdformat 9.3 writes it for each, from 9.6 on for those alone that say it."""
    static = (None, "<static>true</static>")
    assert read(static).static and read((None, "<self_collide>1</self_collide>"), static).static
    assert not read(static, (None, "<self_collide>1</self_collide>")).static


def test_what_a_model_says_of_collisions_is_what_sdf_calls_it():
    assert read((None, "<self_collide>1</self_collide>")).self_collide
    model = read((None, "<selfCollide>1</selfCollide>"))
    assert not model.self_collide and "<self_collide> has" in model.warnings[0]


def test_later_elements_of_a_joint_keep_what_earlier_ones_say():
    joint = read(
        ("j", "<implicitSpringDamper>1</implicitSpringDamper><stopErp>0.4</stopErp>"),
        ("j", "<stopErp>0.5</stopErp><stopErp>0.6</stopErp><stopCfm>0.1</stopCfm>"),
        ("j", "<physics><ode><limit><erp>0.9</erp></limit></ode></physics>"),
    ).joints["j"]
    assert (joint.implicit_damping, joint.stop_erp, joint.stop_cfm) == (True, 0.6, 0.1)


def test_an_ode_element_of_a_joint_has_limits_of_its_own():
    """Not those of the world: Gazebo reads its <limit>, whether it is there or not."""
    text = (
        "<sdf version='1.6'><model name='m'><link name='a'/><link name='b'/><joint name='j' "
        "type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis>{}</joint>"
        "</model></sdf>"
    )
    for inside, expected in (
        ("", (None, None)),
        ("<physics><ode><cfm_damping>1</cfm_damping></ode></physics>", (0.2, 0.0)),
    ):
        joint = parse_model(text.format(inside), str)[0].joints["j"]
        assert (joint.stop_erp, joint.stop_cfm) == expected
        assert not joint.implicit_damping, "cfm_damping alone is nothing that Gazebo 11 reads"


def test_the_first_of_what_is_copied_into_shapes_counts():
    model = read(
        ("base", "<collision><laser_retro>1</laser_retro></collision>"),
        ("base", "<collision><laser_retro>2</laser_retro></collision>"),
        ("base", "<visual><transparency>0.5</transparency></visual>"),
        ("base", "<visual><transparency>0.9</transparency></visual>"),
        ("base", "<mu1>0.1</mu1><mu1>0.2</mu1><maxContacts>3</maxContacts>"),
        ("base", "<collision><max_contacts>5</max_contacts></collision>"),
    )
    link = model.links["base"]
    assert link.collisions[0].laser_retro == 1.0 and link.visuals[0].finish.opacity == 0.5
    assert (link.surface.friction, link.surface.most) == (0.2, 3)


@pytest.mark.parametrize("name", ["base", "j"])
def test_a_plugin_within_a_reference_is_not_loaded(name):
    plugin = '<plugin name="p" filename="libgazebo_ros_planar_move.so"/>'
    model = read((name, plugin))
    (warning,) = model.warnings
    assert model.sensors == [] and "without reference" in warning
    assert len(read((None, plugin)).sensors) == len(read(("", plugin)).sensors) == 1


def test_a_sensor_of_a_link_that_is_merged_is_in_that_links_frame():
    """Its own <pose> counts for nothing in sdformat up to 9.8."""
    plugin = '<plugin filename="libgazebo_ros_imu_sensor.so"><frameName>f</frameName></plugin>'
    for place, x, count in (("1 0 0 0 0 0", 0.0, 1), ("0 0 0 0 0 0", 0.0, 0)):
        sensor = f'<sensor name="s" type="imu"><pose>{place}</pose>{plugin}</sensor>'
        model = read(("plate", sensor))
        (spec,) = model.sensors
        assert (spec.link, spec.pose[0][0]) == ("plate", x) and len(model.warnings) == count
    (spec,) = read(("base", sensor.replace("0 0 0 0 0 0", "1 0 0 0 0 0"))).sensors
    assert spec.pose[0][0] == 1.0


def test_sensors_of_no_link_are_left_out():
    sensor = '<sensor name="s" type="{}"/>'
    for name, kind, count in ((None, "imu", 1), ("j", "imu", 1), ("j", "force_torque", 0)):
        model = read((name, sensor.format(kind)))
        assert model.sensors == [] and len(model.warnings) == count


@pytest.mark.parametrize("tag", ["link", "model", "include"])
def test_what_gazebo_takes_into_the_model_and_is_not_read_here_is_told(tag):
    (warning,) = read((None, f'<{tag} name="more"/>')).warnings
    assert f"<{tag}> has an effect in Gazebo and is ignored here" in warning


def test_a_flag_to_keep_a_joint_counts_wherever_it_is():
    tags = "<preserveFixedJoint>0</preserveFixedJoint><preserveFixedJoint>1</preserveFixedJoint>"
    assert read(("f", tags)).kept == {"f"}

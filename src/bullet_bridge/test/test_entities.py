"""Names of the services -> models, links, joints, frames; and what a namespace does to a model."""

import math

import numpy as np
import pytest
from bullet_bridge.services.entities import find_frame, find_joint, find_link, find_model
from bullet_sim.errors import WorldError
from bullet_sim.formats.spawn_text import SpawnText
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from urdf_texts import link

pytestmark = pytest.mark.usefixtures("sketches")

GRAVITY = (0.0, 0.0, 0.0)

LINK = link("{}")
URDF = (
    '<robot name="r">' + LINK.format("base") + LINK.format("arm") + '<joint name="hinge" '
    'type="continuous"><origin xyz="1 0 0"/><parent link="base"/><child link="arm"/>'
    '<axis xyz="0 0 1"/></joint></robot>'
)
TURNED = Pose.from_xyz_rpy((1, 2, 3), (0, 0, math.pi / 2))


@pytest.fixture(name="world")
def _world(world):
    world.spawn_urdf("first", URDF, TURNED, str)
    world.spawn_urdf("second", URDF, Pose((10, 0, 0)), str)
    return world


@pytest.mark.parametrize(
    "find, name, expected",
    [
        (find_link, "second::arm", ("second", "arm")),
        (find_link, "arm", ("first", "arm")),
        (find_joint, "hinge", ("first", "hinge")),
        (find_joint, "second::hinge", ("second", "hinge")),
    ],
)
def test_scoped_and_plain_names(world, find, name, expected):
    model, part = find(world, name)
    assert (model.name, part) == expected


@pytest.mark.parametrize(
    "find, name, parts",
    [
        (find_link, "nose", ["link 'nose'", "first::base", "second::arm"]),
        (find_link, "ghost::arm", ["link 'ghost::arm'"]),
        (find_link, "", ["link ''"]),
        (find_joint, "first::arm", ["joint 'first::arm'", "first::hinge"]),
        (find_frame, "moon", ["reference frame 'moon'"]),
    ],
)
def test_unknown_names_are_listed_with_the_known_ones(world, find, name, parts):
    with pytest.raises(WorldError) as error:
        find(world, name)
    for part in parts:
        assert part in str(error.value)


def test_what_comes_first_of_a_name_hides_the_others_as_in_gazebo(world):
    """World::EntityByName, whose result is cast to what is looked for (gazebo_ros_api_plugin)."""
    world.spawn_urdf("base", URDF, Pose((20, 0, 0)), str)
    with pytest.raises(WorldError, match="'base' is a link"):
        find_model(world, "base")
    assert find_link(world, "base::base")[0].name == "base"
    one = '<sdf version="1.6"><model name="x"><link name="one"/></model></sdf>'
    world.spawn_sdf("one", one, Pose((30, 0, 0)), str)
    with pytest.raises(WorldError, match="'one' is a model"):
        find_link(world, "one")
    with pytest.raises(WorldError, match="'hinge' is a joint"):
        find_frame(world, "hinge")


def test_a_long_list_of_names_is_cut(world):
    for number in range(20):
        world.spawn_urdf(f"more{number}", URDF, Pose((0, 0, 10 + number)), str)
    with pytest.raises(WorldError, match="and 14 more"):
        find_link(world, "nose")


@pytest.mark.parametrize("name", ["", "world", "map", "/map"])
def test_world_frames(world, name):
    pose, linear, angular = find_frame(world, name).inward(TURNED, np.ones(3), np.zeros(3))
    assert pose.position == TURNED.position and pose.orientation == TURNED.orientation
    assert linear.tolist() == [1, 1, 1] and angular.tolist() == [0, 0, 0]


def test_frame_of_a_moving_model(world):
    world.model("first").set_state(TURNED, (0.5, 0, 0), (0, 0, 2.0))
    frame = find_frame(world, "first")
    pose, linear, angular = frame.inward(Pose((1, 3, 3)), np.array((0.5, 1, 0)), np.zeros(3))
    assert pose.position == pytest.approx((1, 0, 0), abs=1e-6)
    np.testing.assert_allclose(linear, (1, 0, 0), atol=1e-6)  # along the model's axes
    np.testing.assert_allclose(angular, (0, 0, -2), atol=1e-6)
    arm = find_frame(world, "first::arm")
    assert arm.pose.position == pytest.approx((1, 3, 3), abs=1e-6)
    np.testing.assert_allclose(arm.linear, (0.5, 0, 0), atol=1e-6)  # as Model::SetLinearVel


PLUGINS = (
    '<robot name="r"><gazebo><plugin name="a"/></gazebo><gazebo reference="l"><sensor>'
    '<plugin name="b"><robotNamespace>/own</robotNamespace></plugin><plugin name="c"/>'
    "</sensor></gazebo></robot>"
)


def given_namespace(text, namespace):
    """The text of a spawn request with a namespace."""
    return SpawnText.read(text, namespace).text


def namespaces(root):
    """The <robotNamespace> of each plugin."""
    return [plugin.findtext("robotNamespace") for plugin in root.iter("plugin")]


def test_a_namespace_goes_to_plugins_that_have_none():
    root = given_namespace(PLUGINS, "/car")
    assert namespaces(root) == ["/car", "/own", "/car"] and root.tag == "robot"
    declared = '<?xml version="1.0" encoding="utf-8"?>' + PLUGINS
    assert namespaces(given_namespace(declared, "/car")) == ["/car", "/own", "/car"]


def test_lines_and_warnings_stay_through_a_namespace():
    text = '<robot name="r">\n<!-- a\n -- b -->\n<link name="l"/><link/>\n</robot>'
    warnings = parse_urdf(given_namespace(text, "/car"), str, "car").warnings
    assert len(warnings) == 2 and "not well-formed XML" in warnings[0]
    assert "URDF of 'car', line 4: link '' of 'car' has no name" in warnings[1]


def test_texts_that_stay_as_they_are():
    assert namespaces(given_namespace(PLUGINS, "")) == [None, "/own", None]
    for text in ("<robot", ""):
        assert given_namespace(text, "/car") == text


LIGHT = "<light name='l' type='point'/>"
INCLUDE = "<include><uri>u</uri></include>"


@pytest.mark.parametrize(
    "text, kind, takes",
    [
        ("<robot name='r'/>", "urdf", True),
        ("<?xml version='1.0'?><!-- a <sdf> --><robot", "urdf", True),
        ("<sdf version='1.6'><model name='m'/></sdf>", "sdf", True),
        (f"<sdf version='1.6'><world name='w'>{INCLUDE}</world></sdf>", "sdf", True),
        ("<sdf version='1.6'><world name='w'><model name='m'/></world></sdf>", "sdf", False),
        ("<gazebo version='1.2'><model name='m'/></gazebo>", "sdf", False),
        (f"<sdf version='1.6'>{LIGHT}</sdf>", "light", True),
        (f"<sdf version='1.6'><model name='m'/>{LIGHT}</sdf>", "sdf", True),
        ("<model name='m'/>", "", True),
        ("<sdf", "sdf", True),
        ("", "", True),
        ("no XML", "", True),
    ],
)
def test_texts_are_sorted_as_gazebo_ros_does(text, kind, takes):
    found = SpawnText.read(text, "")
    assert (found.kind, found.takes_request) == (kind, takes)

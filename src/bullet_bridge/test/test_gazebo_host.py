"""Plugins in C++, as far as no Gazebo is needed: what is found, what Gazebo's World is told."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from bullet_bridge.gazebo_host import libraries, texts
from bullet_sim.plugins import cpp
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import joint, link, robot

MODEL = """<sdf version="1.6"><model name="thing">
<link name="base"><pose>0 0 0.1 0 0 0</pose><inertial><pose>0.01 0 0 0 0 0</pose><mass>2</mass>
<inertia><ixx>0.1</ixx><iyy>0.2</iyy><izz>0.15</izz></inertia></inertial>
<collision name="hull"><geometry><box><size>1 2 3</size></box></geometry></collision></link>
<link name="arm"><pose>0.5 0 0.2 0 0 0.3</pose><inertial><mass>1</mass></inertial></link>
<link name="tip"><pose>0.7 0 0.2 0 0 0.3</pose><inertial><mass>0.5</mass></inertial></link>
<joint name="hinge" type="revolute"><parent>base</parent><child>arm</child><axis><xyz>0 0 1</xyz>
<limit><lower>-1</lower><upper>2</upper><effort>5</effort><velocity>3</velocity></limit></axis>
</joint><joint name="weld" type="fixed"><parent>arm</parent><child>tip</child></joint>{}</model>
</sdf>"""
PLUGIN = '<plugin name="p" filename="libmine.so"><value>3</value></plugin>'
URDF = robot(
    link("base", inertia=1), link("box", inertia=1, center="0 0 1"),
    joint("weld", "fixed", "base", "box"),
)  # fmt: skip


def no_file(uri):
    raise ValueError(uri)


@pytest.fixture
def world():
    made = World()
    yield made
    made.close()


def numbers(element, path):
    return [float(word) for word in element.find(path).text.split()]


def test_gazebo_is_told_the_links_and_joints_that_it_has(world):
    model = world.spawn_sdf("thing", MODEL.format(""), Pose((1.0, 2.0, 3.0)), no_file)
    root = ElementTree.fromstring(texts.model_text(model))
    told = root.find("model")
    assert numbers(told, "pose") == [1, 2, 3, 0, 0, 0]
    links = {link.get("name"): link for link in told.iter("link")}
    assert list(links) == ["base", "arm", "tip"]
    assert numbers(links["tip"], "pose") == pytest.approx([0.7, 0, 0.2, 0, 0, 0.3])
    assert numbers(links["base"], "inertial/pose")[:3] == [0.01, 0, 0]
    assert links["base"].find("collision").get("name") == "hull"
    joints = {joint.get("name"): joint for joint in told.iter("joint")}
    assert {name: joint.get("type") for name, joint in joints.items()} == {
        "hinge": "revolute",
        "weld": "fixed",
    }
    limit = joints["hinge"].find("axis/limit")
    assert [float(each.text) for each in limit] == [-1, 2, 5, 3]
    assert joints["weld"].find("parent").text == "arm"


def test_of_a_urdf_it_has_what_fixed_joints_leave(world):
    model = world.spawn_urdf("thing", URDF, Pose(), no_file)
    links = list(ElementTree.fromstring(texts.model_text(model)).iter("link"))
    assert [link.get("name") for link in links] == ["base"]
    assert numbers(links[0], "inertial/mass") == [2]
    np.testing.assert_allclose(numbers(links[0], "inertial/pose")[:3], [0, 0, 0.5])


@pytest.fixture
def built(tmp_path, monkeypatch):
    """A folder with a user's library, in which Gazebo looks, and no host."""
    (tmp_path / "libmine.so").write_text("")
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    monkeypatch.setenv("LD_LIBRARY_PATH", "")
    monkeypatch.setenv("CMAKE_PREFIX_PATH", "")
    return tmp_path


def use(problem=None):
    found = libraries.users_libraries()
    return cpp.use(found if problem is None else cpp.Libraries(found.folder_of, problem))


def test_a_library_that_is_there_is_one_of_a_plugin_in_cpp(world, built):
    end = use(problem="")
    try:
        model = world.spawn_sdf("thing", MODEL.format(PLUGIN), Pose(), no_file)
    finally:
        end()
    (spec,) = model.description.sensors
    assert (spec.name, spec.folder) == ("p", str(built))
    assert ElementTree.fromstring(spec.text).find("value").text == "3"
    assert list(model.description.warnings) == []


def test_without_gazebos_libraries_a_warning_says_what_brings_them(world, built):
    end = use()
    try:
        model = world.spawn_sdf("thing", MODEL.format(PLUGIN), Pose(), no_file)
    finally:
        end()
    assert model.description.sensors == []
    (warning,) = model.description.warnings
    assert "libmine.so' is in C++, and Gazebo's libraries are not there: ./run add" in warning


def test_a_library_that_is_nowhere_is_unknown_as_ever(world, built):
    end = use()
    try:
        model = world.spawn_sdf("thing", MODEL.format(PLUGIN.replace("mine", "x")), Pose(), no_file)
    finally:
        end()
    (warning,) = model.description.warnings
    assert "'libx.so' is not known here and is ignored" in warning


def test_steps_are_made_one_at_a_time_by_a_stepper(world):
    world.spawn_sdf("thing", MODEL.format(""), Pose((0.0, 0.0, 5.0)), no_file)
    counts = []

    def stepper(count=1, efforts=(), records=False):
        counts.append(count)
        return world.engine.step(count, efforts, records)

    world.stepper = stepper
    world.step(5)
    assert counts == [1] * 5
    assert world.step_count == 5

"""URIs and relative world files become paths."""

import os

import pytest
import rospkg
from bullet_bridge.resolve import RosPackages
from bullet_sim.formats.resolve import FolderPackages, Resolver

WORLD = '<sdf version="1.6"><world name="w"/></sdf>'


def resolver():
    """A Resolver that finds packages by rospkg."""
    return Resolver(RosPackages())


def test_packages_are_found_without_rospkg_as_with_it():
    with_rospkg, without = RosPackages(), FolderPackages()
    names = set(with_rospkg.names())
    assert "bullet_sim" in names and names <= set(without.names())  # which has metapackages, too
    assert all(with_rospkg.folder(name) == without.folder(name) for name in names)
    for key in ("gazebo_model_path", "gazebo_media_path"):
        assert set(with_rospkg.exported(key)) == set(without.exported(key))


def make_package(folder, name="park_sim", more=""):
    """A package, and what it depends on and exports."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f"""<package format="2"><name>{name}</name>
        <version>0.0.1</version><description>d</description>
        <maintainer email="a@example.org">a</maintainer><license>MIT</license>{more}</package>""")


@pytest.fixture(name="models")
def model_folder(tmp_path, monkeypatch):
    """A model folder on GAZEBO_MODEL_PATH."""
    (tmp_path / "cone" / "scripts").mkdir(parents=True)
    (tmp_path / "cone" / "model.sdf").write_text("<sdf/>")
    (tmp_path / "cone" / "cone.obj").write_text("")
    monkeypatch.setenv("GAZEBO_MODEL_PATH", f"/nowhere:{tmp_path}")
    return tmp_path


@pytest.mark.parametrize(
    "uri, path",
    [
        ("package://bullet_bridge/package.xml", "{share}/package.xml"),
        ("model://bullet_bridge/package.xml", "{share}/package.xml"),
        ("model://cone", "{models}/cone/model.sdf"),
        ("model://cone/cone.obj", "{models}/cone/cone.obj"),
        ("model://cone/scripts", "{models}/cone/scripts"),
        ("package://cone/cone.obj", "{models}/cone/cone.obj"),  # a package's name that is a model
        ("{models}/cone", "{models}/cone/model.sdf"),
        ("file://{models}/cone", "{models}/cone/model.sdf"),
        ("file:///a/b.stl", "/a/b.stl"),
        ("/a/b.stl", "/a/b.stl"),
    ],
)
def test_where_a_uri_leads(models, uri, path):
    places = {"models": models, "share": rospkg.RosPack().get_path("bullet_bridge")}
    assert resolver()(uri.format(**places)) == path.format(**places)


@pytest.mark.parametrize(
    "uri, text",
    [
        ("package://no_such_pkg/a.stl", "package 'no_such_pkg'"),
        ("model://no_such_model", "no_such_model.*/nowhere.*{models}"),
        ("http://x/y.stl", "scheme 'http'"),
        ("b.stl", "'b.stl' is in none of"),
        ("", "is empty"),
    ],
)
def test_what_leads_nowhere_is_named(models, uri, text):
    with pytest.raises(ValueError, match=text.format(models=models)):
        resolver()(uri)


def test_world_files_as_they_are_and_of_gazebo_ros(tmp_path, monkeypatch):
    monkeypatch.delenv("GAZEBO_RESOURCE_PATH", raising=False)
    (tmp_path / "a.world").write_text(WORLD)
    monkeypatch.chdir(tmp_path)
    worlds = f"{rospkg.RosPack().get_path('gazebo_ros')}/worlds"
    for name, path in (
        ("a.world", "a.world"),
        (f"{tmp_path}/a.world", f"{tmp_path}/a.world"),
        ("worlds/empty.world", f"{worlds}/empty.world"),
        ("empty_world.world", f"{worlds}/empty_world.world"),
        ("file://worlds/shapes.world", f"{worlds}/shapes.world"),
    ):
        assert resolver().world(name) == path


@pytest.mark.parametrize(
    "text, name",
    [
        ("<a>package://bullet_bridge/a.stl</a> package://rospy/", None),
        ("package://bullet_bridge/a <!-- package://no_such_pkg/a\n --> ", None),
        ("package://bullet_bridge/a\n package://no_such_pkg/b package://nor_this/c", "no_such_pkg"),
        ("package://cone/cone.obj", "cone"),  # a model's folder is no package
        ("package:///a", ""),
        ("model://no_such_pkg/a package://no_end", None),
    ],
)
def test_the_package_that_is_missing(models, text, name):
    assert resolver().missing_package(text) == name


@pytest.mark.parametrize(
    "config, file",
    [
        (
            '<model><sdf version="1.4">old.sdf</sdf><sdf version="1.6">new.sdf</sdf></model>',
            "new.sdf",
        ),
        (
            '<model><sdf version="1.10">new.sdf</sdf><sdf version="1.4">old.sdf</sdf></model>',
            "old.sdf",
        ),
        (
            '<model><sdf version="1.8">new.sdf</sdf><sdf version="1.9">old.sdf</sdf></model>',
            "new.sdf",
        ),
        (
            '<model><sdf version="1.5">old.sdf</sdf><sdf version="1.7">new.sdf</sdf></model>',
            "new.sdf",
        ),
        (
            '<model><sdf version="1.5">new.sdf</sdf><sdf version="1.5">old.sdf</sdf></model>',
            "new.sdf",
        ),
        ("<model><sdf>old.sdf</sdf><sdf>new.sdf</sdf></model>", "old.sdf"),
        ("<model><more><sdf>old.sdf</sdf></more></model>", "model.sdf"),
        ("<model><sdf>lost.sdf</sdf></model>", "model.sdf"),
        ("<model", "model.sdf"),
    ],
)
def test_model_config_names_the_file(models, config, file):
    for name in ("old.sdf", "new.sdf"):
        (models / "cone" / name).write_text("<sdf/>")
    (models / "cone" / "model.config").write_text(config)
    assert resolver()("model://cone") == str(models / "cone" / file)


def test_a_manifest_of_old_names_the_file_where_there_is_no_config(models):
    (models / "cone" / "old.sdf").write_text("<sdf/>")
    (models / "cone" / "manifest.xml").write_text("<model><sdf>old.sdf</sdf></model>")
    assert Resolver()("model://cone") == str(models / "cone" / "old.sdf")


@pytest.mark.parametrize(
    "depends", ["<depend>gazebo_ros</depend>", "<exec_depend>gazebo_ros</exec_depend>", ""]
)
def test_a_package_exports_its_model_folder(tmp_path, monkeypatch, depends):
    package = tmp_path / "park_sim"
    (package / "models" / "tree").mkdir(parents=True)
    (package / "models" / "tree" / "model.sdf").write_text("<sdf/>")
    export = '<export><gazebo_ros gazebo_model_path="${prefix}/models"/></export>'
    make_package(package, more=depends + export)
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "package.xml").write_text("<package><name>broken</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}:{os.environ['ROS_PACKAGE_PATH']}")
    assert resolver()("model://tree") == str(package / "models" / "tree" / "model.sdf")


def test_models_of_the_home_folder(tmp_path, monkeypatch):
    folder = tmp_path / ".gazebo" / "models" / "tree"
    folder.mkdir(parents=True)
    (folder / "model.sdf").write_text("<sdf/>")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("GAZEBO_MODEL_PATH", raising=False)
    assert resolver()("model://tree") == str(folder / "model.sdf")


def test_relative_file_in_resource_path(tmp_path, monkeypatch):
    (tmp_path / "media").mkdir()
    (tmp_path / "media" / "a.stl").write_text("")
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", str(tmp_path))
    assert resolver()("file://media/a.stl") == str(tmp_path / "media" / "a.stl")
    with pytest.raises(ValueError, match="'media/b.stl' is in none of .*" + str(tmp_path)):
        resolver()("file://media/b.stl")


def test_world_file_in_resource_path(tmp_path, monkeypatch):
    (tmp_path / "worlds").mkdir()
    (tmp_path / "worlds" / "empty.world").write_text(WORLD)
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", f"/nowhere::{tmp_path}")
    assert resolver().world("worlds/empty.world") == str(tmp_path / "worlds" / "empty.world")


def test_world_file_in_the_media_path_of_a_package(tmp_path, monkeypatch):
    package = tmp_path / "park_sim"
    (package / "worlds").mkdir(parents=True)
    (package / "worlds" / "park.world").write_text(WORLD)
    export = '<export><gazebo_ros gazebo_media_path="/nowhere:${prefix}"/></export>'
    make_package(package, more=export)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}:{os.environ['ROS_PACKAGE_PATH']}")
    assert resolver().world("worlds/park.world") == str(package / "worlds" / "park.world")


def test_missing_world_file_names_all_places(tmp_path, monkeypatch):
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", f"/nowhere:{tmp_path}")
    with pytest.raises(ValueError) as error:
        resolver().world("worlds/none.world")
    for part in (
        "worlds/none.world",
        os.getcwd(),
        "/nowhere",
        str(tmp_path),
        rospkg.RosPack().get_path("gazebo_ros"),
    ):
        assert part in str(error.value)


PLACES = ("", "models", "media/models", "Media/models")


@pytest.mark.parametrize("variable", ["GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH"])
@pytest.mark.parametrize("below", PLACES)
@pytest.mark.parametrize("uri", ["model://cone/cone.obj", "file://cone/cone.obj", "cone/cone.obj"])
def test_every_uri_below_every_resource_path(tmp_path, monkeypatch, variable, below, uri):
    folder = tmp_path / below / "cone"
    folder.mkdir(parents=True)
    (folder / "cone.obj").write_text("")
    (folder / "model.sdf").write_text("<sdf/>")
    monkeypatch.setenv(variable, f"/nowhere:{tmp_path}")
    assert resolver()(uri) == str(folder / "cone.obj")
    assert resolver()(uri.rpartition("/")[0]) == str(folder / "model.sdf")


@pytest.mark.parametrize("uri", ["file://media/materials/scripts", "media/materials/scripts"])
def test_a_folder_of_materials(tmp_path, monkeypatch, uri):
    (tmp_path / "media" / "materials" / "scripts").mkdir(parents=True)
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", str(tmp_path))
    assert resolver()(uri) == str(tmp_path / "media" / "materials" / "scripts")


def test_a_model_comes_before_a_folder_of_its_name(tmp_path, monkeypatch):
    (tmp_path / "one" / "cone").mkdir(parents=True)
    (tmp_path / "two" / "cone").mkdir(parents=True)
    (tmp_path / "two" / "cone" / "model.sdf").write_text("<sdf/>")
    monkeypatch.setenv("GAZEBO_MODEL_PATH", f"{tmp_path}/one:{tmp_path}/two")
    assert resolver()("model://cone") == str(tmp_path / "two" / "cone" / "model.sdf")


@pytest.mark.parametrize("below", ["worlds/models", "worlds", "models", "."])
def test_beside_the_world_and_in_its_package(tmp_path, below):
    make_package(tmp_path / "park")
    folder = tmp_path / "park" / below / "tree"
    folder.mkdir(parents=True)
    (folder / "model.sdf").write_text("<sdf/>")
    resolve = resolver()
    with pytest.raises(ValueError, match="model 'tree' is in none of"):
        resolve("model://tree")
    resolve.set_world(str(tmp_path / "park" / "worlds" / "park.world"))
    assert resolve("model://tree") == str(folder / "model.sdf")


def test_paths_of_another_machine(tmp_path, monkeypatch, models):
    make_package(tmp_path / "here" / "park_sim")
    mesh = tmp_path / "here" / "park_sim" / "meshes" / "m.stl"
    mesh.parent.mkdir()
    mesh.write_text("")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}/here:{os.environ['ROS_PACKAGE_PATH']}")
    resolve = resolver()
    assert resolve("file:///home/ann/ws/src/park_sim/meshes/m.stl") == str(mesh)
    assert resolve("/home/ann/.gazebo/models/cone/cone.obj") == str(models / "cone" / "cone.obj")
    for path in ("/home/ann/ws/src/park_sim/meshes/n.stl", "/home/ann/m.stl"):
        assert resolve(path) == path

"""URIs and relative world files become paths."""

import os

import pytest
import rospkg
from bullet_bridge.resolve import Resolver, find_world
from bullet_sim.errors import SimError

from bullet_bridge import node

WORLD = '<sdf version="1.6"><world name="w"/></sdf>'


@pytest.fixture(name="models")
def model_folder(tmp_path, monkeypatch):
    """A model folder on GAZEBO_MODEL_PATH."""
    (tmp_path / "cone").mkdir()
    (tmp_path / "cone" / "model.sdf").write_text("<sdf/>")
    (tmp_path / "cone" / "cone.obj").write_text("")
    monkeypatch.setenv("GAZEBO_MODEL_PATH", f"/nowhere:{tmp_path}")
    return tmp_path


def test_package():
    share = rospkg.RosPack().get_path("bullet_bridge")
    assert Resolver()("package://bullet_bridge/package.xml") == f"{share}/package.xml"


def test_unknown_package_is_named():
    with pytest.raises(ValueError, match="package 'no_such_pkg'"):
        Resolver()("package://no_such_pkg/a.stl")


def test_model_by_name_and_file(models):
    resolve = Resolver()
    assert resolve("model://cone") == str(models / "cone" / "model.sdf")
    assert resolve("model://cone/cone.obj") == str(models / "cone" / "cone.obj")


def test_model_path_of_a_package():
    share = rospkg.RosPack().get_path("bullet_bridge")
    assert Resolver()("model://bullet_bridge/package.xml") == f"{share}/package.xml"


def test_a_folder_within_a_model(models):
    (models / "cone" / "materials" / "scripts").mkdir(parents=True)
    assert Resolver()("model://cone/materials/scripts") == str(
        models / "cone" / "materials" / "scripts"
    )


@pytest.mark.parametrize(
    "config, file",
    [
        (
            '<model><sdf version="1.4">old.sdf</sdf><sdf version="1.6">new.sdf</sdf></model>',
            "new.sdf",
        ),
        ("<model><sdf>lost.sdf</sdf></model>", "model.sdf"),
        ("<model", "model.sdf"),
    ],
)
def test_model_config_names_the_file(models, config, file):
    for name in ("old.sdf", "new.sdf"):
        (models / "cone" / name).write_text("<sdf/>")
    (models / "cone" / "model.config").write_text(config)
    assert Resolver()("model://cone") == str(models / "cone" / file)


@pytest.mark.parametrize(
    "depends", ["<depend>gazebo_ros</depend>", "<exec_depend>gazebo_ros</exec_depend>", ""]
)
def test_a_package_exports_its_model_folder(tmp_path, monkeypatch, depends):
    package = tmp_path / "park_sim"
    (package / "models" / "tree").mkdir(parents=True)
    (package / "models" / "tree" / "model.sdf").write_text("<sdf/>")
    (package / "package.xml").write_text(f"""<package format="2"><name>park_sim</name>
        <version>0.0.1</version><description>d</description>
        <maintainer email="a@example.org">a</maintainer><license>MIT</license>{depends}
        <export><gazebo_ros gazebo_model_path="${{prefix}}/models"/></export></package>""")
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "package.xml").write_text("<package><name>broken</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}:{os.environ['ROS_PACKAGE_PATH']}")
    assert Resolver()("model://tree") == str(package / "models" / "tree" / "model.sdf")


def test_models_of_the_home_folder(tmp_path, monkeypatch):
    folder = tmp_path / ".gazebo" / "models" / "tree"
    folder.mkdir(parents=True)
    (folder / "model.sdf").write_text("<sdf/>")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("GAZEBO_MODEL_PATH", raising=False)
    assert Resolver()("model://tree") == str(folder / "model.sdf")


def test_a_models_folder_by_path(models):
    assert Resolver()(str(models / "cone")) == str(models / "cone" / "model.sdf")
    assert Resolver()(f"file://{models / 'cone'}") == str(models / "cone" / "model.sdf")


def test_relative_file_in_resource_path(tmp_path, monkeypatch):
    (tmp_path / "media").mkdir()
    (tmp_path / "media" / "a.stl").write_text("")
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", str(tmp_path))
    assert Resolver()("file://media/a.stl") == str(tmp_path / "media" / "a.stl")
    assert Resolver()("file://media/b.stl") == "media/b.stl"


def test_unknown_model_names_it_and_the_folders(models):
    with pytest.raises(ValueError) as error:
        Resolver()("model://no_such_model")
    assert "no_such_model" in str(error.value)
    assert str(models) in str(error.value) and "/nowhere" in str(error.value)


def test_file_and_absolute_path():
    assert Resolver()("file:///a/b.stl") == "/a/b.stl"
    assert Resolver()("/a/b.stl") == "/a/b.stl"


@pytest.mark.parametrize(
    "uri, text",
    [("http://x/y.stl", "scheme 'http'"), ("b.stl", "absolute path"), ("", "absolute path")],
)
def test_other_uris_are_errors(uri, text):
    with pytest.raises(ValueError, match=text):
        Resolver()(uri)


def test_world_file_as_it_is(tmp_path, monkeypatch):
    (tmp_path / "a.world").write_text(WORLD)
    monkeypatch.chdir(tmp_path)
    assert find_world("a.world") == "a.world"
    assert find_world(str(tmp_path / "a.world")) == str(tmp_path / "a.world")


def test_world_file_in_resource_path(tmp_path, monkeypatch):
    (tmp_path / "worlds").mkdir()
    (tmp_path / "worlds" / "empty.world").write_text(WORLD)
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", f"/nowhere::{tmp_path}")
    assert find_world("worlds/empty.world") == str(tmp_path / "worlds" / "empty.world")


def test_world_file_of_gazebo_ros(monkeypatch):
    monkeypatch.delenv("GAZEBO_RESOURCE_PATH", raising=False)
    share = rospkg.RosPack().get_path("gazebo_ros")
    assert find_world("worlds/empty.world") == f"{share}/worlds/empty.world"


def test_world_file_in_the_media_path_of_a_package(tmp_path, monkeypatch):
    package = tmp_path / "park_sim"
    (package / "worlds").mkdir(parents=True)
    (package / "worlds" / "park.world").write_text(WORLD)
    (package / "package.xml").write_text("""<package format="2"><name>park_sim</name>
        <version>0.0.1</version><description>d</description>
        <maintainer email="a@example.org">a</maintainer><license>MIT</license>
        <export><gazebo_ros gazebo_media_path="/nowhere:${prefix}"/></export></package>""")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}:{os.environ['ROS_PACKAGE_PATH']}")
    assert find_world("worlds/park.world") == str(package / "worlds" / "park.world")


def test_missing_world_file_names_all_places(tmp_path, monkeypatch):
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", f"/nowhere:{tmp_path}")
    with pytest.raises(ValueError) as error:
        find_world("worlds/none.world")
    for part in (
        "worlds/none.world",
        os.getcwd(),
        "/nowhere",
        str(tmp_path),
        rospkg.RosPack().get_path("gazebo_ros"),
    ):
        assert part in str(error.value)


def test_load_world_finds_a_relative_file(tmp_path, monkeypatch):
    class Taker:
        """Stands in for World."""

        loaded = None

        def load(self, described):
            """Store it."""
            self.loaded = described
            return []

    (tmp_path / "w.world").write_text(WORLD)
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", str(tmp_path))
    taker = Taker()
    node.load_world(taker, "w.world", Resolver())
    assert taker.loaded.name == "w"
    with pytest.raises(SimError, match="/no/such.world.*No such file"):
        node.load_world(taker, "/no/such.world", Resolver())

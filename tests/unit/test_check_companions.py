"""./run check: launch files of the packages beside the checked one that bring what is missing."""

import pytest
from run_rig import make_package

from commands import check_companions
from commands.bootstrap import workspace

INCLUDE = '<include file="$(find gazebo_ros)/launch/empty_world.launch"/>'
SPAWN = '<node name="s" pkg="gazebo_ros" type="spawn_model" args="-urdf -model m"/>'
SPAWNER = '<node name="c" pkg="controller_manager" type="spawner" args="wheels"/>'
FILES = {
    "field_worlds/launch/field.launch": INCLUDE,
    "field_robot/launch/robot.launch": SPAWN,
    "field_robot/launch/old.launch": f"<!-- {SPAWN} -->",
    "field_robot/launch/all.launch": INCLUDE + SPAWN + SPAWNER,
    "field_control/launch/control.launch": SPAWNER.replace('"', "'"),
}


@pytest.fixture
def sources(tmp_path):
    for name, text in FILES.items():
        path = tmp_path / "field" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"<launch>{text}</launch>")
        make_package(path.parents[1], path.parents[1].name)
    return tmp_path


def found_in(sources, package="field_worlds", path=None, checked=()):
    folder = str(sources / "field" / package)
    return check_companions.find(folder, str(sources) if path is None else path, checked)


def test_files_are_found_by_what_they_bring(sources):
    assert found_in(sources, checked={("field_worlds", "field.launch")}) == {
        "world": [("field_robot", "all.launch")],
        "robot": [("field_robot", "robot.launch")],
        "controllers": [("field_control", "control.launch")],
    }
    assert found_in(sources)["world"][0] == ("field_worlds", "field.launch")  # its own come first


def test_nothing_above_the_package_path_is_searched(sources):
    for path in ("", str(sources / "field" / "field_worlds")):
        assert found_in(sources, path=path)["robot"] == []


def test_packages_of_paddock_bring_nothing():
    folder = f"{workspace.SOURCES}/field_worlds"  # a user's package beside them
    found = check_companions.find(folder, workspace.SOURCES)
    assert found == {"world": [], "robot": [], "controllers": []}


def test_files_that_the_readme_names_come_first(sources):
    """With more than a sentence lists, the one to take is never among `and 1 more`."""
    text = "Start it by `roslaunch field_robot robot_of_the_lab.launch`"
    (sources / "field" / "README.md").write_text(text)
    for name in ("a", "b", "c", "robot_of_the_lab"):
        path = sources / "field" / "field_robot" / "launch" / f"{name}.launch"
        path.write_text(f"<launch>{SPAWN}</launch>")
    files = found_in(sources)["robot"]
    assert files[0] == ("field_robot", "robot_of_the_lab.launch") and len(files) == 5

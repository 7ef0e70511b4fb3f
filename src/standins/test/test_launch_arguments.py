"""empty_world.launch has the arguments of gazebo_ros' (noetic-devel) with its defaults."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

LAUNCH = Path(__file__).resolve().parents[1] / "gazebo_ros" / "launch"
EMPTY_WORLD = {
    "paused": "false",
    "use_sim_time": "true",
    "extra_gazebo_args": "",
    "gui": "true",
    "recording": "false",
    "headless": "false",
    "debug": "false",
    "physics": "ode",
    "verbose": "false",
    "output": "screen",
    "world_name": "worlds/empty.world",
    "respawn_gazebo": "false",
    "use_clock_frequency": "false",
    "pub_clock_frequency": "100",
    "enable_ros_network": "true",
    "server_required": "false",
    "gui_required": "false",
}
OURS = (
    "web real_time_factor lockstep solver renderer shadows antialias labels every_picture "
    "missing_packages massless_links"
).split()


def arguments(name):
    """The arguments of a launch file: name -> default."""
    root = ElementTree.parse(LAUNCH / f"{name}_world.launch").getroot()
    return {each.get("name"): each.get("default") for each in root.findall("arg")}


@pytest.mark.parametrize("name", EMPTY_WORLD)
def test_an_argument_of_empty_world_has_upstreams_default(name):
    assert arguments("empty")[name] == EMPTY_WORLD[name]


def test_empty_world_has_upstreams_arguments_and_ours():
    assert set(arguments("empty")) == {*EMPTY_WORLD, *OURS}


def test_the_arguments_of_the_node():
    root = ElementTree.parse(LAUNCH / "empty_world.launch").getroot()
    node = next(each for each in root.findall("node") if each.get("name") == "gazebo")
    assert (node.get("output"), node.get("respawn")) == ("$(arg output)", "$(arg respawn_gazebo)")
    assert node.get("required") == "$(arg server_required)"
    gui = next(each for each in root.findall("node") if each.get("name") == "gazebo_gui")
    assert gui.get("required") == "$(arg gui_required)"
    assert gui.get("if") == "$(arg gui)"  # headless has no effect, as upstream
    assert (gui.get("pkg"), gui.get("type")) == ("gazebo_ros", "gzclient")
    given = {each.get("name"): each for each in node.findall("param")}
    assert given["paused"].get("value") == "$(arg paused)"
    assert given["world_file"].get("value") == "$(arg world_name)"
    assert given["pub_clock_frequency"].get("if") == "$(arg use_clock_frequency)"

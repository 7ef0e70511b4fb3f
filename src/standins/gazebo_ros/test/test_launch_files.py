"""Launch files of Gazebo's names: which parameters they give the simulator."""

import os

import pytest
import roslaunch

LAUNCH = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "launch")


def parameters(file, *arguments):
    """Parameters that a launch file would set, by name."""
    config = roslaunch.ROSLaunchConfig()
    path = os.path.join(LAUNCH, file)
    roslaunch.XmlLoader().load(path, config, argv=arguments, verbose=False)
    return {name: parameter.value for name, parameter in config.params.items()}


@pytest.mark.parametrize(
    "passed, expected",
    [
        ("true", True),
        ("True", True),
        ("1", True),
        (" true ", True),
        ("yes", True),
        ("false", False),
        ("0", False),
        ("FALSE", False),
    ],
)
def test_use_sim_time_takes_what_people_pass(passed, expected):
    given = parameters("empty_world.launch", f"use_sim_time:={passed}")
    assert given["/use_sim_time"] is expected


def test_the_pace_is_set_only_if_it_is_given():
    given = parameters("empty_world.launch")
    assert "/gazebo/real_time_factor" not in given and given["/use_sim_time"] is True
    assert given["/gazebo/world_file"] == "worlds/empty.world"
    given = parameters("empty_world.launch", "real_time_factor:=0")
    assert given["/gazebo/real_time_factor"] == 0.0


@pytest.mark.parametrize(
    "file, arguments, world",
    [
        ("shapes_world.launch", (), "worlds/shapes.world"),
        ("mud_world.launch", (), "worlds/mud.world"),
        ("rubble_world.launch", (), "worlds/rubble.world"),
        ("willowgarage_world.launch", (), "worlds/willowgarage.world"),
        (
            "elevator_world.launch",
            ("headless:=true", "recording:=true", "physics:=ode", "paused:=true"),
            "worlds/elevator_ros.world",
        ),
        (
            "range_world.launch",
            ("paused:=true", "verbose:=false", "world:=bumper_test"),
            "gazebo_plugins/test/test_worlds/bumper_test.world",
        ),
    ],
)
def test_worlds_by_launch_file(file, arguments, world):
    given = parameters(file, *arguments)
    assert given["/gazebo/world_file"].endswith(world)
    assert given["/gazebo/paused"] is ("paused:=true" in arguments)

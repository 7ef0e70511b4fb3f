"""gzserver's command line -> arguments of the bridge."""

import pytest
from gazebo_ros import gzserver


@pytest.mark.parametrize(
    "line, expected",
    [
        ("", ['_world_file:="worlds/empty.world"', "_paused:=false"]),
        ("-u -e ode /w/my.world", ['_world_file:="/w/my.world"', "_paused:=true"]),
        (
            "--verbose worlds/empty.world --seed 3",
            ['_world_file:="worlds/empty.world"', "_paused:=false", "_seed:=3"],
        ),
    ],
)
def test_parameters(line, expected):
    options, notes = gzserver.parse(line.split())
    assert gzserver.parameters(options) == expected and notes == []


@pytest.mark.parametrize(
    "line, notes",
    [
        ("-s libgazebo_ros_api_plugin.so -s /opt/lib/libgazebo_ros_paths_plugin.so", []),
        ("-s libmine.so", ["server plugin 'libmine.so' cannot be loaded here and is skipped"]),
        (
            "-r --record_path /tmp/x",
            ["--record_path has no effect here", "--record has no effect here"],
        ),
        ("--iters 5", ["--iters has no effect here"]),
        ("--no-such-thing", ["argument '--no-such-thing' is not known and has no effect"]),
        ("--minimal_comms -q", []),
    ],
)
def test_options_without_effect_are_reported(line, notes):
    assert gzserver.parse(line.split())[1] == notes


def test_remappings_go_on_to_the_bridge():
    arguments, notes = gzserver.command(
        ["-u", "a.world", "__name:=gazebo", "__log:=/l", "a:=b"], "gzserver"
    )
    assert arguments[0] == '_world_file:="a.world"' and "_paused:=true" in arguments and notes == []
    assert arguments[-3:] == ["__name:=gazebo", "__log:=/l", "a:=b"]


@pytest.mark.parametrize("line", ["--seed x", "-s", "a.world b.world --seed"])
def test_wrong_command_line_is_exit_2(line):
    with pytest.raises(SystemExit) as error:
        gzserver.parse(line.split())
    assert error.value.code == 2

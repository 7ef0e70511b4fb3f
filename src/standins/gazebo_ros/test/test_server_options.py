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


@pytest.fixture
def started(monkeypatch):
    """Commands that would have been started, and the program that would have been become."""
    commands = []
    monkeypatch.setattr(gzserver.subprocess, "Popen", lambda command, **_: commands.append(command))
    monkeypatch.setattr(
        gzserver.os, "execv", lambda path, arguments: commands.append([path, *arguments[1:]])
    )
    monkeypatch.setattr(
        gzserver.roslib.packages, "find_node", lambda package, name: [f"/{package}/{name}"]
    )
    return commands


def test_gazebo_starts_its_client_and_becomes_the_server(started, monkeypatch):
    monkeypatch.setattr(
        gzserver.sys, "argv", ["gazebo", "-u", "w.world", "__name:=gazebo", "__log:=/l", "a:=b"]
    )
    gzserver.main("gazebo", gui=True)
    client, server = started
    assert client == ["setpriv", "--pdeathsig", "TERM", "/gazebo_ros/gzclient", "a:=b"]
    assert server[0] == "/bullet_bridge/bridge" and "_paused:=true" in server


def test_gzserver_starts_no_client(started, monkeypatch):
    monkeypatch.setattr(gzserver.sys, "argv", ["gzserver"])
    gzserver.main("gzserver")
    assert [command[0] for command in started] == ["/bullet_bridge/bridge"]


@pytest.mark.parametrize(
    "given, name",
    [(["--verbose"], "__name:=gazebo_gui"), (["__name:=my_gui"], "__name:=my_gui")],
)
def test_gzclient_becomes_the_page_in_a_window(started, monkeypatch, given, name):
    monkeypatch.setattr(gzserver.sys, "argv", ["gzclient", *given])
    monkeypatch.setattr(gzserver, "wait_for_simulator", lambda: True)
    gzserver.view()
    ((path, *arguments),) = started
    assert path == "/bullet_web/web" and "_open:=true" in arguments
    assert [word for word in arguments if word.startswith("__name:=")] == [name]

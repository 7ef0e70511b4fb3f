"""What ./run says to arguments: helps, and one sentence for what it cannot use, before set-up."""

import os
import socketserver
import stat
import subprocess
import threading
import xmlrpc.server

import pytest
import run_rig
from run_rig import ROOT, run

from commands.table import COMMANDS

TRACKS = "default, easy, hard, medium"


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["fly"], ["unknown command 'fly'", "setup, demo, lap"]),
        (["setup", "now"], ["unknown argument 'now'", "usage: ./run setup"]),
        (["exec"], ["exec needs a command", "usage: ./run exec"]),
        (["lap", "--driver", "stig"], ["driver is 'stig'", "slider, buttons, line, pursuit"]),
        (["lap", "--track"], ["--track needs a value", "usage: ./run lap"]),
        (["lap", "--track", "nosuch"], ["track is 'nosuch'", TRACKS, "YAML, .npy or .csv"]),
        (["lap", "track:=nosuch"], ["track is 'nosuch'", TRACKS]),
        (["lap", "--track", str(ROOT / "run")], ["track is", ".yaml, .yml, .npy, .csv"]),
        (["lap", "--starts", "0"], ["starts is '0'", "1 or more"]),
        (["lap", "--starts", "two"], ["starts is 'two'"]),
        (["lap", "--trak", "easy"], ["unknown argument '--trak'"]),
        (["lap", "easy"], ["unknown argument 'easy'", "NAME:=VALUE"]),
        (["lap", "out_dir:=/tmp"], ["lap.launch has no argument 'out_dir'", "seed"]),
        (["track:=nosuch"], ["track is 'nosuch'", TRACKS]),
        (["foo:=1"], ["drive.launch has no argument 'foo'", "mode, command_timeout, track"]),
        (["metric:=1"], ["drive.launch has no argument 'metric'"]),
        (["world", "track:=nosuch"], ["track is 'nosuch'", TRACKS]),
        (["world", "foo:=1"], ["world.launch has no argument 'foo'", "real_time_factor"]),
        (["world", "easy"], ["unknown argument 'easy'"]),
        (["teleop", "foo:=1"], ["teleop.launch has no argument 'foo'", "slider_limit"]),
        (["demo", "foo:=1"], ["demo.launch has no argument 'foo'", "drive_time"]),
        (["truck", "foo:=1"], ["truck.launch has no argument 'foo'", "trailer_lidar"]),
        (["truck", "--back", "loop"], ["shape is 'loop'", "line, arc, s, lane-change, park"]),
        (["truck", "--back", "s", "world:=x"], ["back_demo.launch has no argument 'world'"]),
    ],
)
def test_bad_arguments(arguments, words):
    done = run(*arguments)
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.startswith("run: ") and "Traceback" not in done.stderr
    sentence, *advice = done.stderr.splitlines()
    assert all(line.startswith("     ") for line in advice) and len(advice) <= 2
    for word in words:
        assert word in done.stderr


@pytest.mark.parametrize(
    "words, status, said",
    [
        ("add --list | true; exit ${PIPESTATUS[0]}", 141, ""),
        ("lap --help | true; exit ${PIPESTATUS[0]}", 141, ""),
        ("version >&-", 0, ""),
        ("nosuch <&- >&- 2>&-", 2, ""),
        ("nosuch 2>/dev/full", 2, ""),
        ("add --list >/dev/full", 1, "run: output cannot be written: No space left on device\n"),
        ("--help >/dev/full", 1, "run: output cannot be written: No space left on device\n"),
    ],
)
def test_output_that_nobody_takes(words, status, said):
    """A traceback and exit status 120; what was closed gave its number to the next file."""
    script = f'"$0" {words}'
    done = subprocess.run(
        ["bash", "-c", script, str(ROOT / "run")], capture_output=True, text=True, timeout=300
    )
    assert (done.returncode, done.stderr) == (status, said)


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_every_command_has_a_help(command):
    done = run(*command.split(), "--help")
    assert done.returncode == 0 and done.stderr == ""
    assert done.stdout.startswith(f"usage: ./run {command}".strip())
    assert max(map(len, done.stdout.splitlines())) <= 110


def test_help_lists_commands_and_launch_arguments():
    overview = run("help").stdout
    assert overview == run("-h").stdout
    assert all(f"  {name} " in overview and about in overview for name, about in COMMANDS.items())
    world = run("world", "--help").stdout
    assert "renderer:=auto" in world and "auto, gl or tiny" in world
    assert "slider, buttons, line, pursuit or policy" in run("lap", "--help").stdout  # of a comment
    assert "--quick" in run("bench", "--help").stdout  # of bench/bench.py
    assert "--list" in run("test", "--help").stdout


def without_python(tmp_path):
    """A small clone on what ./run takes for a machine without python3."""
    root = run_rig.small_clone(tmp_path / "paddock")
    text = (root / "run").read_text()
    assert "\npython=/usr/bin/python3\n" in text
    (root / "run").write_text(text.replace("=/usr/bin/python3\n", "=/nonexistent/python3\n"))
    return root


@pytest.mark.parametrize("arguments", [["-h"], ["help"], ["lap", "--help"]])
def test_help_without_python_installs_nothing(tmp_path, arguments):
    root = without_python(tmp_path)
    done = run(*arguments, root=root)
    assert done.returncode == 0 and done.stderr == "" and "first run installs" in done.stdout
    assert all(f"  {name} " in done.stdout and about in done.stdout
               for name, about in COMMANDS.items())  # fmt: skip
    assert not (root / ".cache").exists()


@pytest.mark.parametrize("command, status, word", [
    ("fly", 2, "unknown command 'fly'; there are: setup, demo"),
    ("s", 2, "unknown command 's'"),
    ("completion", 1, "needs python3"),
])  # fmt: skip
def test_other_commands_without_python(tmp_path, command, status, word):
    done = run(command, root=without_python(tmp_path))
    assert done.returncode == status and word in done.stderr and done.stdout == ""


def test_a_path_with_a_blank_is_refused(tmp_path):
    root = run_rig.small_clone(tmp_path / "my paddock")
    done = run("setup", root=root)
    assert done.returncode == 1 and "contains a blank" in done.stderr
    assert not (root / ".cache").exists()
    assert run("--help", root=root).returncode == 0


@pytest.mark.parametrize("name", ["a:b", "it's", "a$b"])
def test_a_path_with_a_sign_of_lists_or_shells_is_refused(tmp_path, name):
    """It was told that the network was missing."""
    done = run("setup", root=run_rig.small_clone(tmp_path / name))
    assert done.returncode == 1 and "contains one of : '" in done.stderr


def test_a_clone_that_cannot_be_written_to(tmp_path):
    root = run_rig.small_clone(tmp_path / "paddock")
    (root / ".cache").write_text("")  # root may write anywhere, but not below a file
    (root / ".cache").chmod(stat.S_IRUSR)
    done = run("setup", root=root)
    assert done.returncode == 1 and f"cannot write to {root}/.cache" in done.stderr


class Master(socketserver.ThreadingMixIn, xmlrpc.server.SimpleXMLRPCServer):
    """A ROS master that knows some nodes, and counts who asks."""

    def __init__(self, *nodes):
        super().__init__(("127.0.0.1", 0), logRequests=False)
        self.asked = []
        self.register_function(self._lookup(nodes), "lookupNode")
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def _lookup(self, nodes):
        def lookup(_caller, name):
            self.asked.append(name)
            return [1, "", "http://x:1/"] if name in nodes else [-1, "unknown node", ""]

        return lookup

    def environment(self):
        uri = f"http://127.0.0.1:{self.server_address[1]}"
        return {**os.environ, "ROS_MASTER_URI": uri, "QT_QPA_PLATFORM": "offscreen"}


@pytest.mark.parametrize("arguments", [["world"], ["truck"], ["paused:=true"]])
def test_a_second_world_is_refused(arguments):
    with Master("/gazebo") as master:
        done = run(*arguments, env=master.environment())
        master.shutdown()
    assert done.returncode == 1 and master.asked == ["/gazebo"]
    assert f"a simulator runs already on {master.environment()['ROS_MASTER_URI']}" in done.stderr


def test_another_master_is_no_second_world():
    with Master("/rosout") as master:
        done = run("world", "--nodes", env=master.environment())
        master.shutdown()
    assert done.returncode == 0 and master.asked == ["/gazebo"] and "/gazebo" in done.stdout


def test_a_window_needs_a_display():
    environ = {name: value for name, value in os.environ.items()
               if name not in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")}  # fmt: skip
    for arguments, instead in ((["teleop"], "./run demo"), (["x:=1"], "./run demo x:=1")):
        done = run(*arguments, env=environ)
        assert done.returncode == 1
        assert "needs a display" in done.stderr and instead in done.stderr


def test_no_program_runs_before_python(tmp_path):
    """bash forgets a SIGINT that comes while it waits for one."""
    program = tmp_path / "readlink"
    program.write_text("#!/bin/sh\nexit 1\n")
    program.chmod(0o755)
    environ = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}", "CDPATH": str(tmp_path)}
    for path, folder in ((f"{ROOT}/run", tmp_path), ("./run", ROOT), ("../run", f"{ROOT}/src")):
        done = subprocess.run(
            [path, "exec", "pwd"], cwd=folder, env=environ, capture_output=True, text=True
        )
        assert (done.returncode, done.stdout, done.stderr) == (0, f"{folder}\n", "")


def test_a_link_to_run_runs_its_clone(tmp_path):
    (tmp_path / "paddock").symlink_to(f"{ROOT}/run")
    (tmp_path / "clone").symlink_to(ROOT)
    for path in ("paddock", "clone/run"):
        done = subprocess.run(
            [tmp_path / path, "exec", "printenv", "PADDOCK_ROOT"], capture_output=True, text=True
        )
        assert (done.returncode, done.stdout) == (0, f"{ROOT}\n"), done.stderr

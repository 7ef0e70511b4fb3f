"""What ./run says to arguments: helps, and one sentence for what it cannot use, before set-up."""

import os
import shlex
import socketserver
import stat
import threading
import xmlrpc.server

import pytest
import run_rig
from run_rig import ROOT, Like, program, ran, run

from commands import cli, environment, locks, processes
from commands.table import COMMANDS

TRACKS = "there are default, easy, hard, medium, or the path of a YAML, .npy or .csv file"
BAD = [
    ("fly", "unknown command 'fly'; there are: setup, demo, lap, ..."),
    ("setup now", "unknown argument 'now'"),
    ("exec", "exec needs a command"),
    ("lap --driver stig", "driver is 'stig'; there are slider, buttons, line, pursuit, policy"),
    ("lap --track", "--track needs a value"),
    ("lap --track nosuch", f"track is 'nosuch'; {TRACKS}"),
    ("lap track:=nosuch", f"track is 'nosuch'; {TRACKS}"),
    (f"lap --track {ROOT}/run", "track is '...'; a track file ends in .yaml, .yml, .npy, .csv"),
    ("lap --starts 0", "starts is '0'; it must be a whole number, 1 or more"),
    ("lap --starts two", "starts is 'two'; it must be a whole number, 1 or more"),
    ("lap --trak easy", "unknown argument '--trak'; ..."),
    ("lap easy", "unknown argument 'easy'; launch arguments have the form NAME:=VALUE"),
    ("lap out_dir:=/tmp", "lap.launch has no argument 'out_dir'; there are ...seed..."),
    ("lap --driver policy", "--driver policy and --policy NAME belong together"),
    ("track:=nosuch", f"track is 'nosuch'; {TRACKS}"),
    ("foo:=1", "drive.launch has no argument 'foo'; there are mode, command_timeout, track..."),
    ("metric:=1", "drive.launch has no argument 'metric'; ..."),
    ("world track:=nosuch", f"track is 'nosuch'; {TRACKS}"),
    ("world foo:=1", "world.launch has no argument 'foo'; there are ...real_time_factor..."),
    ("world easy", "unknown argument 'easy'; launch arguments have the form NAME:=VALUE"),
    ("world real_time_factor:=abc", "real_time_factor is 'abc'; it must be a number of at least 0"),
    ("world real_time_factor:=-1", "real_time_factor is '-1'; it must be a number of at least 0"),
    ("world real_time_factor:=nan", "real_time_factor is 'nan'; it must be a number of at least 0"),
    ("world camera_width:=", "camera_width is ''; it must be a number"),
    ("world x:=one", "x is 'one'; it must be a number"),
    ("world lidar_rate:=1_0", "lidar_rate is '1_0'; it must be a number"),
    ("world gui:=yes", "gui is 'yes'; it must be true or false"),
    ("teleop foo:=1", "teleop.launch has no argument 'foo'; there are ...slider_limit..."),
    ("demo foo:=1", "demo.launch has no argument 'foo'; there are ...drive_time..."),
    *((f"DEMO_DEADLINE={text} demo", f"DEMO_DEADLINE is '{text}'; it must be a number of sec...")
      for text in ("soon", "-1", "nan", "s")),
    ("truck foo:=1", "truck.launch has no argument 'foo'; there are ...trailer_lidar..."),
    ("truck --back loop", "shape is 'loop'; there are line, arc, s, lane-change, park"),
    ("truck --back s world:=x", "back_demo.launch has no argument 'world'; ..."),
    ("check car a.launch + car", "behind + there must be PACKAGE FILE.launch"),
    ("check car a.launch + a:=b c.launch", "behind + there must be PACKAGE FILE.launch"),
    ("check car a.launch gui", "unknown argument 'gui'; launch arguments are NAME:=VALUE"),
    ("add navigatoin", "name is 'navigatoin'; valid: ...navigation..."),
    ("add https://example.org/?", "...its last part must name..."),
    ("bare --suite buster", "suite is 'buster'; there are bookworm, trixie"),
    ("bare --suite=sid true", "suite is 'sid'; there are bookworm, trixie"),
    ("bare --suite", "--suite needs a value"),
    ("bare --siute trixie", "unknown argument '--siute'"),
    ("bare -x true", "unknown argument '-x'"),
    ("container --engine lxc", "engine is 'lxc'; it must be podman or docker"),
    ("container --workspace /absent", "workspace is '/absent', which has no folder src"),
    ("container fly", "the container runs a command of ./run, and 'fly' is none"),
    ("container container", "the container runs a command of ./run, and 'container' is none"),
    ("container --fast", "unknown argument '--fast'"),
    ("desk rviz", "the desk shows a command of ./run, and 'rviz' is none"),
    ("desk desk", "the desk shows a command of ./run, and 'desk' is none"),
    ("desk --size big", "size is 'big'; it must be WIDTHxHEIGHT in pixels, such as 1600x900"),
    ("desk --size", "--size needs a value"),
    ("desk --port 70000", "port is '70000'; it must be a whole number from 1 to 65535"),
    ("desk --wide lap", "unknown argument '--wide'"),
    ("desk --share", "--share needs a password, and DESK_PASSWORD is not set"),
    *((f"DESK_PASSWORD='{text}' desk --share", f"...password has {len(text)} characters; VNC ...")
      for text in ("", "short", "far too long", "größer")),
    ("web --port 70000", "port is '70000'; it must be a whole number from 1 to 65535"),
    ("web --port x", "port is 'x'; it must be a whole number from 1 to 65535"),
    ("web track:=nowhere", f"track is 'nowhere'; {TRACKS}"),
    ("web port:=1", "page.launch has no argument 'port'; ..."),
    ("web wide:=1", "page.launch has no argument 'wide'; ..."),
    ("web --share", "--share needs a password, and PADDOCK_WEB_PASSWORD is not set"),
    ("PADDOCK_WEB_PASSWORD=short web --share", "...has 5 characters; it must have 6 or more"),
    ("replay", "the following arguments are required: FILE.bag"),
    ("replay absent.bag", "there is no file 'absent.bag'"),
    (f"replay {ROOT}/run --track x", f"track is 'x'; {TRACKS}"),
    (f"replay {ROOT}/run --out no/where.html", "there is no folder '/.../no'"),
    ("train ../up", "name is '../up'; it must be letters, digits, '_', '-' and '.'"),
    ("train --observation radar", "observation is 'radar'; there are state, lidar, camera"),
    ("train --observation state,state", "...is 'state,state'; it must have each name once"),
    ("train --randomize start,rain", "randomize is 'rain'; there are start, ..."),
    ("train --randomize mass,mass", "randomize is 'mass,mass'; it must have each name once"),
    ("train --randomize nothing,mass", "...is 'nothing,mass'; all and nothing stand alone"),
    ("train --randomize mass,all", "randomize is 'mass,all'; all and nothing stand alone"),
    ("train --steps 0", "steps is '0'; it must be a whole number, 1 or more"),
    ("train --reward absent.py", "there is no file 'absent.py'"),
    ("train --track monza", f"track is 'monza'; {TRACKS}"),
    ("train --track easy,hard", f"track is 'easy,hard'; {TRACKS}"),
    ("train --race drag", "race is 'drag'; there are time_trial, ..."),
    ("train --race head_to_bot,time_trial", "race is 'head_to_bot,time_trial'; there are time..."),
    ("train --ray box", "ray is 'box'; it must be auto, or HOST:PORT of a cluster's head"),
    ("train --ray auto --threads", "ray is 'auto'; with --threads there are no actors of Ray"),
    ("train --env boat", "env is 'boat'; there are deepracer, backing"),
    *((f"train rig --env backing {option}", f"{option.split()[0]} is an option of the DeepR...")
      for option in ("--track easy", "--walls", "--observation lidar")),
    ("evaluate green.onnx", "policy is 'green.onnx'; there are ...; or the path of an .onnx file"),
    *((f"cluster {words}", f"cluster is '{words}'; it must be head, or join HOST:PORT")
      for words in ("tail", "join", "join box", "head box:6379")),
    *((f"test --jobs={text} circle", f"-j N: N is '{text}'; it must be a whole number, 1 or more")
      for text in ("0", "two", "-1", "1.5", "")),
]  # fmt: skip


@pytest.mark.parametrize("line, sentence", BAD)
def test_bad_arguments(line, sentence, monkeypatch, capsys):
    """Without a word of Python's, before anything is set up, written or started."""
    monkeypatch.setattr(environment, "ready", lambda: {"ROS_MASTER_URI": "http://127.0.0.1:1"})
    monkeypatch.setattr(locks, "take", lambda name: True)
    monkeypatch.setattr(processes, "become", lambda *_: pytest.fail("it is started"))
    for variable in ("DESK_PASSWORD", "PADDOCK_WEB_PASSWORD"):
        monkeypatch.delenv(variable, raising=False)
    words = shlex.split(line)
    if "=" in words[0] and ":=" not in words[0]:
        monkeypatch.setenv(*words.pop(0).split("=", 1))
    assert cli.main(words) == 2
    said, wrong = capsys.readouterr()
    first, *advice = wrong.splitlines()
    assert said == "" and first == Like(f"run: {sentence}")
    assert len(advice) <= 2 and all(text.startswith("     ") for text in advice)


@pytest.mark.parametrize("words, said", [
    (["setup", "now"], "run: unknown argument 'now'\n     usage: ./run setup ...\n     ..."),
    (["exec"], "run: exec needs a command\n     usage: ./run exec ..."),
])  # fmt: skip
def test_bad_arguments_show_the_usage(words, said):
    done = run(*words)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", Like(said))


@pytest.mark.parametrize("words, status, said", [
    ("add --list | true; exit ${PIPESTATUS[0]}", 141, ""),
    ("lap --help | true; exit ${PIPESTATUS[0]}", 141, ""),
    ("version >&-", 0, ""),
    ("nosuch <&- >&- 2>&-", 2, ""),
    ("nosuch 2>/dev/full", 2, ""),
    ("add --list >/dev/full", 1, "run: output cannot be written: No space left on device\n"),
    ("--help >/dev/full", 1, "run: output cannot be written: No space left on device\n"),
])  # fmt: skip
def test_output_that_nobody_takes(words, status, said):
    """A traceback and exit status 120; what was closed gave its number to the next file."""
    done = ran("bash", "-c", f'"$0" {words}', ROOT / "run")
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


@pytest.mark.parametrize("name, sentence", [
    ("my paddock", "contains a blank"),
    *((name, "contains one of : '") for name in ("a:b", "it's", "a$b")),
])  # fmt: skip
def test_a_path_that_lists_or_builds_do_not_take_is_refused(tmp_path, name, sentence):
    """It was told that the network was missing."""
    root = run_rig.small_clone(tmp_path / name)
    done = run("setup", root=root)
    assert done.returncode == 1 and sentence in done.stderr and not (root / ".cache").exists()
    assert run("--help", root=root).returncode == 0


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


@pytest.mark.parametrize("line, node", [
    ("world", "/gazebo"), ("truck", "/gazebo"), ("paused:=true", "/gazebo"),
    ("world --nodes", "/rosout"),  # of another master, which has no world
])  # fmt: skip
def test_a_second_world_is_refused(line, node):
    with Master(node) as master:
        done = run(*line.split(), env=master.environment())
        master.shutdown()
    said = f"a simulator runs already on {master.environment()['ROS_MASTER_URI']}" in done.stderr
    assert master.asked == ["/gazebo"] and said == (node == "/gazebo")
    assert done.returncode == said and ("/gazebo" in done.stdout) != said


def test_a_window_needs_a_display():
    environ = {name: value for name, value in os.environ.items()
               if name not in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")}  # fmt: skip
    for arguments, instead in ((["teleop"], "./run demo"), (["x:=1"], "./run demo x:=1")):
        done = run(*arguments, env=environ)
        assert done.returncode == 1
        assert "needs a display" in done.stderr and instead in done.stderr


def test_no_program_runs_before_python(tmp_path):
    """bash forgets a SIGINT that comes while it waits for one."""
    program(tmp_path / "readlink", "#!/bin/sh\nexit 1\n")
    environ = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}", "CDPATH": str(tmp_path)}
    for path, folder in ((f"{ROOT}/run", tmp_path), ("./run", ROOT), ("../run", f"{ROOT}/src")):
        done = ran(path, "exec", "pwd", cwd=folder, env=environ)
        assert (done.returncode, done.stdout, done.stderr) == (0, f"{folder}\n", "")


def test_a_link_to_run_runs_its_clone(tmp_path):
    (tmp_path / "paddock").symlink_to(f"{ROOT}/run")
    (tmp_path / "clone").symlink_to(ROOT)
    for path in ("paddock", "clone/run"):
        done = ran(tmp_path / path, "exec", "printenv", "PADDOCK_ROOT")
        assert (done.returncode, done.stdout) == (0, f"{ROOT}\n"), done.stderr

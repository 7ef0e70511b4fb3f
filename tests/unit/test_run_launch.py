"""How commands start launch files: arguments, tracks, deadlines, results."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from xmlrpc.client import ServerProxy

import pytest
from roslaunch import arg_dump
from run_rig import PATIENCE, ROOT, make_package, program, ran, usual_signals
from testing import ros_master

from commands import cli, environment, launching
from commands.errors import CommandError, UsageError
from commands.launching import LaunchFile
from commands.paths import PROGRAMS
from commands.subcommands import truck, web
from commands.table import COMMANDS, DEFAULT

MODULES = map(cli.subcommand, (DEFAULT, *COMMANDS))
LAUNCHES = [truck.BACK, web.BESIDE, *filter(None, (vars(each).get("LAUNCH") for each in MODULES))]


@pytest.mark.parametrize("launch", LAUNCHES, ids=lambda launch: launch.name)
def test_arguments_are_those_that_roslaunch_knows(launch):
    launch = LaunchFile(launch.package, launch.name)  # without what commands set themselves
    assert set(launch.arguments()) == set(arg_dump.get_args([launch.path]))


def test_the_window_records_into_out_and_gets_a_pad_that_is_there(tmp_path):
    pads = str(tmp_path / "js*")
    folder = f"record_dir:={ROOT}/out/recordings"
    assert launching.window_arguments(["track:=easy"], pads) == [folder]
    (tmp_path / "js0").touch()
    assert launching.window_arguments([], pads) == [folder, "pad:=true"]
    assert launching.window_arguments(["pad:=false", "record_dir:=x", "--screen"], pads) == []


def test_values_that_roslaunch_reads():
    given = ["real_time_factor:=0", "x:=-.25", "y:=1.0e-1", "gui:=True", "paused:=1",
             "shadows:=auto", "camera_rate:=$(env RATE)", "solver:=none"]  # fmt: skip
    assert LaunchFile("track_model", "world.launch").check(given) == given


def test_tracks(tmp_path, monkeypatch):
    assert launching.track_names() == ["default", "easy", "hard", "medium"]
    assert launching.resolve_track("hard") == "hard"
    monkeypatch.chdir(tmp_path)
    for name in ("a.yaml", "b.yml", "c.npy", "d.CSV"):
        (tmp_path / name).write_text("")
        assert launching.resolve_track(name) == str(tmp_path / name)
    (tmp_path / "e.txt").write_text("")
    (tmp_path / "f.yaml").mkdir()
    for name in ("e.txt", "f.yaml", "absent.yaml", ""):
        with pytest.raises(UsageError, match=f"^track is '{name}'; "):
            launching.resolve_track(name)
    launch = LaunchFile("track_model", "world.launch")
    assert launch.check(["track:=a.yaml"]) == [f"track:={tmp_path}/a.yaml"]


# In place of roslaunch: writes down how it was called, then does what PROBE says.
ROSLAUNCH = f"""#!{sys.executable}
import json, os, pathlib, signal, sys, time
out = pathlib.Path(next(a for a in sys.argv if a.startswith("out_dir:=")).partition(":=")[2])
asked = []
signal.signal(signal.SIGINT, lambda *_: asked.append("SIGINT"))
(out / "called.json").write_text(json.dumps([sys.argv[1:], os.environ["ROS_MASTER_URI"],
                                             os.environ["QT_QPA_PLATFORM"]]))
exec(os.environ["PROBE"])
"""


@pytest.fixture
def launched(tmp_path):
    """Calls launching.run with a stand-in for roslaunch; gives the folder of its results."""
    program(tmp_path / "roslaunch", ROSLAUNCH)
    out = tmp_path / "out"

    def call(probe, deadline="0", arguments=("gui:=false",), results=None):
        environ = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}", "PROBE": probe}
        launch = LaunchFile("track_model", "world.launch")
        launching.run("probe", launch, environ, arguments, deadline, str(out), results)
        return out

    return call


def result(text):
    return f"(out / 'result.json').write_text({text!r})"


def test_a_result_that_is_ok(launched, capsys):
    out = launched(result('{"ok": true}'))
    called, master, platform = json.loads((out / "called.json").read_text())
    port = re.sub("^http://127.0.0.1:", "", master)
    assert called == ["-p", port, "track_model", "world.launch", f"out_dir:={out}", "gui:=false"]
    assert int(port) > 1023 and platform == "offscreen"
    assert capsys.readouterr().out.endswith("/: called.json result.json\nprobe: ok\n")


def test_a_folder_of_results_behind_a_link_is_emptied(launched, tmp_path):
    """The result of the lap before had counted: a link was left as it was."""
    (tmp_path / "disk" / "old").mkdir(parents=True)
    (tmp_path / "disk" / "result.json").write_text('{"ok": true}')
    (tmp_path / "out").symlink_to(tmp_path / "disk")
    with pytest.raises(CommandError, match="ended without result.json"):
        launched("pass")
    assert [path.name for path in (tmp_path / "disk").iterdir()] == ["called.json"]


@pytest.mark.parametrize("text, reason", [("{", "is no JSON"), ("[]", "holds no settings"),
                                          ("\x00", "is no JSON")])  # fmt: skip
def test_damaged_settings_of_a_policy_are_named(tmp_path, text, reason):
    (tmp_path / "settings.json").write_text(text)
    with pytest.raises(CommandError, match=f"{tmp_path}/settings.json {reason}"):
        launching.policy_settings(str(tmp_path / "policy.onnx"))
    (tmp_path / "settings.json").unlink()
    assert launching.policy_settings(str(tmp_path / "policy.onnx")) == {}


@pytest.mark.skipif(sys.version_info < (3, 11), reason="Python 3.11 is the first to obey")
def test_a_file_of_the_current_folder_is_no_module_of_python(tmp_path):
    (tmp_path / "random.py").write_text("raise SystemExit('the wrong one')")
    code = (
        f"import os, sys; sys.path.insert(0, {str(ROOT)!r}); from commands import processes; "
        "processes.become_module(sys.executable, ['tempfile', 'words'], dict(os.environ))"
    )
    done = ran(sys.executable, "-P", "-c", code, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize("probe, sentence", [
    (result('{"ok": false}'), "the probe did not succeed"),
    (result('{"ok": 1}'), "the probe did not succeed"),
    (result("[]"), "the probe did not succeed"),
    (result('{"ok": tr'), "the probe ended without result.json"),
    ("pass", "the probe ended without result.json"),
    (result('{"ok": true}') + "; sys.exit(3)", "roslaunch ended with exit status 3"),
])  # fmt: skip
def test_a_result_that_is_not(launched, probe, sentence):
    with pytest.raises(CommandError) as caught:
        launched(probe, results=["path.csv"])
    assert str(caught.value) == sentence
    assert caught.value.advice == ("Its own words are above; logs in .cache/ros-probe/",)


@pytest.mark.parametrize("results", [None, ["old.csv"]])
def test_a_track_that_is_not_valid_is_told_before_anything_goes(launched, tmp_path, results):
    track = tmp_path / "bent.yaml"
    track.write_text("points: [[0, 0], [1, one], [2, 2]]\n")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "old.csv").touch()
    with pytest.raises(CommandError) as caught:
        launched("pass", arguments=["track:=default", f"track:={track}"], results=results)
    assert str(caught.value) == f"{track}: points[1] is 'one'; valid: a number"
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["old.csv"]


def test_a_deadline_ends_it_with_sigint(launched, tmp_path, monkeypatch):
    begun, monotonic = tmp_path / "out" / "called.json", time.monotonic
    monkeypatch.setattr(time, "monotonic", lambda: monotonic() + 1000.0 * begun.exists())
    wait = "\nwhile not asked: time.sleep(0.01)\n(out / 'asked').write_text(asked[0])"
    with pytest.raises(CommandError, match=r"^the probe did not end within 500s s$"):
        launched(wait, deadline="500s")
    assert (tmp_path / "out" / "asked").read_text() == "SIGINT"


@pytest.mark.parametrize("variable, default, text, seconds", [
    (None, 300, "300", 300.0), ("20", 300, "20", 20.0), ("1.5m", 300, "1.5m", 90.0),
    ("0", 300, "0", 0.0), ("", 7, "7", 7.0),
])  # fmt: skip
def test_deadlines(monkeypatch, variable, default, text, seconds):
    monkeypatch.delenv("DEMO_DEADLINE", raising=False)
    if variable is not None:
        monkeypatch.setenv("DEMO_DEADLINE", variable)
    assert launching.deadline_from("DEMO_DEADLINE", default) == text
    assert launching._seconds(text) == seconds


# In place of roslaunch, as it starts: each Ctrl-C is forgotten.
FORGETFUL = f"""#!{sys.executable}
import sys, time
while True:
    try:
        print("here", *sys.argv[1:], flush=True)
        time.sleep(1e4)
    except:
        pass
"""


def test_roslaunch_ends_while_it_starts(tmp_path):
    program(tmp_path / "roslaunch", FORGETFUL)
    command = LaunchFile("track_model", "world.launch").command(["gui:=false"])
    with subprocess.Popen(
        command, env={"PATH": str(tmp_path)}, stdout=subprocess.PIPE, text=True,
        preexec_fn=usual_signals,
    ) as process:  # fmt: skip
        try:
            assert process.stdout.readline() == "here track_model world.launch gui:=false\n"
            process.send_signal(signal.SIGINT)
            assert process.stdout.readline() == ""
            assert process.wait(PATIENCE) == -signal.SIGINT
        finally:
            process.kill()


@pytest.mark.parametrize("status, words, others", [
    (0, "[it-1] process has finished cleanly; shutting down", "REQUIRED"),
    (3, "REQUIRED process [it-1] has died!\nprocess has died [pid ", "cleanly"),
])  # fmt: skip
def test_a_required_node_that_finishes_is_no_error(tmp_path, status, words, others):
    make_package(tmp_path, "ends")
    program(tmp_path / "node", f"#!/bin/sh\nexit {status}\n")
    launch = tmp_path / "it.launch"
    launch.write_text('<launch><node name="it" pkg="ends" type="node" required="true"/></launch>')
    with ros_master() as environment:
        environment["ROS_PACKAGE_PATH"] = f"{tmp_path}:{environment['ROS_PACKAGE_PATH']}"
        done = ran(sys.executable, launching.ROSLAUNCH, launch, env=environment, timeout=90)
    said = done.stdout + done.stderr
    assert words in said and others not in said


@pytest.mark.parametrize("inside, said", [
    ('<node name="a" pkg="{0}" type="b"/><node name="c" pkg="made_up" type="d"/>', "cannot launch"),
    ('<include file="$(find {0})/launch/ekf_template.launch"/>', "Resource not found"),
])  # fmt: skip
def test_of_a_package_that_is_missing_roslaunch_names_what_brings_it(tmp_path, inside, said):
    launch = tmp_path / "it.launch"
    launch.write_text(f"<launch>{inside.format('robot_localization')}</launch>")
    with ros_master() as environment:
        environment["ROS_PACKAGE_PATH"] = str(tmp_path)  # whatever is in src/
        environment["CMAKE_PREFIX_PATH"] = "/usr"
        environment["PATH"] = f"{PROGRAMS}:{environment['PATH']}"
        done = ran("roslaunch", launch, env=environment, timeout=90)
    assert said in done.stderr
    line = "robot_localization is not installed; ./run add robot_localization brings it"
    assert [line] == re.findall(r"robot_\w+ is not installed.*brings it", done.stderr)


def test_shells_of_paddock_have_that_roslaunch():
    path = environment.activated(dict(os.environ))["PATH"]
    assert shutil.which("roslaunch", path=path) == f"{PROGRAMS}/roslaunch"


# Runs a child that waits for SIGINT, and tells the exit status that ./run would have.
WAITING = """
import sys
sys.path.insert(0, sys.argv[1])
from commands import errors, processes
child = "import signal, time; print('here', flush=True); time.sleep(1e4)"
try:
    processes.run_child([sys.executable, "-c", child], group=False)
except errors.Interrupted as signal:
    sys.exit(signal.status)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_reach_the_child(number):
    with subprocess.Popen(
        [sys.executable, "-c", WAITING, str(ROOT)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, preexec_fn=usual_signals,
    ) as process:  # fmt: skip
        assert process.stdout.readline() == "here\n"
        process.send_signal(number)
        _, said = process.communicate(timeout=PATIENCE)  # ends with the child, which has the pipe
    assert process.returncode == 128 + number
    assert "KeyboardInterrupt" in said  # the child's


def test_a_page_whose_node_is_gone_does_not_run():
    """The master still knows a node that was killed."""
    with ros_master() as environ, socket.socket() as node:
        assert not launching.page_runs(environ)
        node.bind(("127.0.0.1", 0))
        node.listen()
        address = f"http://127.0.0.1:{node.getsockname()[1]}/"
        with ServerProxy(environ["ROS_MASTER_URI"]) as master:
            master.registerService("/web", "/web/s", "rosrpc://127.0.0.1:1", address)
        assert launching.page_runs(environ)
        node.close()
        assert not launching.page_runs(environ)
        assert not launching.page_runs({"ROS_MASTER_URI": address})

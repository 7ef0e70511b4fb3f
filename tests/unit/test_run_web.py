"""./run web and ./run replay: their arguments, what they start, the password."""

import os

import pytest

from commands import cli, environment, launching, locks, processes
from commands.errors import UsageError
from commands.subcommands import web


@pytest.fixture
def started(monkeypatch):
    """Command lines that would have been started."""
    found = []
    monkeypatch.setattr(environment, "ready", lambda: {"ROS_MASTER_URI": "http://127.0.0.1:1"})
    for module, name in ((launching, "become"), (processes, "become_module")):
        monkeypatch.setattr(module, name, lambda *words: found.append(words))
    monkeypatch.setattr(locks, "take", lambda name: True)
    return found


def test_without_a_simulator_a_world_is_started(started, monkeypatch):
    cli.dispatch(["web", "--port", "7777", "track:=hard"])
    ((launch, words, _),) = started
    assert (launch.package, launch.name) == ("deepracer_teleop", "page.launch")
    assert words == ["track:=hard", "port:=7777", "share:=false"]


def test_beside_a_simulator_only_the_page_is_started(started, monkeypatch, capsys):
    monkeypatch.setattr(launching, "simulator_runs", lambda environ: True)
    cli.dispatch(["web"])
    ((launch, words, _),) = started
    assert (launch.package, launch.name) == ("bullet_web", "web.launch")
    assert words == ["port:=0", "share:=false"]
    with pytest.raises(UsageError, match="web.launch has no argument 'track'"):
        cli.dispatch(["web", "track:=hard"])


def test_a_shared_page_has_a_password(started, monkeypatch):
    monkeypatch.setenv(web.PASSWORD, "parking lot")
    cli.dispatch(["web", "--share"])
    ((_, words, environ),) = started
    assert words[-1] == "share:=true" and environ[web.PASSWORD] == "parking lot"
    assert not any("parking" in word for word in words) and web.PASSWORD not in os.environ


def test_a_replay_gets_whole_paths(started, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("drive.bag", "rover.urdf"):
        (tmp_path / name).write_text("")
    cli.dispatch(["replay", "drive.bag", "--urdf", "rover.urdf", "--track", "easy"])
    ((_, words, _),) = started
    assert words == [
        *("bullet_web.bag", str(tmp_path / "drive.bag"), "--track", "easy"),
        *("--urdf", str(tmp_path / "rover.urdf"), "--out", str(tmp_path / "drive.html")),
    ]

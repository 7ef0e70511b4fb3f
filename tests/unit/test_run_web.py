"""./run web and ./run replay: their arguments, what they start, the password."""

import io
import os

import pytest

from commands import environment, launching, locks, parsing, processes
from commands.errors import UsageError
from commands.subcommands import replay, web


@pytest.fixture
def started(monkeypatch):
    """Command lines that would have been started."""
    found = []
    monkeypatch.setattr(environment, "ready", lambda: {"ROS_MASTER_URI": "http://127.0.0.1:1"})
    monkeypatch.setattr(
        launching, "become", lambda launch, words, environ: found.append((launch, words, environ))
    )
    monkeypatch.setattr(processes, "become", lambda words, environ: found.append((words, environ)))
    monkeypatch.setattr(
        processes, "become_module", lambda _, words, environ: found.append((words, environ))
    )
    monkeypatch.setattr(locks, "take", lambda name: True)
    return found


def run(module, name, *words):
    options, rest = parsing.parser_of(name, module).parse_known_args(list(words))
    module.run(options, rest)


def test_without_a_simulator_a_world_is_started(started, monkeypatch):
    run(web, "web", "--port", "7777", "track:=hard")
    ((launch, words, _),) = started
    assert (launch.package, launch.name) == ("deepracer_teleop", "page.launch")
    assert words == ["track:=hard", "port:=7777", "share:=false"]


def test_beside_a_simulator_only_the_page_is_started(started, monkeypatch, capsys):
    monkeypatch.setattr(launching, "simulator_runs", lambda environ: True)
    run(web, "web")
    ((launch, words, _),) = started
    assert (launch.package, launch.name) == ("bullet_web", "web.launch")
    assert words == ["port:=0", "share:=false"]
    with pytest.raises(UsageError, match="web.launch has no argument 'track'"):
        run(web, "web", "track:=hard")


@pytest.mark.parametrize(
    "words, reason",
    [
        (["--port", "70000"], "port is '70000'; it must be a whole number from 1 to 65535"),
        (["--port", "x"], "port is 'x'"),
        (["track:=nowhere"], "track is 'nowhere'"),
        (["port:=1"], "page.launch has no argument 'port'"),
        (["wide:=1"], "page.launch has no argument 'wide'"),
    ],
)
def test_wrong_arguments_of_web(started, words, reason):
    with pytest.raises(UsageError) as error:
        run(web, "web", *words)
    assert reason in str(error.value)
    assert started == []


def test_a_shared_page_has_a_password(started, monkeypatch):
    monkeypatch.setenv(web.PASSWORD, "parking lot")
    run(web, "web", "--share")
    ((_, words, environ),) = started
    assert words[-1] == "share:=true" and environ[web.PASSWORD] == "parking lot"
    assert not any("parking" in word for word in words)
    monkeypatch.setenv(web.PASSWORD, "short")
    with pytest.raises(UsageError, match="has 5 characters; it must have 6 or more"):
        run(web, "web", "--share")
    monkeypatch.delenv(web.PASSWORD, raising=False)
    monkeypatch.setattr("sys.stdin", io.StringIO())
    with pytest.raises(UsageError, match=f"--share needs a password, and {web.PASSWORD} is not"):
        run(web, "web", "--share")


def test_a_replay_gets_whole_paths(started, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("drive.bag", "rover.urdf"):
        (tmp_path / name).write_text("")
    run(replay, "replay", "drive.bag", "--urdf", "rover.urdf", "--track", "easy")
    ((words, _),) = started
    assert words == [
        *("bullet_web.bag", str(tmp_path / "drive.bag"), "--track", "easy"),
        *("--urdf", str(tmp_path / "rover.urdf"), "--out", str(tmp_path / "drive.html")),
    ]


@pytest.mark.parametrize(
    "words, reason",
    [
        ([], "arguments are required: FILE.bag"),
        (["absent.bag"], "there is no file 'absent.bag'"),
        (["drive.bag", "--track", "x"], "track is 'x'"),
        (["drive.bag", "--out", "no/where.html"], "there is no folder"),
    ],
)
def test_wrong_arguments_of_replay(started, tmp_path, monkeypatch, words, reason):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drive.bag").write_text("")
    with pytest.raises(UsageError) as error:
        run(replay, "replay", *words)
    assert reason in str(error.value)
    assert os.listdir(tmp_path) == ["drive.bag"] and started == []

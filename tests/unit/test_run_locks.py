"""Two ./run at once: one fills a folder of results, one brings a simulator to a master."""

import json
import os
import signal
import socket
import subprocess
import sys
from contextlib import nullcontext, suppress

import pytest
from run_rig import PATIENCE, ROOT

from commands import cli, environment, launching, locks, processes
from commands.bootstrap import venv
from commands.errors import CommandError, UsageError
from commands.subcommands import docs

HOLDER = """
import os, sys
sys.path.insert(0, sys.argv[1])
from commands import locks
assert locks.take(sys.argv[2]) and not locks.take(sys.argv[2])
os.execvp("bash", ["bash", "-c", "echo here; read"])
"""


def test_a_name_is_free_again_when_its_holder_has_ended(tmp_path):
    name = str(tmp_path)
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(ROOT), name], stdin=subprocess.PIPE,
        stdout=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stdout.readline() == "here\n"  # of the program that it has become
        assert not locks.take(name)
        process.send_signal(signal.SIGKILL)
        process.wait(PATIENCE)
    assert locks.take(name)


@pytest.fixture
def second(monkeypatch, tmp_path):
    """Another ./run has every name; returns what was started beside it."""
    found = []
    monkeypatch.setattr(environment, "ready", lambda: {"ROS_MASTER_URI": "http://127.0.0.1:1"})
    monkeypatch.setattr(venv, "prepare_extras", lambda *_: None)
    monkeypatch.setattr(locks, "take", lambda name: False)
    for name in ("become", "become_module"):
        monkeypatch.setattr(processes, name, lambda *words: found.append(words))
    monkeypatch.setattr(launching, "start", lambda *words: found.append(words))
    monkeypatch.setattr(launching, "need_display", lambda instead: None)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.yaml").write_text("of: pursuit\n")
    (tmp_path / "a.onnx").touch()
    return found


WRITING = "another ./run is writing to out"
STARTING = "a simulator is being started on http://127.0.0.1:1"


@pytest.mark.parametrize("line, reason", [
    ("lap", f"{WRITING}/lap"),
    ("demo", WRITING),
    ("truck --back arc", f"{WRITING}/back_arc"),
    ("train mine", f"{WRITING}/train/mine"),
    ("evaluate a.onnx", f"{WRITING}/evaluate/a"),
    ("sweep a.yaml", f"{WRITING}/sweep/a"),
    ("bench", f"{WRITING}/bench"),
    ("web", STARTING),
    ("world", STARTING),
    ("truck", STARTING),
    ("track:=easy", STARTING),
])  # fmt: skip
def test_the_second_of_two_at_once_is_refused(second, line, reason):
    """They had filled one folder, or ended each other's simulator without a word."""
    with pytest.raises(CommandError) as error:
        cli.dispatch(line.split())
    assert str(error.value) == reason and error.value.advice and second == []


@pytest.mark.parametrize("name", ["../../x", "/etc/x", "", 7.5, None])
def test_the_settings_of_a_policy_name_no_other_folder(second, monkeypatch, tmp_path, name):
    (tmp_path / "settings.json").write_text(json.dumps({"name": name}))
    taken = []
    monkeypatch.setattr(locks, "take_results", taken.append)
    try:
        cli.dispatch(["evaluate", "a.onnx"])
    except UsageError as error:
        assert f"name is {str(name)!r}" in str(error)
    else:
        assert taken[0] in (f"{ROOT}/out/evaluate/a", f"{ROOT}/out/evaluate/7.5")


def test_a_port_of_the_site_that_is_taken():
    """The server ended by a traceback, after the site had been built."""
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(CommandError, match=f"cannot listen on port {port}: Address already"):
            cli.dispatch(["docs", "--port", str(port)])


def test_a_user_is_shown_the_site_of_the_clone_s_owner(monkeypatch, tmp_path):
    """Thirty students had built thirty, and the second found the port taken."""
    (tmp_path / "index.html").write_text("")
    became, port = [], docs.PORTS[0]
    monkeypatch.setattr(docs, "OWN", False)
    monkeypatch.setattr(docs, "OWNERS", str(tmp_path))
    monkeypatch.setattr(docs, "prepare", lambda: pytest.fail("it builds"))
    monkeypatch.setattr(docs.processes, "become_module", lambda *words: became.append(words))
    with socket.socket() as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        with suppress(OSError):  # another program's
            other.bind(("127.0.0.1", port))
            other.listen()
        cli.dispatch(["docs"])
    [(_, words, _)] = became
    assert str(tmp_path) in words and int(words[-1]) in docs.PORTS[1:]


@pytest.mark.parametrize("comes, started", [(True, 0), (False, 1)])
def test_a_page_that_another_run_starts_is_not_ended(second, monkeypatch, comes, started):
    """A second node /web had ended the first; after rosnode kill /web a new one is started."""
    looks = iter([False, False, comes, comes])
    monkeypatch.setattr(launching, "simulator_runs", lambda environ: True)
    monkeypatch.setattr(launching, "page_runs", lambda environ: next(looks, comes))
    monkeypatch.setattr(launching, "PAGE_START", 0.5)
    monkeypatch.setattr(launching, "become", lambda *words: second.append(words))
    with pytest.raises(CommandError, match="has a page already") if comes else nullcontext():
        cli.dispatch(["web"])
    assert len(second) == started


@pytest.mark.parametrize("uri, name", [
    ("http://localhost:11311", "world localhost:11311"),
    ("http://127.0.0.1:11311/", "world localhost:11311"),
    ("http://robot:1", "world robot:1"),
    ("nonsense", "world :"),
])  # fmt: skip
def test_names_of_masters(uri, name):
    assert launching._on_master("world", {"ROS_MASTER_URI": uri}) == name


def test_a_folder_by_another_path_is_the_same(tmp_path, monkeypatch):
    names = []
    monkeypatch.setattr(locks, "take", lambda name: names.append(name) or True)
    os.symlink(tmp_path, tmp_path / "link")
    for path in (tmp_path, tmp_path / "link", f"{tmp_path}/x/.."):
        locks.take_results(str(path))
    assert len(set(names)) == 1

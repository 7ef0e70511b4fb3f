"""./run bare: what it refuses, what the command in the machine sees, what comes back from there."""

import os
import pathlib
import shutil
import tempfile

import pytest
import run_rig
from bare_rig import NO_MOUNTS, NO_ROOT, Bare, where_it_works
from run_rig import ran

NOBODY = 65534
AS_NOBODY = ("setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups")
NO_RIGHT = ("setpriv", "--bounding-set=-sys_admin", "--inh-caps=-sys_admin")


@pytest.fixture
def bare(tmp_path):
    """A clone and its tiny Debian 12."""
    return Bare(tmp_path).tarball()


@pytest.mark.parametrize("arguments", [["--check"], ["true"]])
def test_without_root_it_is_refused(arguments):
    folder = tempfile.mkdtemp(prefix="bare-")  # not below tmp_path, which is root's alone
    try:
        os.chmod(folder, 0o755)
        root = run_rig.small_clone(pathlib.Path(folder) / "paddock")
        ran("chmod", "-R", "a+rwX", root)
        user = os.geteuid() or NOBODY
        done = ran(*(AS_NOBODY if os.geteuid() == 0 else ()), root / "run", "bare", *arguments)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == (
            f"run: a bare machine {NO_ROOT}, and this is user {user}; sudo ./run bare would do\n"
        )
    finally:
        shutil.rmtree(folder)


def test_without_the_right_to_mount_it_is_refused(bare):
    """As root in a container; whoever is no root gets the sentence of the test before."""
    words = [*(NO_RIGHT if os.geteuid() == 0 else ()), bare.root / "run", "bare", "true"]
    done = ran(*words, env=bare.environment())
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("run: a bare machine ") and done.stderr.count("\n") == 1
    assert (NO_MOUNTS if os.geteuid() == 0 else NO_ROOT) in done.stderr and bare.left() == []


@where_it_works
def test_the_command_sees_a_machine_of_its_own(bare):
    line = "echo $$ $PWD; compgen -e; echo [$CI] $HOME; ls / /dev; cat /etc/apt/sources.list"
    done = bare.run(line, CI="true", SECRET="x", PIP_TIMEOUT="9", PIP_CACHE_DIR="/x", LANG="C",
                    TERM="dumb", http_proxy="", ROS_IP="1.2.3.4")  # fmt: skip
    assert done.returncode == 0, done.stderr
    _suite, command, first, *lines = done.stdout[done.stdout.index("bare: Debian") :].splitlines()
    assert command == f"bare: {line}"
    number, folder = first.split()
    assert folder == "/project" and int(number) < 100
    names = set(lines[: lines.index("[true] /root")])
    assert {"HOME", "PATH", "LANG", "CI", "TERM", "PIP_TIMEOUT", "http_proxy"} <= names
    shells = {"PWD", "OLDPWD", "SHLVL", "_"}
    own = {name for name in names - shells if not name.lower().endswith("_proxy")}
    assert {name for name in own if not name.startswith("PIP_")} == {
        "HOME", "PATH", "LANG", "CI", "TERM"}  # fmt: skip
    assert "PIP_CACHE_DIR" not in names
    assert {"project", "proc", "null", "shm", "pts"} <= set(lines) and "sda" not in lines
    assert lines[-1].endswith(" bookworm main") and bare.left() == []


@where_it_works
@pytest.mark.parametrize("words, status", [
    (["exit 7"], 7), (["kill -9 $$"], 137), (["bash", "-c", "exit $1", "bash", "5"], 5),
    (["no-such-program", "x"], 127), (["--", "true"], 0),
])  # fmt: skip
def test_the_exit_status_is_passed_on(bare, words, status):
    done = bare.run(*words)
    assert done.returncode == status and bare.left() == []
    assert ("no-such-program: not found" in done.stderr) == (status == 127)


RESULTS = 'mkdir -p test-results/unit out; echo "$0" >test-results/unit/a.xml; echo "$0" >out/b'


def leave(bare, text):
    """Lets a command leave results that hold a text, and fail."""
    done = bare.run("bash", "-c", f"{RESULTS}; exit 3", text)
    assert done.returncode == 3, done.stderr
    return done.stdout


@where_it_works
def test_results_come_back(bare):
    results, out = bare.root / "test-results", bare.root / "out" / "bare"
    for text in ("first", "second"):  # the second takes the place of the first
        assert "results go to test-results/ and out/bare/" in leave(bare, text)
        assert (results / "unit" / "a.xml").read_text() == (out / "b").read_text() == f"{text}\n"
    (results / "b.xml").write_text("x")  # as ./run test does here
    os.utime(results / "b.xml", (2e9, 2e9))
    assert "results go to test-results/bare/ and out/bare/" in leave(bare, "third")
    assert (results / "unit" / "a.xml").read_text() == "second\n"
    assert (results / "bare" / "unit" / "a.xml").read_text() == "third\n"
    assert bare.run("true").returncode == 0  # which leaves nothing
    assert (results / "bare" / "unit" / "a.xml").exists() and bare.left() == []

"""A clone that belongs to another user: its commands work, and write into the user's folders."""

import os

import mounted_root
import pytest
from run_rig import ROOT, ran, run

OWN = ("XDG_CACHE_HOME", "XDG_STATE_HOME", "XDG_DATA_HOME", "ROS_HOME", "ROS_LOG_DIR")


def read_only(folder):
    """Words before a command in a folder: the clone as for a user who may only read it."""
    clone = str(ROOT)  # also where root runs the tests
    bind = ["bwrap", "--dev-bind", "/", "/", "--ro-bind", clone, clone]
    return [*mounted_root.words(folder), *bind]


def reader(home, *words, **extra):
    """Runs a command of ./run as a user with a home; returns subprocess.CompletedProcess."""
    environ = {name: value for name, value in os.environ.items() if name not in OWN}
    return ran(*read_only(home), ROOT / "run", *words, cwd=home,
               env={**environ, "HOME": str(home), **extra})  # fmt: skip


def test_its_logs_are_in_the_users_folder(tmp_path):
    done = reader(tmp_path, "exec", "printenv", "ROS_LOG_DIR", "PADDOCK_ROOT", "HOME")
    logs = f"{tmp_path}/.local/state/paddock/ros"
    assert (done.returncode, done.stdout.split()) == (0, [logs, str(ROOT), str(tmp_path)])
    elsewhere = reader(tmp_path, "exec", "printenv", "ROS_LOG_DIR", XDG_STATE_HOME=f"{tmp_path}/x")
    assert elsewhere.stdout == f"{tmp_path}/x/paddock/ros\n"
    assert reader(tmp_path, "exec", "rosversion", "roscpp").returncode == 0


@pytest.mark.parametrize(
    "words", [["setup"], ["add", "husky_gazebo"], ["test"], ["soak"], ["bench"]]
)
def test_what_changes_it_is_refused(tmp_path, words):
    done = reader(tmp_path, *words)
    assert done.returncode == 1 and f"{ROOT} belongs to another user" in done.stderr


def test_what_its_owner_has_not_installed_is_named(tmp_path):
    code = """if True:
        from commands.bootstrap import packages, venv
        from commands.errors import CommandError
        venv._has_extra, packages.prepare_more = lambda name: name == 'gym', lambda *_, **__: None
        try:
            venv.prepare_extras('gym', 'test')
        except CommandError as error:
            print(error)"""
    environ = {"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT), "HOME": str(tmp_path)}
    done = ran(*read_only(tmp_path), "/usr/bin/python3", "-c", code, cwd=tmp_path, env=environ)
    assert done.stdout.endswith("who has to type there: ./run setup --with test\n"), done.stderr


def test_version_tells_the_commit(tmp_path):
    assert reader(tmp_path, "version").stdout == run("version").stdout


def test_its_results_are_the_users(tmp_path):
    """Whether the drive is a good one, which a busy machine decides, is not asked."""
    done = reader(tmp_path, "demo", "drive_time:=1", "real_time_factor:=0")
    out = tmp_path / ".local" / "share" / "paddock" / "out"
    assert f"in {out}/: " in done.stdout and (out / "result.json").is_file(), done.stderr
    assert not (tmp_path / ".cache" / "paddock" / "out").exists()

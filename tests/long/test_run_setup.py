"""Set-up in a small clone: interrupted and gone on, moved, two at once, what makes it build; the
environment of commands there."""

import fcntl
import os
import pathlib
import shutil
import subprocess
import time

import run_rig
from run_rig import PATIENCE, run, start

# Prints what a build of a clone depends on.
KEY = """
import sys
sys.path.insert(0, sys.argv[1])
from commands.bootstrap import workspace
directories, contents, names = workspace.scan()
print(workspace.build_key(contents, names))
"""


def test_interrupted(interrupted):
    assert any(" pip install " in line for line in interrupted.working)
    assert interrupted.status == 130
    announced = "[2/4] Python packages ... (details in .cache/log/install_python.log)\n"
    assert announced in interrupted.said
    assert interrupted.said.endswith("\ninterrupted; start ./run again to go on\n")
    assert interrupted.left == [] and not interrupted.stamped


def test_gone_on(completed, clone):
    assert completed.returncode == 0 and completed.stderr == ""
    assert "[2/4] Python packages done (" in completed.stdout
    assert "[3/4] Workspace done (" in completed.stdout
    assert completed.stdout.endswith(f"ready: {clone}\n")
    again = run("setup", root=clone)
    assert (again.returncode, again.stdout) == (0, f"ready: {clone}\n")


def test_a_moved_clone_is_set_up_anew(tmp_path, clone, package_index):
    moved = tmp_path / "moved"
    shutil.copytree(clone, moved, symlinks=True)
    done = run("exec", "rospack", "find", "probe", root=moved, env=package_index.environment())
    assert done.returncode == 0, done.stdout + done.stderr
    assert "[2/4] Python packages done (" in done.stdout
    assert "[3/4] Workspace done (" in done.stdout
    assert done.stdout.endswith(f"\n{moved}/src/probe\n")
    python = moved / ".venv" / "bin" / "python"
    where = subprocess.run([python, "-c", "import paddock_probe; print(paddock_probe.__file__)"],
                           capture_output=True, text=True, check=True).stdout  # fmt: skip
    assert where.startswith(str(moved))


def test_a_package_that_is_gone_is_not_found_any_more(tmp_path, clone, package_index):
    other = clone / "src" / "other"
    shutil.copytree(clone / "src" / "probe", other)
    for name in ("package.xml", "CMakeLists.txt"):
        text = (other / name).read_text()
        text = text.replace("<name>probe", "<name>other").replace("(probe)", "(other)")
        (other / name).write_text(text)
    try:
        done = run("setup", root=clone, env=package_index.environment())
        assert "[3/4] Workspace done (" in done.stdout and "[2/4]" not in done.stdout
        assert (clone / "devel" / "share" / "other").is_dir()
    finally:
        shutil.rmtree(other)
    done = run("setup", root=clone, env=package_index.environment())
    assert "[3/4] Workspace done (" in done.stdout
    assert not (clone / "devel" / "share" / "other").exists()


def test_two_at_once_wait_for_each_other(clone):
    with open(clone / ".cache" / "lock", "w") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        process = start("exec", "echo", "after", root=clone, stderr=subprocess.PIPE)
        said = process.stderr.readline()
        assert said.startswith("another ./run is setting up, waiting for it"), said
        assert process.poll() is None
    said, _ = process.communicate(timeout=PATIENCE)
    assert (process.returncode, said) == (0, "after\n")


def test_the_lock_is_not_handed_to_commands(clone):
    process = start("exec", "cat", root=clone, stdin=subprocess.PIPE)
    try:
        end = time.monotonic() + PATIENCE
        while pathlib.Path(f"/proc/{process.pid}/comm").read_text() != "cat\n":
            assert time.monotonic() < end
        assert run("exec", "true", root=clone, timeout=PATIENCE).returncode == 0
        folder = pathlib.Path(f"/proc/{process.pid}/fd")
        assert str(clone / ".cache" / "lock") not in [
            os.readlink(path) for path in folder.iterdir()
        ]
    finally:
        process.communicate(timeout=PATIENCE)


def key(root):
    done = subprocess.run(["/usr/bin/python3", "-I", "-S", "-c", KEY, str(root)], check=True,
                          capture_output=True, text=True, timeout=PATIENCE)  # fmt: skip
    return done.stdout


def test_what_makes_it_build(tmp_path):
    root = run_rig.small_clone(tmp_path / "paddock")
    package = root / "src" / "probe"
    keys = [key(root)]

    def changes(path, text):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        keys.append(key(root))
        return keys[-1] != keys[-2]

    assert not changes(package / "CMakeLists.txt", (package / "CMakeLists.txt").read_text())
    assert changes(package / "CMakeLists.txt", "project(probe)\n")
    assert changes(package / "msg" / "Probe.msg", "int32 a\n")
    assert changes(package / "msg" / "Probe.msg", "int32 b\n")
    assert changes(package / "nodes" / "second", "")
    assert not changes(package / "nodes" / "second", "#!/bin/sh\n")
    assert not changes(package / "nodes" / "__pycache__" / "second.pyc", "x")
    assert changes(package / "src" / "probe" / "__init__.py", "")
    assert not changes(package / "src" / "probe" / "__init__.py", "a = 1\n")
    assert not changes(package / "src" / "probe" / "module.py", "a = 1\n")
    assert changes(package / "scripts" / "deep" / "script", "")

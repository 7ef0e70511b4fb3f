"""source setup.bash: the environment of ./run exec in bash and zsh, from anywhere."""

import os
import shutil

import pytest
from run_rig import NOISE, ROOT, make_package, program, ran, run

SHELLS = {"bash": ["bash", "--norc", "-c"], "zsh": ["zsh", "-f", "-c"]}
PLAIN = {"PATH": "/opt/it's mine:/usr/bin:/bin", "HOME": "/tmp", "PYTHONHOME": ""}


def sourced(shell, environ, folder, then):
    """Sources setup.bash in a shell and runs something in it."""
    script = f"source '{ROOT}/setup.bash' && {then}"
    return ran(*SHELLS[shell], script, env=environ, cwd=folder)


@pytest.mark.parametrize("shell", SHELLS)
def test_the_environment_is_that_of_exec(shell, tmp_path):
    done = sourced(shell, PLAIN, tmp_path, "exec /usr/bin/env -0")
    assert (done.returncode, done.stderr) == (0, "")
    found = dict(entry.split("=", 1) for entry in done.stdout.split("\0")[:-1])
    expected = run("exec", "/usr/bin/env", "-0", env=PLAIN).stdout.split("\0")[:-1]
    expected = dict(entry.split("=", 1) for entry in expected)
    plain = ran(*SHELLS[shell], "env", env=PLAIN)
    shells_own = {line.split("=", 1)[0] for line in plain.stdout.splitlines()}
    for name in {*found, *expected} - {*NOISE, "ROS_LOCATIONS"}:
        if name in expected or name not in shells_own:
            assert found.get(name) == expected.get(name), name
    assert "PYTHONHOME" not in found


@pytest.mark.parametrize("shell", SHELLS)
def test_twice_is_once_and_roscd_is_there(shell, tmp_path):
    once = sourced(shell, PLAIN, tmp_path, "echo $PATH $ROS_PACKAGE_PATH")
    twice = f"before=$PATH && source '{ROOT}/setup.bash' && roscd track_model && pwd -P"
    again = sourced(shell, PLAIN, tmp_path, twice)
    assert once.returncode == 0 and once.stdout.count(".venv/bin") == 1
    assert again.stdout.split() == [f"{ROOT}/src/track_model"], again.stderr


def test_a_workspace_elsewhere_is_chained(tmp_path):
    package = make_package(tmp_path / "src" / "my_car", "my_car", "ackermann_msgs")
    (package / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.10)\nproject(my_car)\n"
        "find_package(catkin REQUIRED COMPONENTS ackermann_msgs)\ncatkin_package()\n"
    )
    then = "catkin_make >/dev/null && source devel/setup.bash && echo $CMAKE_PREFIX_PATH"
    environ = {**PLAIN, "PATH": os.environ["PATH"]}
    done = sourced("bash", environ, tmp_path, f"{then} && rospack find my_car")
    assert done.returncode == 0, done.stdout + done.stderr
    first, *found = done.stdout.split()
    assert first.startswith(f"{tmp_path}/devel:{ROOT}/devel")
    assert found[0] == str(package)


@pytest.mark.skipif(os.getuid() != 0, reason="only root becomes somebody else")
def test_somebody_who_cannot_write_into_the_clone_sources_it(tmp_path):
    run("exec", "true")  # what is set up already
    (tmp_path / "home").mkdir()
    shutil.chown(tmp_path / "home", "nobody")
    for folder in (*tmp_path.parents[:3], tmp_path):
        os.chmod(folder, 0o755)
    becomes = ["setpriv", "--reuid=nobody", "--regid=nogroup", "--clear-groups"]
    if ran(*becomes, "test", "-r", f"{ROOT}/run").returncode != 0:
        pytest.skip("the clone is in a folder that nobody else may enter")
    environ = {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path / "home")}
    script = f"source '{ROOT}/setup.bash' && rospack find track_model && echo [$ROS_LOG_DIR]"
    done = ran(*becomes, *SHELLS["bash"], script, env=environ, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    logs = f"[{tmp_path}/home/.local/state/paddock/ros]"
    assert done.stdout.split() == [f"{ROOT}/src/track_model", logs]
    refused = ran(*becomes, f"{ROOT}/run", "setup", env=environ)
    assert refused.returncode == 1 and "belongs to another user" in refused.stderr


def test_a_set_up_that_fails_is_not_hidden(tmp_path):
    (tmp_path / "setup.bash").write_text((ROOT / "setup.bash").read_text())
    (tmp_path / ".venv").mkdir()
    program(tmp_path / "run", "#!/bin/sh\necho export BROKEN=1\nexit 3\n")
    script = f"source '{tmp_path}/setup.bash'; echo $? $BROKEN."
    done = ran("bash", "-c", script)
    assert done.stdout == "1 .\n"

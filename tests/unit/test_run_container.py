"""./run container: its two lines, on this machine and on one that Paddock does not run on."""

import os
import re
import shlex

import pytest
import ros_rig
from run_rig import ROOT, program, run

from commands.bootstrap import packages
from commands.subcommands import container

# Writes down what it is called with; FAIL in the environment makes it fail.
ENGINE = """#!/bin/sh
printf '%s\\n' "$*" >>"$CALLS"
exit ${FAIL:-0}"""


@pytest.fixture
def machine(tmp_path):
    """A folder of programs with podman and docker, and the environment that has only those."""
    programs = tmp_path / "programs"
    programs.mkdir()
    for name in container.ENGINES:
        program(programs / name, ENGINE)
    kept = {name: value for name, value in os.environ.items() if name not in container.PASSWORDS}
    return programs, {
        **kept, "PATH": f"{programs}:/usr/bin:/bin", "CALLS": str(tmp_path / "calls")
    }  # fmt: skip


def test_the_image_is_built_and_started(machine, tmp_path):
    (tmp_path / "ws" / "src").mkdir(parents=True)
    programs, environ = machine
    done = run("container", "--workspace", "ws", "exec", "roslaunch", "a", "--wait", "b:=1",
               env=environ, cwd=tmp_path)  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    calls = (tmp_path / "calls").read_text().splitlines()
    assert calls[0] == f"build -t paddock {ROOT}"
    assert calls[1].startswith("run --rm --init --network host -v ") and len(calls) == 2
    assert f" -v {tmp_path}/ws/src:/home/paddock/paddock/src/workspace:ro " in calls[1]
    assert calls[1].endswith(" paddock exec roslaunch a --wait b:=1")
    said = [shlex.split(line) for line in done.stdout.splitlines()]
    assert [" ".join(words[1:]) for words in said] == calls
    assert {words[0] for words in said} == {"podman"}
    (programs / "podman").unlink()
    assert run("container", env=environ).stdout.splitlines()[1].startswith("docker run --rm ")


def test_print_runs_nothing_and_needs_no_engine(machine, tmp_path):
    environ = {**machine[1], "PATH": "/usr/bin:/bin", "PADDOCK_WEB_PASSWORD": "parking"}
    words = ("--engine", "docker", "--publish", "web", "--share")
    done = run("container", "--print", *words, env=environ)
    build, start = done.stdout.splitlines()
    assert build == f"docker build -t paddock {ROOT}" and not (tmp_path / "calls").exists()
    assert start == (
        "docker run --rm --init -it -p 127.0.0.1:6080:6080 -p 127.0.0.1:7080:7080 "
        "-e PADDOCK_WEB_PASSWORD paddock web --share"
    )


def test_what_the_image_has_is_what_the_lines_take():
    text = (ROOT / "Containerfile").read_text()
    folder = os.path.dirname(os.path.dirname(container.SOURCES))
    for line in ("--shell /bin/bash paddock\n", f"WORKDIR {folder}\n", 'ENTRYPOINT ["./run"]'):
        assert line in text
    lists = set(re.findall(r"apt[\w-]*\.txt", text))
    assert all((ROOT / "config" / name).is_file() for name in lists)
    small, desk = text.split("FROM ci AS desk")
    assert "apt-desk" not in small and packages.DESK_LIST in desk
    assert packages.DESK_SERVER_LIST in desk


def test_no_engine_is_one_sentence(tmp_path):
    for name in ("bash", "id", "mkdir", "cat"):
        (tmp_path / name).symlink_to(f"/bin/{name}")
    done = run("container", env={"PATH": str(tmp_path)})
    assert done.returncode == 1 and "there is no podman or docker on this machine" in done.stderr
    done = run("container", "--engine", "docker", env={"PATH": str(tmp_path)})
    assert done.returncode == 1 and "there is no docker on this machine" in done.stderr


def test_a_system_that_paddock_does_not_run_on_has_it(tmp_path):
    """It takes any python3; every other command is refused and names it."""
    system = ros_rig.System(tmp_path, "NAME=Else\nID=else\n", apt=False)
    done = system.run("container")
    assert done.returncode == 1 and "container needs a python3" in done.stderr
    program(tmp_path / "programs" / "python3", '#!/bin/sh\necho "$@"\n')
    done = system.run("container", "--print", "desk")
    assert done.stdout == f"-I -S {system.root}/commands/__main__.py container --print desk\n"
    done = system.run("demo")
    assert done.returncode == 1 and done.stderr.endswith("browser: ./run container\n")

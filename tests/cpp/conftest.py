"""Each file with a workspace is a node, as in tests/long; the package of tests/cpp/acting."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from drop_in_workspace import Workspace
from node_fixture import node  # noqa: F401

ACTING = Path(__file__).parent / "acting"
SCRIPT = Path(__file__).with_name("host_script.py")


@pytest.fixture(scope="session")
def acting():
    """The package, built on top of this workspace."""
    files = {
        str(path.relative_to(ACTING)): path.read_text()
        for path in ACTING.rglob("*")
        if path.is_file()
    }
    made = Workspace("acting", files)
    status, output = made.build()
    assert status == 0, output
    yield made
    made.close()


@pytest.fixture
def steps_of(acting, tmp_path):
    """Function that makes steps of a model: exit status, and what was printed."""

    def made(model, steps=50, code=""):
        (tmp_path / "model.sdf").write_text(model)
        command = f"source {acting.setup} && exec {sys.executable} {SCRIPT} "
        done = subprocess.run(
            ["bash", "-c", command + '"$@"', "-", str(tmp_path / "model.sdf"), str(steps), code],
            env={**os.environ, "HOME": str(tmp_path)},
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
            timeout=300.0,
        )
        return done.returncode, re.sub(r"\x1b\[[0-9;]*m", "", done.stdout)

    return made

"""Linters of packages, Python and bash; each warning is an error."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILES = subprocess.run(
    [sys.executable, "-m", "ruff", "check", "--show-files"],
    cwd=ROOT,
    capture_output=True,
    text=True,
).stdout.split()
LINTERS = {
    "catkin_lint": ["catkin_lint", "--strict", "-W1", "src"],
    "ruff_check": [sys.executable, "-m", "ruff", "check", "--no-cache"],
    "ruff_format": [sys.executable, "-m", "ruff", "format", "--check", "--no-cache"],
    "mypy": [sys.executable, "-m", "mypy", "--cache-dir=.cache/mypy"],
    "vermin": [
        Path(sys.executable).with_name("vermin"),
        "-t=3.8-",
        "--violations",
        "--no-tips",
        *FILES,
    ],
    "shellcheck": ["shellcheck", "run", "setup.bash", ".ci/run"],
}


@pytest.mark.parametrize("name", LINTERS)
def test_no_warnings(name):
    done = subprocess.run(
        LINTERS[name],
        cwd=ROOT,
        check=False,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert done.returncode == 0, done.stdout

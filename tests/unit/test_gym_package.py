"""paddock_gym as pip installs it: with what it needs of the core, without catkin and ROS."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from bullet_sim.engine.quickstep.sources import CACHE, library_path

ROOT = Path(__file__).resolve().parents[2]
USE = """
import sys
import gymnasium
import bullet_sim, paddock_gym, track_model
env = gymnasium.make("Paddock/DeepRacer-v1", track="easy", observation=("state", "camera"))
env.reset(seed=1)
observation, *_ = env.step(env.action_space.sample())
assert observation["camera"].shape == (120, 160, 1)
env.close()
for module in (bullet_sim, paddock_gym, track_model):
    print(module.__file__)
assert "rospy" not in sys.modules
print("numba" in sys.modules)
"""


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    """Folder that pip has installed the package into."""
    folder = tmp_path_factory.mktemp("prefix")
    command = [sys.executable, "-m", "pip", "install", "--no-deps", "--no-build-isolation"]
    command += ["--no-index", "--quiet", "--disable-pip-version-check", "--ignore-installed"]
    subprocess.run(
        [*command, "--prefix", str(folder), str(ROOT / "src" / "paddock_gym")], check=True
    )
    return folder


def keep_library(packages):
    """Gives it the library of ./run setup, without which numba compiles for a minute at its start.

    tests/long/test_gym_first_start.py has numba compile.
    """
    kept = packages / "bullet_sim" / "engine" / "quickstep" / CACHE.name
    kept.mkdir(exist_ok=True)
    shutil.copy(library_path(), kept)


def use(packages, folder):
    """Lines that USE prints with the packages of a folder, in another folder."""
    environ = {name: value for name, value in os.environ.items() if not name.startswith("ROS")}
    environ["PYTHONPATH"] = str(packages)
    done = subprocess.run(
        [sys.executable, "-c", USE],
        env=environ,
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return done.stdout.splitlines()


def test_the_installed_package_drives(prefix, tmp_path):
    packages = next(prefix.rglob("paddock_gym/__init__.py")).parents[1]
    keep_library(packages)
    *files, has_numba = use(packages, tmp_path)
    assert len(files) == 3 and all(line.startswith(str(packages)) for line in files)
    assert has_numba == "False"  # its sources are ours


def test_nothing_is_left_in_the_sources(prefix):
    package = ROOT / "src" / "paddock_gym"
    left = [path.name for path in package.rglob("*") if path.name in ("build", "dist")]
    assert left == [] and not list(package.rglob("*.egg-info"))

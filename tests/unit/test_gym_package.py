"""paddock_gym as pip installs it: with what it needs of the core, without catkin and ROS."""

import ast
import os
import re
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


PIP = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
SDIST = (
    "import sys; sys.path.insert(0, 'packaging'); import standalone; standalone.build_sdist({!r})"
)
EXTRAS = {
    "matplotlib",
    "onnx",
    "optuna",
    "pandas",
    "pettingzoo",
    "ray",
    "stable_baselines3",
    "torch",
}
CORE = ("bullet_sim", "paddock_gym")  # others have nodes, too
OPTIONAL = {"bullet_web", "osgeo", "pybullet", "pygame"}  # imported where something needs it
STANDARD = set(sys.builtin_module_names) | set(getattr(sys, "stdlib_module_names", ()))
DISTRIBUTIONS = {"cv2": "opencv-python-headless", "PIL": "pillow", "yaml": "PyYAML",
                 "collada": "pycollada", "llvmlite": "numba"}  # fmt: skip


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """Path of the source distribution, in a folder outside the clone."""
    folder = tmp_path_factory.mktemp("source")
    subprocess.run(
        [sys.executable, "-c", SDIST.format(str(folder))],
        cwd=ROOT / "src" / "paddock_gym",
        stdout=subprocess.DEVNULL,
        check=True,
    )
    (path,) = folder.glob("paddock_gym-*.tar.gz")
    return path


@pytest.fixture(scope="module")
def prefix(source, tmp_path_factory):
    """Folder that pip has installed a wheel of the source distribution into."""
    wheels, folder = tmp_path_factory.mktemp("wheels"), tmp_path_factory.mktemp("prefix")
    options = ["--no-deps", "--no-index"]
    command = [*PIP, "wheel", *options, "--no-build-isolation", "--wheel-dir", str(wheels)]
    subprocess.run([*command, str(source)], cwd=wheels, check=True)
    (wheel,) = wheels.glob("paddock_gym-*.whl")
    command = [*PIP, "install", *options, "--ignore-installed", "--prefix", str(folder)]
    subprocess.run([*command, str(wheel)], cwd=wheels, check=True)
    return folder


def imported(path):
    """Top-level names that a file imports, also in functions; but not for types alone."""
    names, tree = set(), ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            node.body = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add(node.module.split(".")[0])
    return names


@pytest.mark.skipif(sys.version_info < (3, 10), reason="Python does not tell its modules")
def test_whatever_it_imports_is_required(prefix):
    packages = next(prefix.rglob("paddock_gym/__init__.py")).parents[1]
    own = {path.parent.name for path in packages.glob("*/__init__.py")}
    (metadata,) = packages.glob("paddock_gym-*.dist-info/METADATA")
    required = re.findall(r"^Requires-Dist: ([\w.-]+)[^;\n]*$", metadata.read_text(), re.M)
    required = {name.lower() for name in required}
    foreign = {}
    for path in packages.rglob("*.py"):
        for name in imported(path):
            foreign.setdefault(name, path.relative_to(packages))
    for name, path in foreign.items():
        is_ros = name.endswith(("_msgs", "_srvs")) or name.startswith(("ros", "tf2", "dynamic_rec"))
        if name in own | EXTRAS | OPTIONAL | STANDARD or is_ros or path.parts[0] not in CORE:
            continue
        assert DISTRIBUTIONS.get(name, name).lower() in required, f"{path} imports {name}"


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

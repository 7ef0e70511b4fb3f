"""The environments with the oldest Gymnasium that paddock_gym takes, and with the newest."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "paddock_gym"
REQUIRED = re.search(r'"gymnasium(>=([\d.]+),<[\d.]+)"', (PACKAGE / "setup.py").read_text())
TESTS = ("test_env.py", "test_robot_env.py", "test_worlds.py", "test_race.py", "test_backing.py")
MAKE_VEC = "not worlds.py and not several_worlds"  # Gymnasium 0.29's takes no options
TOGETHER = """
import gymnasium, numpy
from paddock_gym.envs.worlds import WorldsEnv
print(gymnasium.__version__)
env = WorldsEnv(num_envs=2, max_episode_steps=2)
env.reset(seed=1)
print([env.step(numpy.zeros((2, 2), "f"))[3].tolist() for _ in range(3)])
env.close()
"""


@pytest.mark.parametrize("which, tests", [(f"=={REQUIRED[2]}", MAKE_VEC), (REQUIRED[1], "")])
def test_environments_are_what_gymnasium_expects(which, tests, tmp_path):
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target"]
    subprocess.run([*pip, str(tmp_path), f"gymnasium{which}"], check=True)
    environ = dict(os.environ, PYTHONPATH=os.pathsep.join((str(tmp_path), *sys.path)))
    shown = subprocess.run(
        [sys.executable, "-c", TOGETHER], env=environ, stdout=subprocess.PIPE, text=True, check=True
    ).stdout.splitlines()
    assert not shown[0].startswith("1.0.") and (tests == "" or f"=={shown[0]}" == which)
    assert shown[1] == "[[False, False], [True, True], [False, False]]"
    files = [str(PACKAGE / "test" / name) for name in TESTS]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", tests]
    command += files
    done = subprocess.run(command, env=environ, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert done.returncode == 0, done.stdout

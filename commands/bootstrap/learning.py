"""What ./run train needs beyond the set-up: Debian's torch, stable-baselines3 in .venv."""

import os

from commands import processes
from commands.bootstrap.lock import SetupLock
from commands.paths import ROOT, VENV, VENV_PYTHON, read, write

PACKAGES = "apt-learning.txt"  # in config/
REQUIREMENTS = os.path.join(ROOT, "config", "requirements-learning.txt")
STAMP = os.path.join(VENV, ".stamp-learning")


def prepare():
    """Installs what is missing, after bootstrap.prepare().

    Raises:
        CommandError: A step failed.
        SystemExit: Debian packages could not be installed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    with SetupLock():
        status = processes.run_child(
            ["bash", os.path.join(ROOT, "run"), "--packages", PACKAGES], session=False, grace=None
        )
        if status != 0:
            raise SystemExit(status if status > 0 else 128 - status)
        if read(STAMP) != _wanted():
            from commands.bootstrap.step import Step

            Step(
                2,
                "Python packages for learning",
                "Check the network (or your pip index settings) and that the disk is not full.",
                "install_learning",
                of=2,
            ).run(_install)


def _wanted():
    """What .stamp-learning holds when everything is there."""
    return read(os.path.join(VENV, ".stamp")).split("\n")[0] + "\n" + read(REQUIREMENTS)


def _install(step):
    pip = [VENV_PYTHON, "-m", "pip", "install", "--disable-pip-version-check", "--no-deps"]
    environ = dict(os.environ, PYTHONNOUSERSITE="1")
    step.execute([*pip, "-r", REQUIREMENTS], environ)
    step.execute([VENV_PYTHON, "-c", "import stable_baselines3, torch"], environ)
    write(STAMP, _wanted())

"""What ./run train, sweep and cluster need beyond the set-up: Debian and Python packages."""

import os

from commands.bootstrap import packages
from commands.bootstrap.lock import SetupLock
from commands.paths import ROOT, VENV, VENV_PYTHON, read, write

# Name of the lists in config/ (apt-NAME.txt, requirements-NAME.txt) -> what must be importable.
EXTRAS = {
    "learning": "stable_baselines3, torch",
    "ray": "ray",
    "sweep": "optuna",
}


def prepare(*names):
    """Installs what is missing, after bootstrap.prepare().

    Args:
        names: Of EXTRAS; none: learning.

    Raises:
        CommandError: A step failed.
        SystemExit: Debian packages could not be installed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    with SetupLock():
        for name in names or ("learning",):
            _prepare(name)


def requirements(name):
    """Gives the path of a list of Python packages."""
    return os.path.join(ROOT, "config", f"requirements-{name}.txt")


def _prepare(name):
    packages.prepare_more(f"apt-{name}.txt", steps=2)
    if read(_stamp(name)) != _wanted(name):
        from commands.bootstrap.step import Step

        Step(
            2,
            f"Python packages ({name})",
            "Check the network (or your pip index settings) and that the disk is not full.",
            f"install_{name}",
            of=2,
        ).run(lambda step: _install(step, name))


def _stamp(name):
    return os.path.join(VENV, f".stamp-{name}")


def _wanted(name):
    """What the stamp holds when everything is there."""
    return read(os.path.join(VENV, ".stamp")).split("\n")[0] + "\n" + read(requirements(name))


def _install(step, name):
    pip = [VENV_PYTHON, "-m", "pip", "install", "--disable-pip-version-check", "--no-deps"]
    environ = dict(os.environ, PYTHONNOUSERSITE="1")
    step.execute([*pip, "-r", requirements(name)], environ)
    step.execute([VENV_PYTHON, "-c", f"import {EXTRAS[name]}"], environ)
    write(_stamp(name), _wanted(name))

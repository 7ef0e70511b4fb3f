"""Step 2, Python packages: .venv above Debian's Python, with what config/requirements.txt pins."""

import os

from commands import signature
from commands.paths import PYTHON, ROOT, VENV, VENV_PYTHON, read, write

REQUIREMENTS = os.path.join(ROOT, "config", "requirements.txt")
STAMP = os.path.join(VENV, ".stamp")  # base and requirements of a complete .venv, a line each
CHECK = os.path.join(ROOT, "commands", "bootstrap", "check_imports.py")


def prepare():
    """Makes or completes .venv if its inputs changed.

    Raises:
        CommandError: It failed.
        Interrupted: A signal ended it.
    """
    if signature.unchanged("venv", ROOT):
        return
    if not os.access(VENV_PYTHON, os.X_OK) or read(STAMP) != f"{_base()}\n{_requirements()}\n":
        from commands.bootstrap.step import Step

        Step(
            2,
            "Python packages",
            "Check the network (or your pip index settings) and that the disk is not full.",
            "install_python",
        ).run(_install)
    signature.save("venv", ROOT, [REQUIREMENTS, STAMP, VENV_PYTHON, PYTHON])


def _base():
    """Names what .venv is bound to: Debian's Python, and the place of the clone."""
    return f"{os.path.realpath(PYTHON)} {ROOT}"


def _requirements():
    import hashlib

    with open(REQUIREMENTS, "rb") as stream:
        return hashlib.sha256(stream.read()).hexdigest()


def _install(step):
    environ = dict(os.environ, PYTHONNOUSERSITE="1")
    stamp = f"{_base()}\n{_requirements()}\n"
    if read(STAMP).split("\n")[0] != _base():
        import shutil

        if os.path.isdir(VENV):
            shutil.rmtree(VENV)
        step.execute([PYTHON, "-m", "venv", "--system-site-packages", VENV], environ)
    elif os.path.exists(STAMP):
        os.remove(STAMP)  # without one, .venv is made anew: what pip left half done cannot be known
    pip = [VENV_PYTHON, "-m", "pip", "install", "--disable-pip-version-check", "--no-deps"]
    step.execute([*pip, "-r", REQUIREMENTS], environ)
    step.execute([VENV_PYTHON, CHECK, VENV], environ)
    write(STAMP, stamp)

"""Step 2, Python packages: .venv above Debian's Python, with what config/requirements.txt pins."""

import glob
import os
import sys

from commands import signature
from commands.paths import CACHE, PYTHON, ROOT, VENV, VENV_PYTHON, read, write

REQUIREMENTS = os.path.join(ROOT, "config", "requirements.txt")
STAMP = os.path.join(VENV, ".stamp")  # base and requirements of a complete .venv, a line each
CHECK = os.path.join(ROOT, "commands", "bootstrap", "check_imports.py")
WHEELS = os.path.join(CACHE, "wheels")  # what was compiled here
COMPILED, WHEELS_UP_TO = "pybullet", (3, 11)  # the last Python for which PyPI has a wheel

# gcc 14 makes an error of a cast that numpy 2 wants: PyArray_DATA() of a PyObject
CFLAGS = "-g0 -Wno-error=incompatible-pointer-types"


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
    _compile(step, environ)
    step.execute([*_pip("install"), "--find-links", WHEELS, "-r", REQUIREMENTS], environ)
    step.execute([VENV_PYTHON, CHECK, VENV], environ)
    write(STAMP, stamp)


def _pip(command):
    return [VENV_PYTHON, "-m", "pip", command, "--disable-pip-version-check", "--no-deps"]


def _compile(step, environ):
    """Compiles what PyPI has no wheel of for this Python, unless an earlier set-up has."""
    lines = read(REQUIREMENTS).splitlines()
    pin = next((line for line in lines if line.startswith(f"{COMPILED}==")), None)
    if pin is None or sys.version_info[:2] <= WHEELS_UP_TO or _compiled(pin):
        return
    step.note(
        "PyPI has no {} for Python {}.{}: compiling it, once; 7 to 10 minutes on two cores".format(
            COMPILED, *sys.version_info
        )
    )
    # Without isolation it finds numpy, for pictures as arrays; a wheel in pip's cache may lack it.
    options = ("--no-build-isolation", "--no-cache-dir", "-w", WHEELS)
    step.execute([*_pip("wheel"), *options, pin], {**environ, "CFLAGS": CFLAGS})


def _compiled(pin):
    """Says whether an earlier set-up has left the wheel of a pin for this Python."""
    name, _, version = pin.partition("==")
    tag = "cp{}{}".format(*sys.version_info)
    return bool(glob.glob(os.path.join(WHEELS, f"{name}-{version}-{tag}-*.whl")))

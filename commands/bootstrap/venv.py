"""Step 2, Python packages in .venv: what config/requirements.txt pins, and more to learn."""

import glob
import os
import sys

from commands import signature
from commands.bootstrap import packages
from commands.bootstrap.step import SetupLock, Step
from commands.paths import CACHE, PYTHON, ROOT, VENV, VENV_PYTHON, read, write

REQUIREMENTS = os.path.join(ROOT, "config", "requirements.txt")
STAMP = os.path.join(VENV, ".stamp")  # base and requirements of a complete .venv, a line each
# Run by .venv's Python, with the path of .venv: whether what Paddock imports is there.
CHECK = """
import sys
import av, cv2, cv_bridge, numpy, pybullet, pytest, rospy, xacro, yaml
from PyQt5 import QtWidgets
if numpy.__file__.startswith(sys.argv[1]):
    sys.exit(f"numpy is {numpy.__version__} of .venv; Debian's has to stay, cv_bridge needs it")
"""
ADVICE = "Check the network (or your pip index settings) and that the disk is not full."
WHEELS = os.path.join(CACHE, "wheels")  # what was compiled here
COMPILED, WHEELS_UP_TO = "pybullet", (3, 11)  # the last Python for which PyPI has a wheel

# gcc 14 makes an error of a cast that numpy 2 wants: PyArray_DATA() of a PyObject
CFLAGS = "-g0 -Wno-error=incompatible-pointer-types"
# Name of the lists in config/ (apt-NAME.txt, requirements-NAME.txt) -> what must be importable.
EXTRAS = {
    "learning": "stable_baselines3, torch",
    "ray": "ray",
    "sweep": "optuna",
}


def prepare():
    """Makes or completes .venv if its inputs changed.

    Raises:
        CommandError: It failed.
        Interrupted: A signal ended it.
    """
    if signature.unchanged("venv", ROOT):
        return
    if not os.access(VENV_PYTHON, os.X_OK) or read(STAMP) != _stamp():
        Step(
            2,
            "Python packages",
            ADVICE,
            "install_python",
        ).run(_install)
    signature.save("venv", ROOT, [REQUIREMENTS, STAMP, VENV_PYTHON, PYTHON])


def _base():
    """Names what .venv is bound to: Debian's Python, and the place of the clone."""
    return f"{os.path.realpath(PYTHON)} {ROOT}"


def _stamp():
    """What STAMP holds when .venv is complete."""
    import hashlib

    with open(REQUIREMENTS, "rb") as stream:
        return f"{_base()}\n{hashlib.sha256(stream.read()).hexdigest()}\n"


def _install(step):
    environ = dict(os.environ, PYTHONNOUSERSITE="1")
    if read(STAMP).split("\n")[0] != _base():
        import shutil

        if os.path.isdir(VENV):
            shutil.rmtree(VENV)
        step.execute([PYTHON, "-m", "venv", "--system-site-packages", VENV], environ)
    elif os.path.exists(STAMP):
        os.remove(STAMP)  # what pip leaves half done cannot be known: .venv is made again then
    _compile(step, environ)
    step.execute([*_pip("install"), "--find-links", WHEELS, "-r", REQUIREMENTS], environ)
    step.execute([VENV_PYTHON, "-c", CHECK, VENV], environ)
    write(STAMP, _stamp())


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
    # Without isolation it finds numpy, for images as arrays; a wheel in pip's cache may lack it.
    options = ("--no-build-isolation", "--no-cache-dir", "-w", WHEELS)
    step.execute([*_pip("wheel"), *options, pin], {**environ, "CFLAGS": CFLAGS})


def _compiled(pin):
    """Returns whether an earlier set-up has left the wheel of a pin for this Python."""
    name, _, version = pin.partition("==")
    tag = "cp{}{}".format(*sys.version_info)
    return bool(glob.glob(os.path.join(WHEELS, f"{name}-{version}-{tag}-*.whl")))


def prepare_extras(*names):
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
            _prepare_extra(name)


def extra_requirements(name):
    """Returns the path of a list of Python packages."""
    return os.path.join(ROOT, "config", f"requirements-{name}.txt")


def _prepare_extra(name):
    packages.prepare_more(f"apt-{name}.txt", steps=2)
    if read(_extra_stamp(name)) != _extra_wanted(name):
        Step(
            2,
            f"Python packages ({name})",
            ADVICE,
            f"install_{name}",
            of=2,
        ).run(lambda step: _install_extra(step, name))


def _extra_stamp(name):
    return os.path.join(VENV, f".stamp-{name}")


def _extra_wanted(name):
    """What the stamp holds when everything is there."""
    return read(os.path.join(VENV, ".stamp")).split("\n")[0] + "\n" + read(extra_requirements(name))


def _install_extra(step, name):
    environ = dict(os.environ, PYTHONNOUSERSITE="1")
    step.execute([*_pip("install"), "-r", extra_requirements(name)], environ)
    step.execute([VENV_PYTHON, "-c", f"import {EXTRAS[name]}"], environ)
    write(_extra_stamp(name), _extra_wanted(name))

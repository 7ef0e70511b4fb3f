"""Step 2, Python packages in .venv: what config/requirements.txt pins, and more to learn."""

import glob
import os
import sys

from commands import signature
from commands.bootstrap import packages, ros
from commands.bootstrap.step import SetupLock, Step
from commands.paths import CACHE, ROOT, VENV, VENV_PYTHON, VENV_STAMP, read, write

REQUIREMENTS = os.path.join(ROOT, "config", "requirements.txt")
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
# The last Python, and the one machine, for which PyPI has a wheel of it.
COMPILED, WHEELS_UP_TO, WHEELS_FOR = "pybullet", (3, 11), "x86_64"
MACHINE = os.uname().machine

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
    key = _key()
    if signature.unchanged("venv", key):
        return
    if not _complete():
        Step(
            2,
            "Python packages",
            ADVICE,
            "install_python",
        ).run(_install)
    signature.save("venv", key, [REQUIREMENTS, VENV_STAMP, VENV_PYTHON, ros.python()])


def ready():
    """Returns whether prepare() has nothing to do."""
    return signature.unchanged("venv", _key()) or _complete()


def _key():
    return f"{ROOT} {ros.prefix()}"


def _complete():
    return os.access(VENV_PYTHON, os.X_OK) and read(VENV_STAMP) == _stamp()


def _base():
    """Names what .venv is bound to: a Python, the clone's place, the folder of a sourced ROS."""
    return f"{os.path.realpath(ros.python())} {ROOT} {ros.prefix()}".rstrip()


def _stamp():
    """What STAMP holds when .venv is complete."""
    import hashlib

    with open(REQUIREMENTS, "rb") as stream:
        return f"{_base()}\n{hashlib.sha256(stream.read()).hexdigest()}\n"


def _install(step):
    environ = dict(os.environ, PYTHONNOUSERSITE="1")
    folder = ros.prefix()
    ros.leave(environ, folder)
    if read(VENV_STAMP).split("\n")[0] != _base():
        import shutil

        if os.path.isdir(VENV):
            shutil.rmtree(VENV)
        step.execute([ros.python(), "-m", "venv", "--system-site-packages", VENV], environ)
    _begin(folder)
    _compile(step, environ)
    step.execute([*_pip("install"), "--find-links", WHEELS, "-r", REQUIREMENTS], environ)
    ros.enter(environ, folder)
    step.execute([VENV_PYTHON, "-c", CHECK, VENV], environ)
    write(VENV_STAMP, _stamp())


def _begin(folder):
    """Marks .venv as incomplete: what pip leaves half done cannot be known, it is made again then.

    Args:
        folder: Of a sourced ROS, which is remembered nevertheless; or empty.
    """
    if folder:
        write(VENV_STAMP, f"? {ROOT} {folder}\n")
    elif os.path.exists(VENV_STAMP):
        os.remove(VENV_STAMP)


def _pip(command):
    return [VENV_PYTHON, "-m", "pip", command, "--disable-pip-version-check", "--no-deps"]


def _compile(step, environ):
    """Compiles what PyPI has no wheel of for this Python, unless an earlier set-up has."""
    lines = read(REQUIREMENTS).splitlines()
    pin = next((line for line in lines if line.startswith(f"{COMPILED}==")), None)
    if pin is None or _has_wheel() or _compiled(pin):
        return
    where = "Python {}.{}".format(*_version()) + ("" if MACHINE == WHEELS_FOR else f" on {MACHINE}")
    step.note(
        f"PyPI has no {COMPILED} for {where}: compiling it, once; 7 to 10 minutes on two cores"
    )
    # Without isolation it finds numpy, for images as arrays; a wheel in pip's cache may lack it.
    options = ("--no-build-isolation", "--no-cache-dir", "-w", WHEELS)
    step.execute([*_pip("wheel"), *options, pin], {**environ, "CFLAGS": CFLAGS})


def _has_wheel():
    return MACHINE == WHEELS_FOR and _version() <= WHEELS_UP_TO


def _version():
    """Returns the version of .venv's Python: (3, 11). It need not be the one that runs this."""
    for line in read(os.path.join(VENV, "pyvenv.cfg")).splitlines():
        if line.startswith("version ="):
            major, minor = line.partition("=")[2].split(".")[:2]
            return int(major), int(minor)
    return sys.version_info[:2]


def _compiled(pin):
    """Returns whether an earlier set-up has left the wheel of a pin for this Python."""
    name, _, version = pin.partition("==")
    tag = "cp{}{}".format(*_version())
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

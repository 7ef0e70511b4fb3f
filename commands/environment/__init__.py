"""The environment in which commands run: the caller's, with .venv and the workspace in front."""

import os

from commands import bootstrap
from commands.bootstrap.inputs import STANDINS, installed_elsewhere
from commands.environment import logs, setup_bash
from commands.paths import CACHE, ROOT, VENV

LEFT_OUT = ("PYTHONHOME", "CONDA_PREFIX", "PYENV_VERSION")  # other Pythons


def ready():
    """Sets up what is missing.

    Returns:
        The environment as a dict, for processes.become() or run_child().

    Raises:
        CommandError: A step of the set-up failed.
        Interrupted: A signal ended it.
    """
    bootstrap.prepare()
    return activated(callers())


def callers():
    """Gives the environment that ./run was started with."""
    environ = dict(os.environ)
    if "LC_CTYPE" in environ:  # which Python sets by itself in the C locale
        with open("/proc/self/environ", "rb") as stream:
            if not any(entry.startswith(b"LC_CTYPE=") for entry in stream.read().split(b"\0")):
                del environ["LC_CTYPE"]
    return environ


def activated(environ):
    """Puts .venv and the workspace into an environment.

    Args:
        environ: Changed in place.

    Returns:
        It.
    """
    if not environ.get("HOME") or not os.access(environ["HOME"], os.W_OK):
        environ["HOME"] = os.path.join(CACHE, "home")
        os.makedirs(environ["HOME"], exist_ok=True)
    if not environ.get("LANG") and not environ.get("LC_ALL"):
        environ["LANG"] = "C.UTF-8"
    for name in LEFT_OUT:
        environ.pop(name, None)
    environ.update(VIRTUAL_ENV=VENV, PYTHONNOUSERSITE="1", PYTHONUNBUFFERED="1")
    # Small matrices: more threads of OpenBLAS only spin, 0.1 s of each start of a node.
    environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    prepend(environ, "/usr/bin")
    setup_bash.apply(environ)
    prepend(environ, os.path.join(VENV, "bin"))
    if "xacro" not in installed_elsewhere():
        # For launch files that call a bare xacro: PyPI's in .venv cannot $(find) packages.
        prepend(environ, os.path.join(STANDINS, "xacro"))
    environ["PADDOCK_ROOT"] = ROOT
    logs.clean_up()
    if not environ.get("ROS_LOG_DIR"):
        environ["ROS_LOG_DIR"] = logs.FOLDER
    if not environ.get("ROS_IP") and not environ.get("ROS_HOSTNAME"):
        environ["ROS_IP"] = "127.0.0.1"
    return environ


def prepend(environ, directory):
    """Puts a directory in front of PATH."""
    environ["PATH"] = f"{directory}:{environ.get('PATH', '')}"

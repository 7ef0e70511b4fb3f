"""The environment of commands: the caller's, with .venv and the workspace in front."""

import glob
import os
import subprocess

from commands import bootstrap
from commands.bootstrap import left_out, ros
from commands.bootstrap.workspace import MARKER, STANDINS, in_ros, manifests_of
from commands.paths import (
    CACHE,
    DEVEL,
    KEPT,
    MODELS,
    OWN,
    PROGRAMS,
    ROOT,
    SOURCES,
    STATE,
    VENV,
    read,
    write,
)

LOG_FOLDER = os.path.join(STATE, "ros")
PYTHON_START = os.path.join(ROOT, "config", "python")  # its sitecustomize: cv2, no screen
SETUP = os.path.join(DEVEL, "setup.bash")
FROM_SCRATCH = "To build from scratch: rm -rf build devel, then ./run setup"
LEFT_OUT = ("PYTHONHOME", "CONDA_PREFIX", "PYENV_VERSION")  # other Pythons


def clean_up_logs():
    """Deletes logs that are older than a week, of those that may be deleted."""
    old = ["-mindepth", "1", "-maxdepth", "1", "-mtime", "+6", "-exec", "rm", "-rf", "{}", "+"]
    subprocess.run(["/usr/bin/find", LOG_FOLDER, *old], stderr=subprocess.DEVNULL, check=False)


def apply_setup_bash(environ):
    """Makes the changes of devel/setup.bash to an environment.

    The caller's ROS_PACKAGE_PATH stays behind ours; setup.bash itself would drop it. In front stay
    a workspace on top of this one whose setup.bash was sourced, and a folder with a package that
    has the name of one of ours, such as 'track_model': the caller means that.

    Args:
        environ: Changed in place.

    Raises:
        CommandError: setup.bash cannot be sourced.
    """
    packages = [path for path in environ.get("ROS_PACKAGE_PATH", "").split(":") if path]
    if not _has_workspace_on_top(environ):  # which has sourced this one, too
        left = _packages_of_workspaces(environ)
        packages = [path for path in packages if path not in left]
        found = ros.sourced_variables(SETUP, environ, FROM_SCRATCH)
        for name in environ.keys() - found.keys() - set(ros.BASH):
            del environ[name]
        environ.update(found)
    ours = [path for path in environ.get("ROS_PACKAGE_PATH", "").split(":") if path]
    theirs = [path for path in packages if path not in ours]
    instead = []
    for path in reversed(theirs):  # the first of them comes in front
        workspace = _workspace_of(_same_named(path))
        if workspace:
            prepend(environ, workspace, "CMAKE_PREFIX_PATH")
            instead.insert(0, path)
    behind = [path for path in theirs if path not in instead]
    environ["ROS_PACKAGE_PATH"] = ":".join([*instead, *ours, *behind])


def _has_workspace_on_top(environ):
    """Whether a workspace that is chained to this one is active."""
    prefixes = environ.get("CMAKE_PREFIX_PATH", "").split(":")
    above = prefixes[: prefixes.index(DEVEL)] if DEVEL in prefixes else []
    return any(path and os.path.isfile(os.path.join(path, ".catkin")) for path in above)


def _packages_of_workspaces(environ):
    """Lists where the packages of workspaces are that were sourced, which setup.bash leaves."""
    result = []
    for workspace in environ.get("CMAKE_PREFIX_PATH", "").split(":"):
        marker = os.path.join(workspace, ".catkin")
        if workspace and os.path.isfile(marker):
            result += (read(marker) or os.path.join(workspace, "share")).split(";")
    return result


def _same_named(folder):
    """Lists the packages below a folder that have the name of one of ours, as folders."""
    ours, found = set(os.listdir(SOURCES)), manifests_of(folder).items()
    return [path for name, path in found if name in ours and not path.startswith(SOURCES)]


def _workspace_of(packages):
    """Makes a workspace of packages, given as folders, that are not built.

    roslaunch looks for the files of a package in workspaces before it looks in ROS_PACKAGE_PATH. A
    package.xml that catkin refuses would end it, so such a package is left out, with a message.

    Returns:
        Its path, the same for the same packages; None: there is none.
    """
    if not packages:
        return None
    import hashlib
    import sys

    name = hashlib.sha256(os.fsencode(";".join(packages))).hexdigest()[:16]
    marker = os.path.join(KEPT, "workspaces", name, ".catkin")
    if not os.path.exists(marker):
        refused = left_out.refused(packages)
        for path, why in refused.items():
            print(f"run: {path}/package.xml: {why}; ours is used", file=sys.stderr)
        valid = [path for path in packages if path not in refused]
        write(marker, ";".join(valid))
    return os.path.dirname(marker) if read(marker) else None


def ready():
    """Sets up what is missing, of a clone that may be changed.

    Returns:
        The environment as a dict, for processes.become() or run_child().

    Raises:
        CommandError: A step of the set-up failed, or the clone is another user's and not set up.
        Interrupted: A signal ended it.
    """
    if OWN or not bootstrap.ready():
        bootstrap.prepare()
    return activated(callers())


def callers():
    """Returns the environment that ./run was started with."""
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
    if OWN and not (environ.get("HOME") and os.access(environ["HOME"], os.W_OK)):
        environ["HOME"] = os.path.join(CACHE, "home")
        os.makedirs(environ["HOME"], exist_ok=True)
    if not environ.get("LANG") and not environ.get("LC_ALL"):
        environ["LANG"] = "C.UTF-8"
    for name in LEFT_OUT:
        environ.pop(name, None)
    ros.leave_ros_2(environ)
    environ.update(VIRTUAL_ENV=VENV, PYTHONNOUSERSITE="1", PYTHONUNBUFFERED="1")
    # Small matrices: more threads of OpenBLAS only spin, 0.1 s of each start of a node.
    environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    prepend(environ, "/usr/bin")
    apply_setup_bash(environ)
    prepend(environ, PROGRAMS)
    prepend(environ, os.path.join(VENV, "bin"))
    if not in_ros("xacro") and not os.path.exists(os.path.join(STANDINS, "xacro", MARKER)):
        # For launch files that call a bare xacro: PyPI's in .venv cannot $(find) packages.
        prepend(environ, os.path.join(STANDINS, "xacro"))
    python = environ.get("PYTHONPATH", "").split(":")
    if PYTHON_START not in python:  # behind: a sitecustomize of the caller's comes first
        environ["PYTHONPATH"] = ":".join([*filter(None, python), PYTHON_START])
    models = environ.get("GAZEBO_MODEL_PATH", "").split(":")
    if MODELS not in models:
        environ["GAZEBO_MODEL_PATH"] = ":".join([*filter(None, models), MODELS])
    if not (environ.get("DISPLAY") or environ.get("WAYLAND_DISPLAY")):
        environ.setdefault("QT_QPA_PLATFORM", "xcb;offscreen")  # C++ programs with windows of Qt
    if not has_sound(environ):  # SDL's mixer, of pygame, ends a program where nothing can sound
        environ.setdefault("SDL_AUDIODRIVER", "dummy")
    environ["PADDOCK_ROOT"] = ROOT
    clean_up_logs()
    environ["ROS_LOG_DIR"] = environ.get("ROS_LOG_DIR") or LOG_FOLDER
    if not environ.get("ROS_IP") and not environ.get("ROS_HOSTNAME"):
        environ["ROS_IP"] = "127.0.0.1"
    return environ


def has_sound(environ):
    """Returns whether there is a sound card, or a sound server that was named or runs."""
    runtime = environ.get("XDG_RUNTIME_DIR", "")
    servers = (f"{runtime}/pulse/native", f"{runtime}/pipewire-0") if runtime else ()
    return bool(
        environ.get("PULSE_SERVER")
        or glob.glob("/dev/snd/pcm*p")
        or any(map(os.path.exists, servers))
    )


def prepend(environ, directory, name="PATH"):
    """Puts a directory in front of PATH, or of another variable of that kind."""
    environ[name] = f"{directory}:{environ.get(name, '')}"

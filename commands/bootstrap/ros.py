"""The ROS 1 that everything is built on: one that is sourced in the caller's shell, or Debian's.

A ROS 1 counts as sourced where ROS_DISTRO is set and a folder of CMAKE_PREFIX_PATH other than /usr
has rospy. .venv remembers the one that it is for, so that a shell in which nothing is sourced uses
it again, and Debian's ROS is never installed next to it. The file ./run has the same rules.
"""

import os

from commands.errors import CommandError, say
from commands.paths import PYTHON, ROOT, SYSTEM_PATH, VENV_STAMP, read, relative

OLDEST, NEWEST = (3, 8), (3, 13)  # versions of Python
LIST = os.path.join(ROOT, "config", "apt-ros.txt")
OPTIONAL = "optional"  # the mark in LIST of what Paddock itself works without
DEBIANS_SHARE = "/usr/share"
# Run by a Python of that ROS's environment: whether its rospy imports there.
PROBE = "import sys, rospy; print(*sys.version_info[:2])"
BASH = ("_", "PWD", "OLDPWD", "SHLVL")  # bash's own variables
ROS_2 = ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH", "ROS_VERSION", "ROS_DISTRO")
PATHS = ("PATH", "PYTHONPATH", "LD_LIBRARY_PATH", "CMAKE_PREFIX_PATH", "PKG_CONFIG_PATH")
WAYS = (
    "a ROS 1 for one of those (Noetic, ROS-O, RoboStack), or a container (docs/container.md), "
    "will do"
)

_found = {}  # what this process has found out: of a prefix its environment and its Python


def prefix(environ=None):
    """Returns the folder of the ROS 1 to build on; empty for Debian's.

    Args:
        environ: The caller's variables; None for this process's.
    """
    return sourced(os.environ if environ is None else environ) or remembered()


def sourced(environ):
    """Returns the folder of the ROS 1 that is sourced; empty if none is, or Debian's."""
    if not environ.get("ROS_DISTRO") or environ.get("ROS_VERSION", "1") != "1":
        return ""
    for folder in environ.get("CMAKE_PREFIX_PATH", "").split(":"):
        folder = folder[:-1] if folder.endswith("/") else folder
        if folder not in ("", "/usr") and _has_rospy(folder):
            return folder
    return ""


def remembered():
    """Returns the folder of the ROS 1 that .venv is for, if that is still there; or empty."""
    fields = read(VENV_STAMP).partition("\n")[0].split()
    return fields[2] if len(fields) == 3 and _has_rospy(fields[2]) else ""


def _has_rospy(folder):
    return os.path.isfile(f"{folder}/share/rospy/package.xml")


def share(folder=None):
    """Returns where the packages of the ROS are."""
    folder = prefix() if folder is None else folder
    return f"{folder}/share" if folder else DEBIANS_SHARE


def python():
    """Returns the Python for .venv: Debian's, or the one that the ROS's rospy imports in.

    Raises:
        CommandError: It imports in none of the versions that Paddock runs on.
    """
    folder = prefix()
    if not folder:
        return PYTHON
    fields = read(VENV_STAMP).partition("\n")[0].split()
    if fields[2:] == [folder] and os.access(fields[0], os.X_OK):
        return fields[0]
    if ("python", folder) not in _found:
        _found["python", folder] = _python_of(folder)
    return _found["python", folder]


def _python_of(folder):
    import shutil
    import subprocess

    names = ["python3", *(f"python3.{minor}" for minor in range(NEWEST[1], OLDEST[1] - 1, -1))]
    named = [f"{folder}/bin/python3", PYTHON, *map(shutil.which, names)]
    versions, problem = {}, "there is none"
    for path in dict.fromkeys(os.path.realpath(path) for path in named if path):
        if not os.access(path, os.X_OK):
            continue
        done = subprocess.run(
            [path, "-c", PROBE],
            env={**environment(folder), "PYTHONNOUSERSITE": "1"},
            capture_output=True,
            text=True,
        )
        if done.returncode == 0:
            version = tuple(map(int, done.stdout.split()[-2:]))
            if OLDEST <= version <= NEWEST:
                return path
            versions[path] = "{}.{}".format(*version)
        else:
            problem = f"{path}: {(done.stderr.strip().splitlines() or ['it died'])[-1]}"
    if versions:
        raise CommandError(
            f"rospy of the ROS that is sourced, {folder}, is for Python "
            f"{', '.join(sorted(set(versions.values())))}, and Paddock needs {_range()}: {WAYS}"
        )
    raise CommandError(
        f"rospy of the ROS that is sourced, {folder}, imports in no Python from {_range()} "
        f"({problem}): {WAYS}"
    )


def _range():
    return "{}.{} to {}.{}".format(*OLDEST, *NEWEST)


def environment(folder):
    """Returns the variables of a shell in which nothing but a ROS is sourced.

    Raises:
        CommandError: It has no setup.bash, or that fails.
    """
    if ("environment", folder) not in _found:
        result = sourced_variables(f"{folder}/setup.bash", {"PATH": SYSTEM_PATH})
        _found["environment", folder] = result
    return dict(_found["environment", folder])


def sourced_variables(setup, environ, *advice):
    """Returns the variables of an environment after a setup.bash.

    Args:
        setup: Its path.
        advice: What helps if it fails.

    Raises:
        CommandError: It is not there, or fails.
    """
    import subprocess

    # catkin's needs a file for a moment: where no disk is full, if the caller says no other place
    memory = '[ ! -w /dev/shm ] || : "${TMPDIR:=/dev/shm}"'
    script = f'{memory}; . "$0" >&2 && exec /usr/bin/env -0'
    done = subprocess.run(["/bin/bash", "-c", script, setup], env=environ, capture_output=True)
    if done.returncode != 0:
        words = " ".join(os.fsdecode(done.stderr).split()) or f"exit status {done.returncode}"
        raise CommandError(f"{relative(setup)} cannot be sourced: {words}", *advice)
    entries = os.fsdecode(done.stdout).split("\0")[:-1]
    variables = dict(entry.split("=", 1) for entry in entries)
    return {name: value for name, value in variables.items() if name not in BASH}


def listed(path=LIST):
    """Reads the list of Debian's ROS packages.

    Returns:
        List of (name in Debian, name of the ROS package, whether Paddock works without it).
    """
    lines = (line.partition("#")[0].split() for line in read(path).splitlines())
    return [(words[0], words[1], OPTIONAL in words[2:]) for words in lines if words]


def lacking(folder):
    """Returns which packages a ROS lacks: (those that Paddock needs, those that it does not)."""
    needed, other = [], []
    for _, name, optional in listed():
        names = other if optional else needed
        if name not in names and not os.path.exists(f"{share(folder)}/{name}/package.xml"):
            names.append(name)
    return needed, other


def check():
    """Refuses a ROS that Paddock cannot be built on; says what else it lacks.

    Raises:
        CommandError: Its Python is none of ours, or it lacks packages.
    """
    folder = prefix()
    if not folder:
        return
    python()
    needed, other = lacking(folder)
    if needed:
        raise CommandError(
            f"the ROS that is sourced, {folder}, lacks {', '.join(needed)}, and Paddock does not "
            "mix it with Debian's ROS",
            *_how_to_get(folder, needed),
        )
    if other:
        say(f"{folder} lacks {', '.join(other)}: what needs that will not start")
    if _has_rospy("/usr"):
        say(f"Debian's ROS is installed, too; what both have is taken from {folder}")


def _how_to_get(folder, names):
    parent, distro = os.path.split(folder)
    if parent != "/opt/ros":
        return ()
    packages = (f"ros-{distro}-{name.replace('_', '-')}" for name in names)
    return (f"If it came by apt, as root: apt-get install {' '.join(packages)}",)


def announce():
    """Says which ROS is used, if it is not Debian's."""
    folder = prefix()
    if folder:
        how = "as sourced" if sourced(os.environ) else "as when .venv was made; none is sourced"
        say(f"ROS 1: {folder}, {how}, with {python()}")


def leave_ros_2(environ):
    """Takes a ROS 2 that is sourced out of an environment: its messages have the names of ROS 1's.

    Args:
        environ: Changed in place.
    """
    if environ.get("ROS_VERSION") == "2":
        _remove(environ, [path for path in environ.get("AMENT_PREFIX_PATH", "").split(":") if path])
        for name in ROS_2:
            environ.pop(name, None)


def leave(environ, folder):
    """Takes what is sourced of a ROS 1, and a ROS 2, out of the paths of an environment.

    Args:
        environ: Changed in place.
        folder: Of the ROS 1; empty for Debian's, which has no paths of its own.
    """
    leave_ros_2(environ)
    if folder:
        _remove(environ, [folder])


def enter(environ, folder):
    """Puts a ROS 1, and nothing else that may be sourced, into an environment.

    Args:
        environ: Changed in place: its variables are set, and its paths come before the others.
        folder: As in leave().
    """
    leave(environ, folder)
    if not folder:
        return
    for name, value in environment(folder).items():
        after = environ.get(name, "") if name in PATHS else ""
        environ[name] = value + (f":{after}" if after else "")


def _remove(environ, folders):
    for name in PATHS:
        if name in environ:
            kept = [path for path in environ[name].split(":") if not _below(path, folders)]
            environ[name] = ":".join(kept)
            if not kept:
                del environ[name]


def _below(path, folders):
    return any(f"{path}/".startswith(f"{folder.rstrip('/')}/") for folder in folders)

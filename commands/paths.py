"""Where things are: the clone, what set-up makes in it, and the system's Python."""

import os
import re

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
SOURCES = os.path.join(ROOT, "src")
BUILD = os.path.join(ROOT, "build")
DEVEL = os.path.join(ROOT, "devel")
CACHE = os.path.join(ROOT, ".cache")  # what set-up has brought; ./run makes it
OWN = os.access(CACHE if os.path.isdir(CACHE) else ROOT, os.W_OK)  # whether it may be changed


def _kept(of_clone, variable, default):
    """Returns a folder to write to: of the clone, or of a user who may only read that (XDG)."""
    if OWN:
        return of_clone
    base = os.environ.get(variable, "")
    if not os.path.isabs(base):
        base = os.path.join(os.path.expanduser("~"), default)
    return os.path.join(base, "paddock")


KEPT = _kept(CACHE, "XDG_CACHE_HOME", ".cache")
STATE = _kept(CACHE, "XDG_STATE_HOME", ".local/state")
OUT = os.path.join(_kept(ROOT, "XDG_DATA_HOME", ".local/share"), "out")
LOGS = os.path.join(STATE, "log")
VENV = os.path.join(ROOT, ".venv")
GAZEBO = os.path.join(CACHE, "gazebo")  # Gazebo's libraries, by ./run add gazebo
GAZEBO_STAMP = os.path.join(GAZEBO, "packages.txt")  # of a whole one: what is unpacked
MODELS = os.path.join(CACHE, "gazebo_models")  # of Gazebo's database, by ./run add models
VENV_STAMP = os.path.join(VENV, ".stamp")  # base and requirements of a complete .venv, a line each
VENV_PYTHON = os.path.join(VENV, "bin", "python")
PYTHON = "/usr/bin/python3"
PROGRAMS = os.path.join(ROOT, "commands", "programs")  # in place of ROS's of the same names
SYSTEM_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"


def replaced(name):
    """Finds the program on PATH in whose place one of PROGRAMS is.

    Returns:
        Its path; None: there is none.
    """
    import shutil

    ours = os.path.realpath(os.path.join(PROGRAMS, name))
    folders = os.environ.get("PATH", os.defpath).split(os.pathsep)
    found = (shutil.which(name, path=folder) for folder in folders)
    return next((path for path in found if path and os.path.realpath(path) != ours), None)


def relative(path):
    """Returns a path as seen from the clone, for messages."""
    return path[len(ROOT) + 1 :] if path.startswith(ROOT + os.sep) else path


def opened(path, flags):
    """Opens a file for open(): a pipe that nobody writes to is empty, and is not waited for."""
    return os.open(path, flags | os.O_NONBLOCK)


def read(path):
    """Returns a file's text; empty where there is no such file."""
    try:
        with open(path, encoding="utf-8", errors="surrogateescape", opener=opened) as stream:
            return stream.read()
    except FileNotFoundError:
        return ""


def tail(path, count=0):
    """Returns the last lines of a log; 0: all."""
    with open(path, encoding="utf-8", errors="replace") as stream:
        return stream.read().splitlines()[-count:]


def read_xml(path):
    """Returns an XML file's text without its comments; empty where there is no such file."""
    return re.sub(r"<!--.*?-->", "", read(path), flags=re.DOTALL)


def os_release(text=None):
    """Returns the fields of /etc/os-release, or of a text like it, as a dict."""
    text = read("/etc/os-release") if text is None else text
    return dict(re.findall(r"^(\w+)=[\"']?([^\"'\n]*)", text, re.MULTILINE))


def write(path, text):
    """Writes a file so that no reader ever sees half of it."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    part = f"{path}.{os.getpid()}.part"
    with open(part, "w", encoding="utf-8", errors="surrogateescape") as stream:
        stream.write(text)
    os.replace(part, path)

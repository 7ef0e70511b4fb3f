"""Where things are: the clone, what set-up makes in it, and the system's Python."""

import os
import re

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
SOURCES = os.path.join(ROOT, "src")
BUILD = os.path.join(ROOT, "build")
DEVEL = os.path.join(ROOT, "devel")
OUT = os.path.join(ROOT, "out")
CACHE = os.path.join(ROOT, ".cache")
LOGS = os.path.join(CACHE, "log")
VENV = os.path.join(ROOT, ".venv")
MODELS = os.path.join(CACHE, "gazebo_models")  # of Gazebo's database, by ./run add models
VENV_STAMP = os.path.join(VENV, ".stamp")  # base and requirements of a complete .venv, a line each
VENV_PYTHON = os.path.join(VENV, "bin", "python")
PYTHON = "/usr/bin/python3"
SYSTEM_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"


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


def read_xml(path):
    """Returns an XML file's text without its comments; empty where there is no such file."""
    return re.sub(r"<!--.*?-->", "", read(path), flags=re.DOTALL)


def write(path, text):
    """Writes a file so that no reader ever sees half of it."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    part = f"{path}.{os.getpid()}.part"
    with open(part, "w", encoding="utf-8", errors="surrogateescape") as stream:
        stream.write(text)
    os.replace(part, path)

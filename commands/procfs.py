"""Processes by their environment and command line, read from /proc with the standard library.

The supervisor uses it before anything is installed, the benchmark and the tests do, too. A process
that has ended, or is another user's, reads as nothing.
"""

import os
import time

STARTING = 0.1  # [s] longest wait for a process that is being started
POLL = 0.002  # [s]


def pids():
    """Lists the pids of all processes, ascending."""
    return sorted(int(entry) for entry in os.listdir("/proc") if entry.isdigit())


def arguments(pid):
    """Lists a process's command line; empty where it has ended."""
    return [os.fsdecode(word) for word in _read(pid, "cmdline")]


def environment(pid):
    """Returns the variables that a process was started with, as a dict."""
    pairs = (os.fsdecode(entry).partition("=") for entry in _environment(pid))
    return {name: value for name, _, value in pairs}


def marked(variable, value):
    """Lists the pids of this user's processes whose environment has a variable with a value."""
    entry = f"{variable}={value}".encode()
    return [pid for pid in pids() if entry in _environment(pid)]


def _environment(pid):
    """The variables of a process; of one that is being started once it has them.

    The kernel closes what is closed on exec, so that subprocess.Popen returns, before the new
    program's variables can be read: meanwhile there are none.
    """
    deadline = time.monotonic() + STARTING
    while not (entries := _read(pid, "environ")) and _has_program(pid):
        if time.monotonic() > deadline:  # it was started without variables
            break
        time.sleep(POLL)
    return entries


def _has_program(pid):
    """Whether it is a process of this user that runs a program: not a zombie, no kernel thread."""
    try:
        return bool(os.readlink(f"/proc/{pid}/exe"))
    except OSError:
        return False


def program(words):
    """Returns the name of a command line: its node, else its module, script or program.

    Args:
        words: As of arguments().

    Returns:
        Name without .py; empty where there are no words.
    """
    for word in words:
        if word.startswith("__name:="):
            return word.partition(":=")[2]
    if "-m" in words[:-1]:
        return words[words.index("-m") + 1].rpartition(".")[2]
    names = [os.path.basename(word) for word in words if not word.startswith("-")]
    scripts = [] if "-c" in words else [name for name in names if not name.startswith("python")]
    name = (scripts or names or [""])[0]
    return name[: -len(".py")] if name.endswith(".py") else name


def send(pid, number):
    """Sends a signal; says whether there was such a process."""
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        return False
    return True


def _read(pid, file):
    """The texts of a file of /proc/PID, each of which ends in a zero byte."""
    try:
        with open(f"/proc/{pid}/{file}", "rb") as stream:
            return stream.read().split(b"\0")[:-1]
    except OSError:
        return []

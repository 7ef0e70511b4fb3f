"""Launches without a display that end by themselves and leave a result: demo, lap, backing."""

import json
import os
import shutil
import socket
import subprocess

from commands import processes
from commands.errors import CommandError, UsageError, say
from commands.launching import supervisor
from commands.paths import CACHE, relative

UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}  # [s]


def run(name, launch, environ, arguments, deadline, out):
    """Runs a launch that leaves result.json, and tells how it went.

    Args:
        name: The command, for messages and the folder of its logs.
        launch: LaunchFile with an argument out_dir.
        environ: The activated environment; changed in place.
        arguments: NAME:=VALUE arguments, without out_dir.
        deadline: Longest run [s] as text, of deadline_from().
        out: Folder of the results.

    Raises:
        CommandError: It failed, came to no result, or to one that is not ok.
        Interrupted: A signal ended it.
    """
    os.makedirs(out, exist_ok=True)
    environ["ROS_LOG_DIR"] = os.path.join(CACHE, f"ros-{name}")
    environ["QT_QPA_PLATFORM"] = environ.get("QT_QPA_PLATFORM") or "offscreen"
    shutil.rmtree(environ["ROS_LOG_DIR"], ignore_errors=True)
    try:
        status = start(launch, environ, [f"out_dir:={out}", *arguments], deadline)
    except processes.DeadlineExceeded:
        _list(out)
        raise CommandError(
            f"the {name} did not end within {deadline} s", where_to_look(environ)
        ) from None
    _list(out)
    if status != 0:
        raise CommandError(f"roslaunch ended with exit status {status}", where_to_look(environ))
    ok = is_ok(os.path.join(out, "result.json"))
    if not ok:
        problem = "ended without result.json" if ok is None else "was not content"
        raise CommandError(f"the {name} {problem}", where_to_look(environ))
    say(f"{name}: ok")


def start(launch, environ, arguments, deadline):
    """Runs roslaunch to its end, on a master of its own.

    Args:
        launch: LaunchFile.
        environ: The activated environment; gets the master.
        arguments: NAME:=VALUE arguments.
        deadline: Longest run [s] as text, of deadline_from().

    Returns:
        roslaunch's exit status.

    Raises:
        processes.DeadlineExceeded: It did not end in time.
        Interrupted: A signal ended it.
    """
    options = use_own_master(environ)
    supervisor.start(environ)
    return processes.run_child(
        launch.command(arguments, *options),
        group=False,
        deadline=_seconds(deadline) or None,
        env=environ,
        stdin=subprocess.DEVNULL,
    )


def use_own_master(environ):
    """Makes an environment use a master on a free port of this machine, loopback only.

    Args:
        environ: Changed in place.

    Returns:
        The options with which roslaunch starts that master.

    Raises:
        CommandError: This machine has no 127.0.0.1, as one that has IPv6 alone.
    """
    with socket.socket() as probe:
        try:
            probe.bind(("127.0.0.1", 0))
        except OSError as error:
            raise CommandError(
                f"this machine has no address 127.0.0.1, which this command needs ({error})",
                "Give it one: ip address add 127.0.0.1/8 dev lo",
            ) from None
        port = probe.getsockname()[1]
    environ.pop("ROS_HOSTNAME", None)
    environ.update(ROS_IP="127.0.0.1", ROS_MASTER_URI=f"http://127.0.0.1:{port}")
    return "-p", str(port)


def is_ok(path):
    """Reads a result file's "ok".

    Returns:
        True or False; None where there is no result.
    """
    try:
        with open(path, encoding="utf-8") as stream:
            return json.load(stream)["ok"] is True
    except (OSError, ValueError):
        return None
    except (KeyError, TypeError):
        return False


def where_to_look(environ):
    """Returns the advice for a launch that went wrong."""
    return f"Its own words are above; logs in {relative(environ['ROS_LOG_DIR'])}/"


def deadline_from(variable, default):
    """Returns a deadline [s] as text, which a variable of the environment may change.

    Raises:
        UsageError: The variable's value is no time.
    """
    text = os.environ.get(variable) or str(default)
    try:
        valid = _seconds(text) >= 0
    except ValueError:
        valid = False
    if not valid:
        raise UsageError(f"{variable} is {text!r}; it must be a number of seconds, 0 for no limit")
    return text


def _seconds(text):
    """Reads a time as timeout(1) does: a number, with s, m, h or d behind it or not."""
    unit = UNITS.get(text[-1:])
    return float(text[:-1]) * unit if unit else float(text)


def _list(out):
    files = sorted(entry.name for entry in os.scandir(out) if entry.is_file())
    say(f"in {relative(out)}/: {' '.join(files)}")

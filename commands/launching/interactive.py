"""Launches in the caller's terminal, for which ./run becomes roslaunch: display, master."""

import glob
import os
import socket

from commands import processes
from commands.errors import CommandError
from commands.launching import supervisor
from commands.paths import OUT

PADS = "/dev/input/js*"
MASTER_TIMEOUT = 5.0  # for a master's response [s]


def become(launch, arguments, environ):
    """Becomes roslaunch, with a supervisor over what it leaves; does not come back.

    Args:
        launch: LaunchFile.
        arguments: NAME:=VALUE arguments and options of roslaunch, checked.
        environ: The activated environment.
    """
    supervisor.start(environ)
    processes.become(launch.command(arguments), environ)


def has_display(environ):
    """Returns whether there is a screen to open a window on."""
    return bool(environ.get("DISPLAY") or environ.get("WAYLAND_DISPLAY"))


def need_display(environ, instead):
    """Refuses to open a window where there is no screen.

    Args:
        environ: Its variables tell; QT_QPA_PLATFORM says that somebody knows what he does.
        instead: A command that needs none.

    Raises:
        CommandError: There is no screen.
    """
    if not has_display(environ) and not environ.get("QT_QPA_PLATFORM"):
        raise CommandError(
            "the window needs a display, and neither DISPLAY nor WAYLAND_DISPLAY is set",
            f"Without one: {instead}",
        )


def window_arguments(arguments, pads=PADS):
    """Returns launch arguments that the caller has not given.

    Args:
        arguments: NAME:=VALUE as they were given.
        pads: Pattern of the device files of game pads.

    Returns:
        List: recordings go to out/recordings/, the driver of a pad that is plugged in is started.
    """
    wanted = {"record_dir": os.path.join(OUT, "recordings")}
    if glob.glob(pads):
        wanted["pad"] = "true"
    given = {argument.partition(":=")[0] for argument in arguments}
    return [f"{name}:={value}" for name, value in wanted.items() if name not in given]


def refuse_second_world(environ):
    """Refuses where a simulator runs: a second node /gazebo would end the first.

    Raises:
        CommandError: The environment's master knows a node /gazebo.
    """
    uri = environ["ROS_MASTER_URI"]
    host, _, port = uri.partition("://")[2].split("/")[0].rpartition(":")
    try:
        socket.create_connection((host.strip("[]"), int(port)), MASTER_TIMEOUT).close()
    except (OSError, ValueError):
        return  # no master yet; roslaunch starts one, or says what is wrong with the address
    if _knows_simulator(uri):
        raise CommandError(
            f"a simulator runs already on {uri}",
            "Stop it, or give this one its own master:",
            "ROS_MASTER_URI=http://localhost:11312 ./run ...",
        )


def _knows_simulator(uri):
    from http.client import HTTPException
    from xml.parsers.expat import ExpatError
    from xmlrpc.client import Error, ServerProxy

    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(MASTER_TIMEOUT)
    try:
        with ServerProxy(uri) as master:
            return master.lookupNode("/paddock", "/gazebo")[0] == 1
    except (OSError, HTTPException, Error, ExpatError):
        return False  # something else listens there, or it does not answer
    finally:
        socket.setdefaulttimeout(before)

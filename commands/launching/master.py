"""The ROS master: one of our own on a free port, or the caller's without a second simulator."""

import socket

from commands.errors import CommandError

PATIENCE = 5.0  # for a master's answer [s]


def use_own(environ):
    """Lets an environment use a master on a free port of this machine, loopback only.

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


def refuse_second_world(environ):
    """Refuses where a simulator runs: a second node /gazebo would end the first.

    Raises:
        CommandError: The environment's master knows a node /gazebo.
    """
    uri = environ["ROS_MASTER_URI"]
    host, _, port = uri.partition("://")[2].split("/")[0].rpartition(":")
    try:
        socket.create_connection((host.strip("[]"), int(port)), PATIENCE).close()
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
    socket.setdefaulttimeout(PATIENCE)
    try:
        with ServerProxy(uri) as master:
            return master.lookupNode("/paddock", "/gazebo")[0] == 1
    except (OSError, HTTPException, Error, ExpatError):
        return False  # something else listens there, or it does not answer
    finally:
        socket.setdefaulttimeout(before)

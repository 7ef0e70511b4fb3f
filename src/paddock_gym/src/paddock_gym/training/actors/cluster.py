"""Ray: a cluster of this machine alone, or one of several."""

import logging
import os
import socket

import ray
from ray._private import ray_constants

from paddock_gym.errors import GymError

AUTO = "auto"
ATTEMPTS = 3  # to start on a busy machine
PATIENCE = 10.0  # [s] for a head to take a connection
SILENT = {"RAY_USAGE_STATS_ENABLED": "0"}


def connect(address, say=print):
    """Join a cluster.

    Args:
        address: HOST:PORT of its head, or auto: the one that this machine belongs to; without one,
            a cluster of this machine alone is started and ends with this process.
        say: function of one line.

    Returns:
        Processors of each node.

    Raises:
        GymError: there is no such cluster.
    """
    os.environ.update(SILENT)
    if address != AUTO:
        _check_listens(address)
    common = {"log_to_driver": False, "logging_level": logging.ERROR}
    try:
        ray.init(address=address, **common)
    except ConnectionError as error:
        if address != AUTO:
            raise _wrong(address, error) from error
        _start_here(common)
    except (ValueError, RuntimeError) as error:
        raise _wrong(address, error) from error
    nodes = [node["Resources"].get("CPU", 0.0) for node in ray.nodes() if node["Alive"]]
    if not sum(nodes):
        raise GymError(f"the Ray cluster {address} offers no processors; it must have one or more")
    words = "1 node" if len(nodes) == 1 else f"{len(nodes)} nodes"
    say(f"train: Ray with {words}, {sum(nodes):g} processors")
    return nodes


def _check_listens(address):
    """Raise GymError where nobody listens; Ray itself would try again for minutes."""
    host, _, port = address.rpartition(":")
    try:
        socket.create_connection((host.strip("[]"), int(port)), PATIENCE).close()
    except (OSError, ValueError, OverflowError) as error:
        raise _wrong(address, error) from error


def _start_here(common):
    """Start a cluster of this machine alone, on loopback and not on the machine's address."""
    os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"  # read by Ray's processes as they start
    ray_constants.ENABLE_RAY_CLUSTER = False  # what this process made of it
    for attempt in range(ATTEMPTS):
        try:
            ray.init(address="local", include_dashboard=False, **common)
            return
        except Exception as error:  # Ray gives itself 30 s and raises a plain Exception
            ray.shutdown()
            if "timed out" not in str(error) or attempt == ATTEMPTS - 1:
                reason = str(error).strip().split("\n")[0]
                raise GymError(f"Ray did not start on this machine: {reason}") from error


def _wrong(address, error):
    reason = str(error).strip().split("\n")[0]
    return GymError(
        f"ray is {address!r}; it must be auto, or HOST:PORT of the head of a cluster that this "
        f"machine has joined by ./run cluster ({reason})"
    )


def share_of(nodes, count):
    """The share of a processor for each of some actors, so that all find a place.

    Args:
        nodes: processors of each node.
        count: of actors.
    """
    share = min(1.0, sum(nodes) / count)
    while sum(int(processors / share) for processors in nodes) < count:
        share *= 0.95
    return int(share * 1000) / 1000

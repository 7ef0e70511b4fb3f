"""What one ./run of this machine has at a time: a folder that it fills, a world on a master.

A name is a Unix socket of the abstract kind: it leaves no file, works between clones and in folders
that cannot be written, and is free again when its last holder has ended, however that came.
"""

import hashlib
import os
import socket

from commands.errors import CommandError
from commands.paths import relative

_held = []


def take(name):
    """Takes a name until this process, the program that it becomes, and who gets held() have ended.

    Args:
        name: Any text.

    Returns:
        Whether it was free.
    """
    sign = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        sign.bind(f"\0paddock-{hashlib.sha256(os.fsencode(name)).hexdigest()}")
    except OSError:
        sign.close()
        return False
    sign.set_inheritable(True)
    _held.append(sign)
    return True


def take_results(path):
    """Takes a folder of results, or the beginning of a file's name.

    Raises:
        CommandError: Another ./run writes there.
    """
    if not take(os.path.realpath(path)):
        raise CommandError(
            f"another ./run is writing to {relative(path)}", "Start this one when that has ended."
        )


def listen(asked, ports, address="127.0.0.1"):
    """Opens a port.

    Args:
        asked: Its number; None for the first free one of some.
        ports: A range of numbers.

    Returns:
        Listening socket.

    Raises:
        CommandError: There is none.
    """
    for number in ports if asked is None else [asked]:
        server = socket.socket()
        server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            server.bind((address, number))
        except OSError as error:
            server.close()
            problem = error.strerror
            continue
        server.listen(100)
        return server
    asked = f"{ports[0]} to {ports[-1]}" if asked is None else asked
    raise CommandError(f"cannot listen on port {asked}: {problem}", "--port NUMBER takes another")


def held():
    """File descriptors of the names, for pass_fds."""
    return tuple(sign.fileno() for sign in _held)

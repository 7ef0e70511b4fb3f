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


def held():
    """File descriptors of the names, for pass_fds."""
    return tuple(sign.fileno() for sign in _held)

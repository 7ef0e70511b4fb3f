"""Ports for masters that a test starts itself."""

import random
import socket

FIRST, LAST = 20000, 32000  # below those that the kernel gives to whoever asks for any port


def free_port():
    """Returns an unused TCP port outside the range that the kernel assigns."""
    for port in random.sample(range(FIRST, LAST), 100):
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port
    raise OSError(f"no free port found between {FIRST} and {LAST}")

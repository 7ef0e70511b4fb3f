"""The limit of open files of a process, often 1024, which every connection counts against. No ROS.

The soft limit is raised when a node starts. Connections are refused before the limit is reached, so
that the rest of the node still opens its files, and the log says which limit it is.
"""

from __future__ import annotations

import errno
import logging
import resource
import socket
import time

MAX_FILES = 1 << 16  # to which the soft limit is raised
RESERVED = 64  # that connections leave to the rest of the node
REPORT_PERIOD = 10.0  # [s] between two lines in the log
PAUSE = 0.05  # [s] after accept() has failed
EXHAUSTED = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)  # what accept() may lack
_next_report = 0.0


def raise_limit() -> None:
    """Raises the soft limit of this process, to at most MAX_FILES."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MAX_FILES if hard == resource.RLIM_INFINITY else min(hard, MAX_FILES)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def is_room_for(sock: socket.socket, reserved: int = RESERVED) -> bool:
    """Whether a new connection leaves the process files to open; logs the limit where not."""
    limit, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if limit == resource.RLIM_INFINITY or sock.fileno() < limit - reserved:
        return True
    report()
    return False


def report() -> None:
    """Logs, now and then, that the limit is reached."""
    global _next_report
    now = time.monotonic()
    if now >= _next_report:
        _next_report = now + REPORT_PERIOD
        logging.getLogger("rosout").warning(
            "connections are refused: this process may have %d open files (ulimit -n), nearly all "
            "are open",
            resource.getrlimit(resource.RLIMIT_NOFILE)[0],
        )


class Listening(socket.socket):
    """A listening socket that accepts no connection for which there is no room."""

    def accept(self) -> tuple[socket.socket, object]:
        """As of socket.

        Raises:
            BlockingIOError: nobody is there, or there is no room.
        """
        try:
            sock, address = super().accept()
        except OSError as error:
            if error.errno not in EXHAUSTED:
                raise
            report()
            time.sleep(PAUSE)  # whoever waits for the socket tries again at once
            raise BlockingIOError(error.errno, error.strerror) from error
        if not is_room_for(sock):
            sock.close()
            raise BlockingIOError(errno.EMFILE, "too many open files")
        return sock, address

"""The lock of set-up: one ./run at a time, the others wait.

What a step starts has the lock, too: where a killed ./run leaves pip or a build, the next one waits
for their end in place of working beside them.
"""

import errno
import fcntl
import os
import sys

from commands.errors import CommandError
from commands.paths import CACHE

PATH = os.path.join(CACHE, "lock")  # ./run takes it, too, while there is no python3
LONGEST = 1800.0  # [s]
SILENT = 2.0  # before it says that it waits: a ./run that finds all ready is through by then [s]
POLL = 0.05  # [s]

_held = []


def held():
    """File descriptors of the lock, for pass_fds of what a step starts."""
    return tuple(_held)


class SetupLock:
    """Holds the lock within a with statement; children inherit it by pass_fds=held() alone."""

    def __enter__(self):
        self._file = os.open(PATH, os.O_RDWR | os.O_CREAT, 0o666)
        if not self._taken():
            self._wait()
        _held.append(self._file)
        return self

    def __exit__(self, *_):
        _held.remove(self._file)
        os.close(self._file)

    def _wait(self):
        import time

        begin, said = time.monotonic(), False
        while not self._taken():
            waited = time.monotonic() - begin
            if waited > SILENT and not said:
                # Not to stdout, which belongs to the command: ./run exec COMMAND | ...
                print("another ./run is setting up, waiting for it", file=sys.stderr, flush=True)
                said = True
            if waited > LONGEST:
                raise CommandError(
                    "another ./run has been setting up for half an hour",
                    "Look for it with: ps x | grep run",
                )
            time.sleep(POLL)

    def _taken(self):
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno not in (errno.EAGAIN, errno.EACCES):
                raise
            return False
        return True

"""The lock of set-up: one ./run at a time, the others wait."""

import errno
import fcntl
import os

from commands.errors import CommandError, say
from commands.paths import CACHE

PATH = os.path.join(CACHE, "lock")  # ./run takes it, too, while there is no python3
LONGEST = 1800.0  # [s]
POLL = 0.2  # [s]


class SetupLock:
    """Holds the lock within a with statement; children do not inherit it."""

    def __enter__(self):
        self._file = os.open(PATH, os.O_RDWR | os.O_CREAT, 0o666)
        if not self._taken():
            say("another ./run is setting up, waiting for it")
            self._wait()
        return self

    def __exit__(self, *_):
        os.close(self._file)

    def _wait(self):
        import time

        end = time.monotonic() + LONGEST
        while not self._taken():
            if time.monotonic() > end:
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

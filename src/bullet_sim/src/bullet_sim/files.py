"""Files and folders: names that are free, folders of a process, output of compiled code.

Temporary folders whose owner is known: what a killed process has left goes with the next start. A
folder's owner holds a lock (flock) on it, which the kernel drops when the process ends in any way.
A folder of this kind without a lock has no owner any more.
"""

import contextlib
import fcntl
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator

from bullet_sim.errors import ModelError

MAX_TEXT = 20_000_000  # [bytes] of an SDF or of a world; reading takes some 20 times as much memory


def read_file(path: str, label: str, most: int) -> bytes:
    """All bytes of a file.

    Args:
        path: of the file; pipes and devices, which may be endless or silent, are none.
        label: for messages, e.g. "mesh".
        most: bytes that it may have.

    Raises:
        ModelError: it is no file, is too long or cannot be read; names it.
    """
    if os.path.exists(path) and not os.path.isfile(path):
        raise ModelError(f"{label} '{path}' is no file")
    try:
        size = os.path.getsize(path)
        if size > most:
            raise ModelError(f"{label} '{path}' has {size} bytes, must have at most {most}")
        with open(path, "rb") as file:
            content = file.read(size + 1)
    except OSError as error:
        raise ModelError(f"{label} '{path}' cannot be read: {error.strerror}") from error
    if len(content) > size:  # as of files in /proc, whose size is 0
        raise ModelError(f"{label} '{path}' has more than the {size} bytes that it says to have")
    return content


PREFIX = "bullet_sim_world_"
NEW = "bullet_sim_new_"  # until it is locked

_cleaned: set[str] = set()  # directories that this process has cleaned up


class OwnFolder:
    """A temporary folder that lives no longer than this process.

    Args:
        parent: Directory that it lies in; None: that of temporary files.

    Attributes:
        path: Of it.

    Raises:
        OSError: It cannot be made.
    """

    def __init__(self, parent: str | None = None) -> None:
        parent = parent or tempfile.gettempdir()
        if parent not in _cleaned:
            _cleaned.add(parent)
            remove_ownerless(parent)
        made = tempfile.mkdtemp(prefix=NEW, dir=parent)
        self._lock = os.open(made, os.O_RDONLY | os.O_DIRECTORY)
        fcntl.flock(self._lock, fcntl.LOCK_EX)
        self.path = os.path.join(parent, PREFIX + os.path.basename(made)[len(NEW) :])
        os.rename(made, self.path)  # others see it locked from the beginning

    def close(self) -> None:
        """Removes it."""
        shutil.rmtree(self.path, ignore_errors=True)
        if self._lock >= 0:
            os.close(self._lock)
        self._lock = -1


def remove_ownerless(parent: str) -> list[str]:
    """Removes this user's folders whose owner has ended without doing so.

    Args:
        parent: Directory to look in.

    Returns:
        Names of those that were removed.
    """
    removed: list[str] = []
    try:
        entries = [entry for entry in os.scandir(parent) if entry.name.startswith(PREFIX)]
    except OSError:
        return removed
    for entry in entries:
        try:
            if entry.stat(follow_symlinks=False).st_uid != os.getuid():
                continue
            folder = os.open(entry.path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        except OSError:  # no folder, or another process was quicker
            continue
        try:
            fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            continue  # its owner lives
        else:
            shutil.rmtree(entry.path, ignore_errors=True)
            removed.append(entry.name)
        finally:
            os.close(folder)
    return sorted(removed)


def keep_python_output() -> None:
    """Give sys.stdout and sys.stderr own file descriptors, which silenced() does not redirect.

    Otherwise the output of other threads is lost while a library is silenced. To be called once,
    before other modules store these streams.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        stream.flush()
        setattr(
            sys,
            name,
            os.fdopen(
                os.dup(stream.fileno()),
                "w",
                buffering=1,
                encoding=stream.encoding,
                errors=stream.errors,
            ),
        )


@contextlib.contextmanager
def silenced() -> Iterator[None]:
    """Redirect file descriptors 1 and 2 to /dev/null within the context."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = [(fd, os.dup(fd)) for fd in (1, 2)]
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        for fd, _ in saved:
            os.dup2(null, fd)
        yield
    finally:
        for fd, copy in saved:
            os.dup2(copy, fd)
            os.close(copy)
        os.close(null)

"""Files and folders: reading with a size limit, temporary folders, output of compiled code.

A process holds a lock (flock) on its temporary folder, which the kernel releases when the process
exits in any way. A folder without a lock was left by a killed process; the next start removes it.
"""

from __future__ import annotations

import bz2
import contextlib
import fcntl
import gzip
import io
import lzma
import os
import shutil
import stat
import sys
import tempfile
import threading
import zlib
from collections.abc import Iterator
from typing import Any

from bullet_sim.errors import ModelError

# What files that a description, a world or a parameter names have at most: meshes and images; texts
# such as an SDF, of which parsing takes some 20 times as much memory; a livox's pattern, also
# unpacked; an image. Environment variables set others: PADDOCK_MAX_MESH_BYTES ...
LIMITS = {
    "mesh_bytes": 400_000_000,
    "text_bytes": 20_000_000,
    "pattern_bytes": 64_000_000,
    "image_pixels": 8192 * 8192,
}


def limit(name: str) -> int:
    """One of LIMITS, or what the environment sets."""
    return int(os.environ.get(variable_of(name)) or LIMITS[name])


def variable_of(name: str) -> str:
    """The environment variable of one of LIMITS, for this process and those that it starts."""
    return f"PADDOCK_MAX_{name.upper()}"


def too_many(name: str) -> str:
    """What messages say of one of LIMITS."""
    return f"must have at most {limit(name)} ({variable_of(name)})"


def read_file(path: str, label: str, kind: str) -> bytes:
    """All bytes of a file that a description, a world or a parameter names.

    Args:
        path: of a regular file on this machine; pipes and devices are refused, as they may be
            endless or block.
        kind: which of LIMITS holds.

    Raises:
        ModelError: it is no regular file, is too long or cannot be read; names the file.
    """
    try:
        # a pipe without a writer would block
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise ModelError(f"{label} '{path}' is no file")
            if status.st_size > limit(kind):
                raise ModelError(f"{label} '{path}' has {status.st_size} bytes, {too_many(kind)}")
            content = file.read(status.st_size + 1)
    except IsADirectoryError:
        raise ModelError(f"{label} '{path}' is no file") from None
    except (OSError, ValueError) as error:  # ValueError: a zero byte in its name
        reason = getattr(error, "strerror", None) or error
        raise ModelError(f"{label} '{path}' cannot be read: {reason}") from error
    if len(content) > status.st_size:  # as of files in /proc, whose size is 0
        raise ModelError(
            f"{label} '{path}' has more than the {status.st_size} bytes that its size reports"
        )
    return content


_UNPACKERS: dict[str, Any] = {".gz": gzip.open, ".bz2": bz2.open, ".xz": lzma.open}


def read_unpacked(path: str, label: str, kind: str) -> bytes:
    """As read_file(), of a file that may be packed (.gz, .bz2, .xz): the limit is for both."""
    content = read_file(path, label, kind)
    unpack = _UNPACKERS.get(os.path.splitext(path)[1])
    if unpack is None:
        return content
    try:
        with unpack(io.BytesIO(content)) as file:
            content = file.read(limit(kind) + 1)
    except (OSError, EOFError, lzma.LZMAError, zlib.error) as error:
        raise ModelError(f"{label} '{path}' cannot be unpacked: {error}") from error
    if len(content) > limit(kind):
        raise ModelError(f"{label} '{path}' has more bytes unpacked, {too_many(kind)}")
    return content


PREFIX = "bullet_sim_world_"
NEW = "bullet_sim_new_"  # until it is locked

_cleaned: set[str] = set()  # directories that this process has cleaned up


class OwnFolder:
    """A temporary folder that is removed with this process at the latest.

    Args:
        parent: directory that contains it; None: the system's directory of temporary files.

    Raises:
        OSError: it cannot be created.
    """

    def __init__(self, parent: str | None = None) -> None:
        parent = parent or tempfile.gettempdir()
        if parent not in _cleaned:
            _cleaned.add(parent)
            remove_ownerless(parent)
        created = tempfile.mkdtemp(prefix=NEW, dir=parent)
        self._lock = os.open(created, os.O_RDONLY | os.O_DIRECTORY)
        fcntl.flock(self._lock, fcntl.LOCK_EX)
        self.path = os.path.join(parent, PREFIX + os.path.basename(created)[len(NEW) :])
        os.rename(created, self.path)  # other processes see it only when it is locked

    def close(self) -> None:
        """Remove the folder."""
        shutil.rmtree(self.path, ignore_errors=True)
        if self._lock >= 0:
            os.close(self._lock)
        self._lock = -1


def remove_ownerless(parent: str) -> list[str]:
    """Remove this user's folders whose process has exited without doing so.

    Returns:
        Names of the removed folders, sorted.
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
        except OSError:  # no folder, or another process has removed it
            continue
        try:
            fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            continue  # its process is alive
        else:
            shutil.rmtree(entry.path, ignore_errors=True)
            removed.append(entry.name)
        finally:
            os.close(folder)
    return sorted(removed)


def keep_python_output() -> None:
    """Give sys.stdout and sys.stderr separate file descriptors, which silenced() does not redirect.

    Otherwise the output of other threads is dropped while a library is silenced. To be called once,
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


_silence = threading.Lock()  # guards:
_silent = 0  # contexts of silenced(), of any thread
_restored: list[tuple[int, int]] = []  # file descriptors, and copies of what they were


@contextlib.contextmanager
def silenced() -> Iterator[None]:
    """Redirect file descriptors 1 and 2 to /dev/null within the context, of several threads until
    the last one leaves it."""
    global _silent
    with _silence:
        if not _silent:
            sys.stdout.flush()
            sys.stderr.flush()
            _restored[:] = [(fd, os.dup(fd)) for fd in (1, 2)]
            null = os.open(os.devnull, os.O_WRONLY)
            for fd, _ in _restored:
                os.dup2(null, fd)
            os.close(null)
        _silent += 1
    try:
        yield
    finally:
        with _silence:
            _silent -= 1
            if not _silent:
                for fd, copy in _restored:
                    os.dup2(copy, fd)
                    os.close(copy)

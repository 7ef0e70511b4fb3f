"""Temporary folders whose owner is known: what a killed process has left goes with the next start.

A folder's owner holds a lock (flock) on it, which the kernel drops when the process ends in any
way. A folder of this kind without a lock has no owner any more.
"""

import fcntl
import os
import shutil
import tempfile

PREFIX = "bullet_sim_world_"
NEW = "bullet_sim_new_"  # until it is locked

_cleaned = set()  # directories that this process has cleaned up


class OwnFolder:
    """A temporary folder that lives no longer than this process.

    Args:
        parent: Directory that it lies in; None: that of temporary files.

    Attributes:
        path: Of it.

    Raises:
        OSError: It cannot be made.
    """

    def __init__(self, parent=None):
        parent = parent or tempfile.gettempdir()
        if parent not in _cleaned:
            _cleaned.add(parent)
            remove_ownerless(parent)
        made = tempfile.mkdtemp(prefix=NEW, dir=parent)
        self._lock = os.open(made, os.O_RDONLY | os.O_DIRECTORY)
        fcntl.flock(self._lock, fcntl.LOCK_EX)
        self.path = os.path.join(parent, PREFIX + os.path.basename(made)[len(NEW) :])
        os.rename(made, self.path)  # others see it locked from the beginning

    def close(self):
        """Removes it."""
        shutil.rmtree(self.path, ignore_errors=True)
        if self._lock >= 0:
            os.close(self._lock)
        self._lock = -1


def remove_ownerless(parent):
    """Removes this user's folders whose owner has ended without doing so.

    Args:
        parent: Directory to look in.

    Returns:
        Names of those that were removed.
    """
    removed = []
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

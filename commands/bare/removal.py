"""The end of a bare machine: its processes, its mounts, its folder."""

import glob
import os
import re
import signal
import subprocess
import time

from commands.errors import CommandError

REMOVAL_LIMIT = 20.0  # longest wait for processes to end and for files to be gone [s]
REMOVAL_POLL = 0.1  # [s]


def remove(folder):
    """Removes a machine.

    Args:
        folder: Absolute, without links.

    Raises:
        CommandError: Something of it cannot be removed.
    """
    end = time.monotonic() + REMOVAL_LIMIT
    said = _ended(folder)
    while os.path.lexists(folder):
        if mounts_below(folder):
            said = f"mounted there: {', '.join(mounts_below(folder))}"
        else:
            # Not across file systems, and in a session of its own: a Ctrl-C is not for it.
            rm = ["rm", "-rf", "--one-file-system", "--", folder]
            done = subprocess.run(rm, capture_output=True, text=True, start_new_session=True)
            said = done.stderr.strip().partition("\n")[0]
        if not os.path.lexists(folder):
            return
        if time.monotonic() > end:
            raise CommandError(
                f"the bare machine's folder {folder} cannot be removed: {said}",
                "What is mounted there has to be unmounted first; then: rm -rf --one-file-system",
            )
        time.sleep(REMOVAL_POLL)  # a killed process may still be ending
        _ended(folder)


def mounts_below(folder):
    """Lists what is mounted at or below a folder, the innermost first."""
    found = []
    with open("/proc/self/mountinfo", encoding="utf-8", errors="surrogateescape") as stream:
        for line in stream:
            path = re.sub(r"\\([0-7]{3})", lambda code: chr(int(code[1], 8)), line.split()[4])
            if path == folder or path.startswith(folder + os.sep):
                found.append(path)
    return found[::-1]


def _ended(folder):
    """Kills the processes that have their root in a folder and drops its mounts; gives ""."""
    for link in glob.glob("/proc/[0-9]*/root"):
        try:
            inside = f"{os.readlink(link)}/".startswith(folder + os.sep)
            if inside:
                os.kill(int(link.split(os.sep)[2]), signal.SIGKILL)
        except OSError:
            continue  # it has ended
    for path in mounts_below(folder):
        subprocess.run(["umount", "-l", path], stderr=subprocess.DEVNULL)
    return ""

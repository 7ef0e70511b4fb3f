"""ROS logs of ./run: old ones go, as roslaunch measures them all at each start."""

import os
import time

from commands.paths import CACHE

FOLDER = os.path.join(CACHE, "ros")
KEPT = 7 * 86400.0  # [s]


def clean_up(now=None):
    """Deletes logs that are older than a week.

    Args:
        now: Time of the clean-up [s since 1970]; None for the present.
    """
    oldest = (time.time() if now is None else now) - KEPT
    try:
        entries = list(os.scandir(FOLDER))
    except FileNotFoundError:
        return
    for entry in entries:
        try:
            if entry.stat(follow_symlinks=False).st_mtime >= oldest:
                continue
            if entry.is_dir(follow_symlinks=False):
                import shutil

                shutil.rmtree(entry.path, ignore_errors=True)
            else:
                os.remove(entry.path)
        except OSError:
            continue  # another ./run was quicker, or it belongs to somebody else

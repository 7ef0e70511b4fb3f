"""The folder that a run's files go into, and its result.json."""

import json
import os

import cv2

RESULT = "result.json"


def prepare(folder, files):
    """Makes the folder and removes the files of an earlier run.

    Args:
        folder: Path.
        files: Names of the run's files; result.json is always one of them.

    Raises:
        OSError: The folder cannot be made or written.
    """
    os.makedirs(folder, exist_ok=True)
    for name in (*files, RESULT):
        if os.path.exists(os.path.join(folder, name)):
            os.remove(os.path.join(folder, name))


def write_picture(folder, name, picture):
    """Writes a picture.

    Args:
        folder, name: Where to.
        picture: (H, W, 3) uint8 BGR, or None: there is none.

    Raises:
        OSError: There is none, or it cannot be written.
    """
    path = os.path.join(folder, name)
    if picture is None or not cv2.imwrite(path, picture):
        raise OSError(f"cannot write {path}")


def write_result(folder, result):
    """Writes a dict as result.json."""
    with open(os.path.join(folder, RESULT), "w", encoding="utf-8") as stream:
        json.dump(result, stream, indent=2)
        stream.write("\n")

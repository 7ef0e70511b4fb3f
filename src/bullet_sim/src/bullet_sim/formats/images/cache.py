"""Drawn images, each drawn once and kept in the user's cache folder."""

import functools
import hashlib
import os
import tempfile
from pathlib import Path

from bullet_sim.description.model import RGB


def folder() -> str:
    """The folder of drawn images: ${XDG_CACHE_HOME:-~/.cache}/paddock/textures."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    # The XDG base directory specification: relative paths are to be ignored.
    if not os.path.isabs(base):
        base = os.path.join(os.path.expanduser("~"), ".cache")
    return os.path.join(base, "paddock", "textures")


@functools.lru_cache(maxsize=None)
def _version(mean: RGB) -> str:
    """Of the code that draws and of its argument, so that another version draws anew."""
    sources = sorted(Path(__file__).parent.glob("*.py"))
    content = b"".join(path.read_bytes() for path in sources) + repr(mean).encode()
    return hashlib.sha256(content).hexdigest()[:12]


def image_of(name: str, mean: RGB) -> str:
    """Path of the image of Gazebo/NAME, which is drawn if it is not there; '': it cannot be kept.

    Args:
        mean: its mean color.
    """
    try:
        path = os.path.join(folder(), f"{name}-{_version(mean)}.png")
        if not os.path.isfile(path):
            _write(path, name, mean)
    except OSError:
        return ""
    return path


def _write(path: str, name: str, mean: RGB) -> None:
    """Draw an image and rename it to its path, so that no process sees half of it."""
    from bullet_sim.formats.images.drawings import png  # with numpy and OpenCV, seldom needed

    parent = os.path.dirname(path)
    os.makedirs(parent, exist_ok=True)
    handle, temporary = tempfile.mkstemp(prefix=".making-", dir=parent)
    try:
        with open(handle, "wb") as file:
            file.write(png(name, mean))
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise

"""The files of the page: those of this package, and three.js of Debian."""

from __future__ import annotations

import mimetypes
from pathlib import Path

import rospkg

from bullet_web.server import File

THREE = Path("/usr/share/javascript/three")
LIBRARIES = {  # name on the page -> file of Debian's libjs-three
    "three.min.js": THREE / "three.min.js",
    "OrbitControls.js": THREE / "examples" / "js" / "controls" / "OrbitControls.js",
}
LIVE = ("index.html", "page.css", "world.js", "panels.js", "drive.js", "live.js")
REPLAY = ("index.html", "page.css", "world.js", "panels.js", "replay.js")


def folder() -> Path:
    """Where this package's files are, in a source or an install space."""
    return Path(rospkg.RosPack().get_path("bullet_web")) / "www"


def read(names: tuple[str, ...]) -> dict[str, File]:
    """Files of this package and the libraries, by their names on the page.

    Raises:
        OSError: one cannot be read; the message says what brings it.
    """
    base = folder()
    paths = {**{name: base / name for name in names}, **LIBRARIES}
    return {name: File(_type(name), _data(path)) for name, path in paths.items()}


def _data(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        hint = "; Debian's package libjs-three brings it" if THREE in path.parents else ""
        raise OSError(f"{path} cannot be read: {error.strerror}{hint}") from error


def _type(name: str) -> str:
    kind = mimetypes.guess_type(name)[0] or "application/octet-stream"
    return f"{kind}; charset=utf-8" if kind.startswith("text/") else kind

"""Cache of generated tracks: one folder per content hash, written atomically; imports no numpy."""

from __future__ import annotations

import hashlib
import os
import pathlib
import shutil
import tempfile

from track_model import source

FILES = ("track.png", "track.obj", "track.mtl", "track.sdf", "track.world", "preview.png")
GENERATORS = (
    "spec.py",
    "track_file.py",
    "source.py",
    "routes.py",
    "curves.py",
    "geometry.py",
    "region.py",
    "files/writer.py",
)


def root() -> str:
    """Return the cache's folder: ${XDG_CACHE_HOME:-~/.cache}/paddock/tracks."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    # The XDG base directory specification: relative paths are to be ignored.
    if not os.path.isabs(base):
        base = os.path.join(os.path.expanduser("~"), ".cache")
    return os.path.join(base, "paddock", "tracks")


def key(path: str, content: bytes) -> str:
    """Return a track's folder name: stem and hash over its file and the generator's source."""
    digest = hashlib.sha256(content)
    package = pathlib.Path(__file__).resolve().parents[1]
    for name in GENERATORS:
        digest.update((package / name).read_bytes())
    stem = os.path.splitext(os.path.basename(path))[0]
    safe = "".join(c if c.isascii() and c.isalnum() or c in "-_" else "_" for c in stem)
    return f"{safe[:40]}-{digest.hexdigest()[:20]}"


def _complete(directory: str) -> bool:
    try:
        if not all(os.path.getsize(os.path.join(directory, name)) for name in FILES):
            return False
        with open(os.path.join(directory, "track.sdf"), encoding="utf-8") as stream:
            # After a move of the cache the URIs contain the old path.
            return pathlib.Path(directory, "track.obj").as_uri() in stream.read()
    except OSError:
        return False


def _generate(path: str, content: bytes, parent: str, final: str) -> str:
    """Write the files to a new folder next to the final one; return the new one."""
    os.makedirs(parent, exist_ok=True)
    parsed = source.load(path, content)
    from track_model.files import writer as files

    temporary = tempfile.mkdtemp(prefix=".making-", dir=parent)
    try:
        files.write(parsed, temporary, final)
        os.chmod(temporary, 0o755)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    return temporary


def ensure(path: str) -> str:
    """Return the folder with a track's files, generating them if they do not exist.

    Raises:
        TrackError: The file is not valid.
        OSError: The cache cannot be written.
    """
    content = source.read(path)
    final = os.path.join(root(), key(path, content))
    if _complete(final):
        return final
    temporary = _generate(path, content, root(), final)
    try:
        for _ in range(2):
            try:
                os.rename(temporary, final)
                return final
            except OSError:
                # Another process was faster, or a broken folder exists.
                if _complete(final):
                    return final
                if not os.path.isdir(final):
                    raise
                shutil.rmtree(final)
        raise OSError(f"cannot replace {final}")
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def export(path: str, directory: str) -> list[str]:
    """Write a track's files into the user's folder (file by file); return their paths."""
    final = os.path.abspath(directory)
    os.makedirs(final, exist_ok=True)
    temporary = _generate(path, source.read(path), final, final)
    try:
        for name in FILES:
            os.replace(os.path.join(temporary, name), os.path.join(final, name))
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return [os.path.join(final, name) for name in FILES]

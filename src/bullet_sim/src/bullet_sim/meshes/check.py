"""Format of a mesh file, and whether PyBullet reads it correctly."""

import functools
import os
import re
import struct

import numpy as np

_BAD_NUMBER = re.compile(rb"^\s*v[nt]?\s[^\n]*(?:nan|inf)", re.MULTILINE | re.IGNORECASE)
_VERTEX = re.compile(rb"^\s*v\s", re.MULTILINE)
_FACE = re.compile(rb"^\s*f\s+([^\n]*)$", re.MULTILINE)
_MATERIAL = re.compile(rb"^\s*usemtl\s+(\S+)", re.MULTILINE)
_LIBRARY = re.compile(rb"^\s*mtllib\s+(.+?)\s*$", re.MULTILINE)
_PICTURE = re.compile(r"^\s*map_Kd\s+(.+?)\s*$", re.MULTILINE)


def kind_of(path, data):
    """'obj', 'stl' (binary), 'ascii stl' or 'dae'."""
    ending = os.path.splitext(path)[1].lower()
    if ending == ".stl":
        return "stl" if _stl_count(data) is not None else "ascii stl"
    return ending[1:]


def _stl_count(data):
    """Number of triangles of a binary STL, or None when it is none."""
    if len(data) < 84:
        return None
    (count,) = struct.unpack_from("<I", data, 80)
    return (
        count
        if len(data) >= 84 + 50 * count and not (data[:5] == b"solid" and b"facet" in data[:500])
        else None
    )


def fault(path, kind, data):
    """Reason why PyBullet must not read a file, or ''; DAE and ASCII STL are checked later."""
    if not data:
        return f"mesh '{path}' is empty"
    if kind == "stl":
        return _stl_fault(path, data)
    return _obj_fault(path, data) if kind == "obj" else ""


def _stl_fault(path, data):
    count = _stl_count(data)
    if not count:
        return f"mesh '{path}' has no triangles"
    table = np.frombuffer(data, np.uint8, 50 * count, 84).reshape(count, 50)
    corners = np.ascontiguousarray(table[:, 12:48]).view("<f4")
    return "" if np.isfinite(corners).all() else f"mesh '{path}' has corners that are no numbers"


def _obj_fault(path, data):
    if _BAD_NUMBER.search(data):
        return f"mesh '{path}' has corners that are no numbers"
    count = len(_VERTEX.findall(data))
    faces = b" ".join(_FACE.findall(data)).split()
    if not faces or not count:
        return f"mesh '{path}' has no faces"
    try:
        used = np.array([int(face.split(b"/", 1)[0]) for face in faces])
    except ValueError:
        return f"mesh '{path}' has a face that is no list of numbers"
    if used.max() > count or used.min() < -count or (used == 0).any():
        return f"mesh '{path}' has {count} corners, but a face names number {used.max()}"
    return ""


def is_plain(shape, kind, data):
    """Whether PyBullet draws a mesh file correctly without conversion.

    Not when it is mirrored or only a part of it is used. An OBJ needs one material, in a library
    that exists: with none it is drawn black, and of several only one is
    used; the description's colour does not replace it.
    """
    geometry = shape.geometry
    if min(geometry.scale) < 0 or geometry.submesh or kind not in ("obj", "stl"):
        return False
    if kind == "stl":
        return True
    folder = os.path.dirname(geometry.path)
    if (
        shape.painted
        or len(set(_MATERIAL.findall(data))) != 1
        or not any(
            os.path.isfile(os.path.join(folder, library.decode(errors="replace")))
            for library in _LIBRARY.findall(data)
        )
    ):
        return False
    return all(_is_aligned(picture) for picture in _pictures(geometry.path, data))


def _pictures(path, data):
    """Existing picture files that an OBJ's material libraries name."""
    folder = os.path.dirname(path)
    for library in _LIBRARY.findall(data):
        name = os.path.join(folder, library.decode(errors="replace"))
        if not os.path.isfile(name):
            continue
        with open(name, encoding="utf-8", errors="replace") as file:
            for picture in _PICTURE.findall(file.read()):
                full = os.path.join(folder, picture.split()[-1])
                if os.path.isfile(full):
                    yield full


def _is_aligned(picture):
    return _width(picture, os.stat(picture).st_mtime_ns) % 4 == 0


@functools.lru_cache(maxsize=256)
def _width(picture, _):
    from PIL import Image

    try:
        with Image.open(picture) as opened:
            return opened.size[0]
    except (OSError, ValueError):
        return 1

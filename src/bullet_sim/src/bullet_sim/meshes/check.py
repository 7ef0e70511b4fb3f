"""Format of a mesh file, and whether PyBullet reads it correctly."""

import functools
import os
import re
import struct

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.meshes.looks import MAX_PIXELS, opened
from bullet_sim.meshes.parts import MAX_SIZE

_BAD_NUMBER = re.compile(rb"^[ \t]*v[nt]?\s[^\n]*?(?:nan|inf)", re.MULTILINE | re.IGNORECASE)
_VERTEX = re.compile(rb"^[ \t]*v\s", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f[ \t]+([^\n]*)$", re.MULTILINE)
_MATERIAL = re.compile(rb"^[ \t]*usemtl[ \t]+(\S+)", re.MULTILINE)
_LIBRARY = re.compile(rb"^[ \t]*mtllib[ \t]+(\S[^\n]*)$", re.MULTILINE)
_PICTURE = re.compile(r"^[ \t]*map_Kd[ \t]+(\S[^\n]*)$", re.MULTILINE)


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
    if np.isfinite(corners).all() and np.abs(corners).max() <= MAX_SIZE:
        return ""
    return f"mesh '{path}' has corners that are no numbers or beyond {MAX_SIZE:g} m"


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
    wrong = used[(used > count) | (used < -count) | (used == 0)]
    if not len(wrong):
        return ""
    return f"mesh '{path}' has {count} corners, but a face names number {wrong[0]}"


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
    libraries = _libraries(geometry.path, data)
    if shape.painted or len(set(_MATERIAL.findall(data))) != 1 or not libraries:
        return False
    folder = os.path.dirname(geometry.path)
    return all(
        _is_aligned(picture) for library in libraries for picture in _pictures(library, folder)
    )


def _libraries(path, data):
    """Existing material libraries that an OBJ names."""
    folder = os.path.dirname(path)
    names = (library.strip().decode(errors="replace") for library in _LIBRARY.findall(data))
    return [file for file in (os.path.join(folder, name) for name in names) if os.path.isfile(file)]


def _pictures(library, folder):
    """Existing picture files that a material library names; paths begin in the OBJ's folder."""
    with open(library, encoding="utf-8", errors="replace") as file:
        names = [picture.split()[-1] for picture in _PICTURE.findall(file.read())]
    files = (os.path.join(folder, name) for name in names)
    return [file for file in files if os.path.isfile(file)]


def _is_aligned(picture):
    width, height = _size(picture, os.stat(picture).st_mtime_ns)
    return width % 4 == 0 and width * height <= MAX_PIXELS


@functools.lru_cache(maxsize=256)
def _size(picture, _):
    try:
        with opened(picture) as found:
            return found.size
    except ModelError:
        return 1, 1

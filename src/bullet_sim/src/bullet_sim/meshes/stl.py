"""STL files as Gazebo's STLLoader reads them: as text wherever there is a vertex, else binary."""

from __future__ import annotations

import re
import struct

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.pose import Array

_FACET = re.compile(rb"^[ \t]*facet\b", re.MULTILINE | re.IGNORECASE)
_VERTEX = re.compile(rb"^[ \t]*vertex" + 3 * rb"[ \t]+(\S+)", re.MULTILINE | re.IGNORECASE)
_HEAD, _TRIANGLE = 84, 50  # [bytes] of a binary file: before the triangles, of each


def binary_count(data: bytes) -> int | None:
    """Number of triangles of a binary file, as it says itself; None: it is a text or cut off."""
    if len(data) < _HEAD or (_FACET.search(data) and _VERTEX.search(data)):
        return None
    (count,) = struct.unpack_from("<I", data, 80)
    return count if len(data) >= _HEAD + _TRIANGLE * count else None


def read_stl(data: bytes) -> Array:
    """Triangles (n, 3, 3) of a file, whatever is behind them.

    Raises:
        ModelError: it has none, or one without three corners; it is cut off, or no STL.
    """
    count = binary_count(data)
    if count is not None:
        table = np.frombuffer(data, np.uint8, _TRIANGLE * count, _HEAD).reshape(count, _TRIANGLE)
        return np.ascontiguousarray(table[:, 12:48]).view("<f4").reshape(-1, 3, 3).astype(float)
    corners = _VERTEX.findall(data) if _FACET.search(data) else []
    if not corners and len(data) >= _HEAD and b"\0" in data:
        raise ModelError(f"it is cut off after {(len(data) - _HEAD) // _TRIANGLE} triangles")
    if not corners or len(corners) % 3:
        raise ModelError("it has no triangles" if not corners else "a triangle lacks a corner")
    try:
        return np.array(corners, float).reshape(-1, 3, 3)
    except ValueError as error:
        raise ModelError(f"a corner is no number: {error}") from error

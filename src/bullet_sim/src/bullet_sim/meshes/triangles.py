"""Triangles and corners of mesh files, for contacts, rays and boxes."""

from __future__ import annotations

import functools
import os
from typing import Any

import numpy as np

from bullet_sim.files import read_file
from bullet_sim.meshes.stl import read_stl
from bullet_sim.pose import Array


def _load(path: str | None) -> Any:
    """A trimesh.Trimesh, or None if the file cannot be read."""
    try:
        changed = os.stat(path or "").st_mtime_ns
    except OSError:
        return None
    return _load_file(path, changed)


@functools.lru_cache(maxsize=1)  # its vertices and its triangles are asked for, one after the other
def _load_file(path: str | None, _changed: int) -> Any:
    import trimesh  # takes 0.2 s, for worlds with meshes alone

    try:
        if str(path).lower().endswith(".stl"):
            corners = read_stl(read_file(str(path), "mesh", "mesh_bytes")).reshape(-1, 3)
            return trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
        return trimesh.load(path, force="mesh", process=False, skip_materials=True)
    except Exception:  # pylint: disable=broad-except  # whatever a reader raises: PyBullet has it
        return None


def mesh_triangles(path: str | None) -> Array | None:
    """Triangles (n, 3, 3) of a mesh file, or None if it cannot be read."""
    mesh = _load(path)
    triangles = np.zeros((0, 3, 3)) if mesh is None else np.asarray(mesh.triangles, float)
    return triangles if len(triangles) and np.isfinite(triangles).all() else None


def mesh_corners(path: str, shared: bool) -> Array:
    """Vertices (n, 3) of a mesh file as Gazebo has them, in the order of its triangles.

    Of STL and OBJ files it has three for each triangle. There are none if the file cannot be read.

    Args:
        shared: triangles share those that have the same place and normal, as of COLLADA files.
    """
    mesh = _load(path)
    if mesh is None or not np.isfinite(mesh.vertices).all():
        return np.zeros((0, 3))
    order = np.asarray(mesh.faces).ravel()
    corners = np.asarray(mesh.vertices, float)[order]
    if shared:
        normals = np.asarray(mesh.vertex_normals, float)[order]
        _, first = np.unique(np.hstack([corners, normals]), axis=0, return_index=True)
        corners = corners[np.sort(first)]
    return corners


@functools.lru_cache(maxsize=256)
def mesh_box(path: str) -> Array:
    """Two corners (2, 3) of the box around a mesh file; NaN: it cannot be read."""
    triangles = mesh_triangles(path)
    if triangles is None:
        return np.full((2, 3), np.nan)
    return np.stack([triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))])

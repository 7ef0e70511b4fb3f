"""Meshes and boxes of shapes for the solver 'ode' and for rays: each mesh is read once."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pybullet as p

from bullet_sim.description.model import Link, Shape
from bullet_sim.engine import tables
from bullet_sim.pose import Array, Pose


class ShapeCache:
    """Meshes that were read for an engine's bodies.

    Args:
        client: gives PyBullet's number of the engine.
    """

    def __init__(self, client: Callable[[], int]) -> None:
        self._client = client
        self._vertices: dict[tuple[Any, ...], Array] = {}
        self._trees: dict[tuple[Any, ...], tables.Tree | None] = {}

    def tree(self, shape: Shape) -> tables.Tree | None:
        """The tree of a mesh; None: it is none, or cannot be read."""
        geometry = shape.geometry
        if geometry.kind != "mesh":
            return None
        key = geometry.path, geometry.scale
        if key not in self._trees:  # each model that is spawned asks again
            triangles = mesh_triangles(geometry.path)
            self._trees[key] = (
                None if triangles is None else tables.make_tree(triangles, geometry.scale)
            )
        return self._trees[key]

    def box_around(self, shape: Shape, frame: Pose, body: int, tree: tables.Tree | None) -> Array:
        """Box (6,) around a shape of what never moves."""
        pose, geometry = frame * shape.pose, shape.geometry
        if tree is not None:
            corners = tree.corners.reshape(-1, 3) @ pose.matrix.T + pose.position
            return np.concatenate([corners.min(axis=0), corners.max(axis=0)])
        half = tables.half_size(geometry.kind, geometry.size)
        if half is None:
            return np.concatenate(p.getAABB(body, -1, physicsClientId=self._client()))
        half = np.abs(pose.matrix) @ half
        return np.concatenate([pose.position - half, pose.position + half])

    def vertices(self, shape: Shape, link: Link) -> Array:
        """Vertices (n, 3) [m] of a mesh, from its link's center of mass; none: unreadable."""
        geometry = shape.geometry
        key = geometry.path, geometry.submesh, geometry.scale
        if key not in self._vertices:
            corners = mesh_corners(geometry.path, shared=geometry.is_converted)
            self._vertices[key] = corners.astype(np.float32) * np.asarray(
                geometry.scale, np.float32
            )
        return self._vertices[key] @ shape.pose.matrix.T + shape.pose.position - link.center


def _load_mesh(path: str | None) -> Any:
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
        return trimesh.load(path, force="mesh", process=False, skip_materials=True)
    except Exception:  # pylint: disable=broad-except  # whatever a reader raises: PyBullet has it
        return None


def mesh_triangles(path: str | None) -> Array | None:
    """Triangles (n, 3, 3) of a mesh file, or None if it cannot be read."""
    mesh = _load_mesh(path)
    triangles = np.zeros((0, 3, 3)) if mesh is None else np.asarray(mesh.triangles, float)
    return triangles if len(triangles) and np.isfinite(triangles).all() else None


def mesh_corners(path: str, shared: bool) -> Array:
    """Vertices (n, 3) of a mesh file as Gazebo has them, in the order of its triangles.

    Of STL and OBJ files it has three for each triangle. There are none if the file cannot be read.

    Args:
        shared: triangles share those that have the same place and normal, as of COLLADA files.
    """
    mesh = _load_mesh(path)
    if mesh is None or not np.isfinite(mesh.vertices).all():
        return np.zeros((0, 3))
    order = np.asarray(mesh.faces).ravel()
    corners = np.asarray(mesh.vertices, float)[order]
    if shared:
        normals = np.asarray(mesh.vertex_normals, float)[order]
        _, first = np.unique(np.hstack([corners, normals]), axis=0, return_index=True)
        corners = corners[np.sort(first)]
    return corners

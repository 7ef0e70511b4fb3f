"""Shapes of bodies for the solver 'ode' and for rays: meshes are read once."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import pybullet as p

from bullet_sim.description.model import Link, Shape
from bullet_sim.engine import tables
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.rays import (
    KINDS,
    RayShape,
    Triangles,
    has_embree,
    mesh_corners,
    mesh_triangles,
)
from bullet_sim.pose import Array, Pose, Vec3


class ShapeCache:
    """Meshes that were read for an engine's bodies.

    Args:
        client: PyBullet's number of the engine.
    """

    def __init__(self, client: int) -> None:
        self._client = client
        self._vertices: dict[tuple[Any, ...], Array] = {}
        self._trees: dict[tuple[Any, ...], tables.Tree | None] = {}
        self._traced: dict[tuple[Any, ...], tuple[Triangles, Array, float]] = {}

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
            return np.concatenate(p.getAABB(body, -1, physicsClientId=self._client))
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

    def ray_shapes(self, body: int, links: Iterable[tuple[int, Link]]) -> list[RayShape] | None:
        """All shapes of a body for rays; None if there is one that is not known.

        Args:
            links: row of bodies and link.
        """
        shapes = []
        for row, link in links:
            for shape in link.collisions:
                geometry, pose = shape.geometry, shape.pose
                place, turn = np.subtract(pose.position, link.center), pose.matrix
                kind = KINDS.get(geometry.kind, q.OTHER)
                if kind == q.MESH:
                    traced = self._trace(geometry.path, geometry.scale)
                    if traced is None:
                        return None
                    triangles, middle, radius = traced
                    size, place = np.zeros(3), place + turn @ middle
                elif kind == q.OTHER:
                    return None
                else:
                    triangles, radius = None, tables.reach(geometry.kind, geometry.size)
                    size = tables.solid_size(kind, geometry.size)
                shapes.append(
                    RayShape(body, row, geometry.kind, size, place, turn, radius, triangles)
                )
        return shapes

    def _trace(self, path: str, scale: Vec3) -> tuple[Triangles, Array, float] | None:
        """A mesh's triangles, around the middle (3,) [m] of a sphere of a radius [m]."""
        if not has_embree():
            return None
        key = path, scale
        if key not in self._traced:
            corners = mesh_triangles(path)
            if corners is None:
                return None
            corners = corners * np.asarray(scale)
            middle = 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))
            corners = corners - middle
            radius = float(np.linalg.norm(corners, axis=2).max())
            self._traced[key] = Triangles(corners), middle, radius
        return self._traced[key]

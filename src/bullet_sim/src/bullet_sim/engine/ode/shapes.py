"""Meshes and boxes of shapes for the solver 'ode' and for rays: each mesh is read once."""

from __future__ import annotations

from typing import Any

import numpy as np

from bullet_sim.description.model import Link, Shape
from bullet_sim.engine.ode import tables
from bullet_sim.engine.ode.owner import Owner
from bullet_sim.errors import ModelError
from bullet_sim.meshes.terrain import grid
from bullet_sim.meshes.triangles import mesh_corners, mesh_triangles
from bullet_sim.pose import Array, Pose, vector3


class ShapeCache:
    """Meshes that were read for an engine's bodies."""

    def __init__(self, engine: Owner) -> None:
        self._engine = engine
        self._vertices: dict[tuple[Any, ...], Array] = {}
        self._trees: dict[tuple[Any, ...], tables.Tree | None] = {}
        self._fields: dict[tuple[Any, ...], tables.Field | None] = {}

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

    def field(self, shape: Shape) -> tables.Field | None:
        """A heightmap; None: it is none, or cannot be read."""
        relief = shape.geometry.relief
        if relief is None:
            return None
        key = relief.path, relief.size, relief.sampling
        if key not in self._fields:
            try:
                heights = grid(relief.path, relief.size, relief.sampling)
                self._fields[key] = tables.Field(heights, vector3(relief.size))
            except ModelError:
                self._fields[key] = None
        return self._fields[key]

    def box_around(self, shape: Shape, frame: Pose, body: int, tree: tables.Tree | None) -> Array:
        """Box (6,) around a shape of what never moves."""
        pose, geometry = frame * shape.pose, shape.geometry
        field = self.field(shape)
        if field is not None:
            return tables.field_box(field, pose)
        if tree is not None:
            corners = tree.corners.reshape(-1, 3) @ pose.matrix.T + pose.position
            return np.concatenate([corners.min(axis=0), corners.max(axis=0)])
        half = tables.half_size(geometry.kind, geometry.size)
        if half is None:
            return self._engine.mirror.box(body)
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

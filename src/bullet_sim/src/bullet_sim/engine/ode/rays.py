"""Rays of lidars at the shapes of bodies, which descriptions of models have."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bullet_sim.description.model import Geometry
from bullet_sim.engine.api import Rays
from bullet_sim.engine.ode import tables
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.library import caster
from bullet_sim.engine.quickstep.state import Casting
from bullet_sim.pose import Array, Pose

_SINGLE = 1e-6  # of a size, above what single precision rounds
_FAR = 1e9  # [m]


@dataclass
class RayShape:
    """A shape at which rays are cast.

    Attributes:
        row: of its link; -1: it never moves.
        geometry: of a kind of tables.KINDS, or a plane.
        pose: in the link, from its center of mass; in the world if it never moves.
        tree: of a mesh.
    """

    row: int
    geometry: Geometry
    pose: Pose
    tree: tables.Tree | None

    def is_known(self) -> bool:
        """Whether it is such a shape: not of another kind, or a mesh that cannot be read."""
        kind = self.geometry.kind
        return self.tree is not None if kind == "mesh" else kind == "plane" or kind in tables.KINDS


class RayScene:
    """Planes, boxes, spheres, cylinders and meshes, at which rays are cast.

    Args:
        bodies: of the solver, which says where they are.
    """

    def __init__(self, shapes: Sequence[RayShape], bodies: Array) -> None:
        self._castings: dict[int, tuple[Casting, Callable[..., Any]]] = {}  # of so many rays
        solid = [shape for shape in shapes if shape.geometry.kind != "plane"]
        solid, branches, depth = _sorted(solid, bodies)
        shapes = [*solid, *(shape for shape in shapes if shape.geometry.kind == "plane")]
        kinds = [tables.KINDS.get(shape.geometry.kind, q.PLANE) for shape in shapes]
        sizes = [
            np.zeros(3) if kind == q.PLANE else tables.solid_size(kind, shape.geometry.size)
            for kind, shape in zip(kinds, shapes)
        ]
        meshes, roots = _joined([shape.tree for shape in shapes])
        room = depth + max((s.tree.depth for s in shapes if s.tree is not None), default=0) + 4
        places = tables.table([shape.pose.position for shape in shapes], 3)
        turns = np.reshape([shape.pose.matrix for shape in shapes], (-1, 3, 3))
        self._arrays: dict[str, Array] = {
            "bodies": bodies,
            "rows": np.array([shape.row for shape in shapes], np.int64),
            "places": places,
            "turns": turns,
            "centers": places.copy(),
            "frames": turns.copy(),
            "kinds": np.array(kinds, np.int64),
            "sizes": tables.table(sizes, 3),
            "roots": roots,
            "origins": np.zeros((len(shapes), 3)),
            "extents": tables.table([_extent(shape) for shape in solid], 6),
            "boxes": np.zeros((len(branches) + len(solid), 6)),
            "branches": branches,
            **meshes,
            "todo": np.zeros(room, np.int64),
            "entries": np.zeros(room),
        }

    def cast(self, rays: Rays) -> Array:
        """As Engine.cast_rays; rays meet all shapes from both sides."""
        center, directions, near, far = rays
        count = len(directions)
        if count not in self._castings:
            casting = Casting(
                center=np.zeros(3),
                directions=np.zeros((count, 3)),
                ranges=np.zeros(count),
                **self._arrays,
            )
            self._castings[count] = casting, caster(casting)
        casting, cast = self._castings[count]
        casting.center[:], casting.directions[:] = center, directions
        cast(near, far)
        return casting.ranges.copy()


class MeshScene:
    """Triangles of links that are put anywhere, at which rays are cast from both sides.

    Args:
        meshes: row of the link, pose in it and tree of each.
        positions, orientations: of the links (n, 3) [m] and (n, 4).
    """

    def __init__(
        self,
        meshes: Sequence[tuple[int, Pose, tables.Tree]],
        positions: Array,
        orientations: Array,
    ) -> None:
        self._bodies = np.zeros((len(positions), q.B_SIZE))
        self.place(np.arange(len(positions)), positions, orientations)
        kind = Geometry("mesh")
        shapes = [RayShape(row, kind, pose, tree) for row, pose, tree in meshes]
        self.cast = RayScene(shapes, self._bodies).cast

    def place(self, rows: Array, positions: Array, orientations: Array) -> None:
        """Put links, by their rows (n,), where these say."""
        self._bodies[rows, q.POS : q.POS + 3] = positions
        self._bodies[rows, q.QUAT : q.QUAT + 4] = orientations


def _sorted(shapes: Sequence[RayShape], bodies: Array) -> tuple[list[RayShape], Array, int]:
    """Shapes in the order of a tree of boxes around them, its branches, how deep it is."""
    if not shapes:
        return [], np.zeros((0, 2), np.int64), 0
    places = np.array([shape.pose.position for shape in shapes])
    rows = np.array([shape.row for shape in shapes])
    places[rows >= 0] += bodies[rows[rows >= 0], q.POS : q.POS + 3]
    places = np.clip(np.nan_to_num(places), -_FAR, _FAR)  # of what is nowhere any more, too
    points = (places - places.mean(axis=0)).astype(np.float32)
    order, _, children, depth = tables.sorted_tree(np.repeat(points[:, None], 3, axis=1))
    return [shapes[number] for number in order], _branches(children, 0, len(children)), depth


def _branches(children: Array, first: int, leaves: int) -> Array:
    """Children of a tree as rows of boxes, of which its own begin with `first`, and its leaves'
    with `leaves`; a single leaf is twice there."""
    children = np.where(children == q.NO_CHILD, children[:, :1], children)
    return np.where(children >= 0, children + first, leaves - 1 - children)


def _extent(shape: RayShape) -> Array:
    """Center and half the edges (6,) [m] of a box around a shape, in its frame."""
    if shape.tree is not None:
        extent = shape.tree.nodes[0].copy()
        extent[3:] += _SINGLE * (np.abs(extent[:3]) + extent[3:])
        return extent
    return np.concatenate([np.zeros(3), tables.half_size(shape.geometry.kind, shape.geometry.size)])


def _joined(trees: Sequence[tables.Tree | None]) -> tuple[dict[str, Array], Array]:
    """Triangles, nodes and children of trees, each once; the trees' roots, -1 of None."""
    distinct = {id(tree): tree for tree in trees if tree is not None}
    counts = [(len(tree.nodes), len(tree.exact)) for tree in distinct.values()]
    firsts = np.cumsum([(0, 0), *counts], axis=0)
    inner = int(firsts[-1, 0])
    boxes, leaves, children = [np.zeros((0, 6))], [np.zeros((0, 6))], [np.zeros((0, 2), np.int64)]
    for tree, (node, triangle) in zip(distinct.values(), firsts.tolist()):
        middle, half = tree.nodes[:, :3], tree.nodes[:, 3:]
        half = half + _SINGLE * (np.abs(middle) + half)
        boxes.append(np.hstack([middle - half, middle + half]))
        corners = tree.exact.reshape(-1, 3, 3) + [[[0.0] * 3]]
        corners[:, 1:] += corners[:, :1]
        leaves.append(np.hstack([corners.min(axis=1), corners.max(axis=1)]))
        children.append(_branches(tree.children, node, inner + triangle))
    roots = dict(zip(distinct, firsts[:, 0].tolist()))
    numbers = [-1 if tree is None else roots[id(tree)] for tree in trees]
    triangles = [np.zeros((0, 9)), *(tree.exact for tree in distinct.values())]
    joined = {
        "triangles": np.concatenate(triangles),
        "nodes": np.concatenate([*boxes, *leaves]),
        "children": np.concatenate(children),
    }
    return joined, np.array(numbers, np.int64)

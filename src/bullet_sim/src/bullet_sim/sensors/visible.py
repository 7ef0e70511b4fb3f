"""What lidars of the type gpu_ray see: the visuals of all models, where cameras show them.

As in Gazebo it is what is rendered that they measure: visuals alone, translucent ones as well, from
both sides and up to the polygons of round shapes; nothing that is nearer than their minimum.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.description.model import Geometry, Shape
from bullet_sim.engine import tables
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.rays import RayScene, RayShape
from bullet_sim.errors import ModelError
from bullet_sim.kinematics import Kinematics, quaternions
from bullet_sim.meshes.prepare import box_sides
from bullet_sim.meshes.read import read_parts
from bullet_sim.pose import Array

if TYPE_CHECKING:
    from bullet_sim.world import World

SEGMENTS = 32  # around a cylinder, around a sphere and from pole to pole, as in Gazebo
SEEN = 0x0FFFFFFC  # visibility_flags of which a visual needs one: all but those of Gazebo's window


class VisibleScene:
    """The visuals of a world, at which rays are cast.

    Args:
        world: World, to be used in the thread that owns its engine.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._sources: list[Any] = []  # that the scene is made of
        self._trees: dict[Any, tables.Tree | None] = {}
        self._kinematics = Kinematics({})
        self._bodies = np.zeros((0, q.B_SIZE))
        self._scene: RayScene | None = None

    def cast_rays(
        self,
        center: Array,
        directions: Array,
        near: float,
        far: float,
        own: int | None = None,
        look_near: bool = True,
    ) -> Array:
        """As Engine.cast_rays, but that nothing nearer than `near` is seen, of whatever body."""
        return self._placed().cast(center, directions, near, far, None, False)

    def _placed(self) -> RayScene:
        """The scene with all visuals where they are now."""
        sources = self._world.sources()
        known = self._sources
        if len(sources) != len(known) or any(a is not b for a, b in zip(sources, known)):
            self._sources, self._scene = sources, None
            links = {source.key: source.links or () for source in sources}
            self._kinematics = Kinematics(links)
            self._bodies = np.zeros((sum(map(len, links.values())), q.B_SIZE))
        self._kinematics.apply(self._world.snapshot())
        rows = np.flatnonzero(self._kinematics.changed)
        if len(rows):
            poses = self._kinematics.poses[rows]
            self._bodies[rows, q.POS : q.POS + 3] = poses[:, :3, 3]
            self._bodies[rows, q.QUAT : q.QUAT + 4] = quaternions(poses)
        if self._scene is None:
            self._scene = RayScene(self._shapes(), self._bodies)
        return self._scene

    def _shapes(self) -> list[RayShape]:
        mesh, shapes = Geometry("mesh"), []
        for source in self._sources:
            first = self._kinematics.firsts[source.key]
            for row, link in enumerate(source.links or (), first):
                for shape in link.shapes:
                    tree = self._tree(shape) if shape.visibility & SEEN else None
                    if tree is not None:
                        shapes.append(RayShape(-1, row, mesh, shape.pose, tree))
        return shapes

    def _tree(self, shape: Shape) -> tables.Tree | None:
        """The tree of a visual's triangles; None: a mesh that cannot be read."""
        it = shape.geometry
        key = it.kind, it.size, it.path, it.scale, it.submesh, it.centered, it.flat
        if key not in self._trees:
            found = triangles_of(it)
            self._trees[key] = None if found is None else tables.make_tree(found, (1.0, 1.0, 1.0))
        return self._trees[key]


def triangles_of(geometry: Geometry) -> Array | None:
    """Triangles (n, 3, 3) [m] of a visual as Gazebo renders it; None: unknown, or unreadable."""
    if geometry.kind == "mesh":
        try:
            return _mesh_triangles(geometry)
        except ModelError:  # of which the renderer tells
            return None
    makers = {"box": _box, "cylinder": _cylinder, "sphere": _sphere}
    return makers[geometry.kind](geometry) if geometry.kind in makers else None


def _mesh_triangles(geometry: Geometry) -> Array:
    found = [
        np.asarray(mesh.triangles, float) @ transform[:3, :3].T + transform[:3, 3]
        for mesh, transform in read_parts(geometry)
    ]
    triangles = np.concatenate(found)
    if not np.isfinite(triangles).all():
        raise ModelError(f"mesh '{geometry.path}' has corners that are no numbers")
    if geometry.centered:
        triangles -= (triangles.min(axis=(0, 1)) + triangles.max(axis=(0, 1))) / 2.0
    return np.asarray(triangles * np.asarray(geometry.scale))


def _box(geometry: Geometry) -> Array:
    """All sides, or the upper one alone of a plane."""
    sides = [
        corners for normal, corners in box_sides() if not geometry.flat or normal.tolist()[2] > 0.0
    ]
    triangles = [
        [side[a], side[b], side[c]] for side in sides for a, b, c in ((0, 1, 2), (0, 2, 3))
    ]
    return np.array(triangles) * (0.5 * np.asarray(geometry.size))


def _cylinder(geometry: Geometry) -> Array:
    radius, length = geometry.size
    angles = 2.0 * math.pi * np.arange(SEGMENTS + 1) / SEGMENTS
    ring = np.column_stack([radius * np.sin(angles), radius * np.cos(angles)])
    below, above = (np.column_stack([ring, np.full(len(ring), z * length)]) for z in (-0.5, 0.5))
    middles = [np.tile([0.0, 0.0, z * length], (SEGMENTS, 1)) for z in (-0.5, 0.5)]
    parts = (
        (below[:-1], below[1:], above[1:]), (below[:-1], above[1:], above[:-1]),
        (middles[0], below[:-1], below[1:]), (middles[1], above[:-1], above[1:]),
    )  # fmt: skip
    return np.concatenate([np.stack(part, axis=1) for part in parts])


def _sphere(geometry: Geometry) -> Array:
    """With poles along y, as Gazebo has it."""
    polar = math.pi * np.arange(SEGMENTS + 1) / SEGMENTS
    angle = 2.0 * math.pi * np.arange(SEGMENTS + 1) / SEGMENTS
    around = np.outer(np.sin(polar), np.sin(angle)), np.outer(np.sin(polar), np.cos(angle))
    grid = np.stack([around[0], np.tile(np.cos(polar), (len(angle), 1)).T, around[1]], axis=2)
    one, two, three, four = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    parts = [
        np.stack([a, b, c], axis=2).reshape(-1, 3, 3)
        for a, b, c in ((one, two, three), (one, three, four))
    ]
    return geometry.size[0] * np.concatenate(parts)

"""What lidars of the type gpu_ray see: the visuals of all models, where cameras show them.

As in Gazebo it is what is rendered that they measure: visuals alone, translucent ones as well, from
both sides and up to the polygons of round shapes; nothing that is nearer than their minimum.
"""

from __future__ import annotations

from operator import attrgetter
from typing import Any

import numpy as np

from bullet_sim.description.model import VISIBLE, Geometry, Shape
from bullet_sim.engine.api import Rays
from bullet_sim.errors import ModelError
from bullet_sim.kinematics import Kinematics, quaternions
from bullet_sim.meshes.read import read_parts
from bullet_sim.meshes.solids import factors, solid
from bullet_sim.pose import Array, Pose

SEGMENTS = 32  # around a cylinder, around a sphere and from pole to pole, as in Gazebo
_KEY = attrgetter("kind", "size", "path", "scale", "submesh", "centered", "flat")  # of a Geometry


class VisibleScene:
    """The visuals of a world, at which rays are cast.

    Args:
        world: World, to be used in the thread that owns its engine.
    """

    def __init__(self, world: Any) -> None:
        self._world = world
        self._sources: list[Any] = []  # that the scene is made of
        self._triangles: dict[Any, Array | None] = {}  # of geometries
        self._kinematics = Kinematics({})
        self._scene: Any = None  # of Engine.mesh_scene()

    def cast_rays(self, rays: Rays) -> Array:
        """As Engine.cast_rays."""
        self._place()
        distances: Array = self._scene.cast(rays)
        return distances

    def _place(self) -> None:
        """Put all visuals where they are now."""
        sources, known = self._world.sources(), self._sources
        if len(sources) != len(known) or any(a is not b for a, b in zip(sources, known)):
            self._sources, self._scene = sources, None
            self._kinematics = Kinematics({source.key: source.links for source in sources})
        self._kinematics.apply(self._world.snapshot())
        poses = self._kinematics.poses
        if self._scene is None:
            self._scene = self._world.engine.mesh_scene(
                self._meshes(), poses[:, :3, 3], quaternions(poses)
            )
            return
        rows = np.flatnonzero(self._kinematics.changed)
        if len(rows):
            self._scene.place(rows, poses[rows, :3, 3], quaternions(poses[rows]))

    def _meshes(self) -> list[tuple[int, Pose, Array]]:
        """Row of the link, pose in it and triangles of each visual."""
        meshes = []
        for source in self._sources:
            first = self._kinematics.firsts[source.key]
            for row, link in enumerate(source.links, first):
                for shape in link.shapes:
                    triangles = self._of(shape) if shape.visibility & VISIBLE else None
                    if triangles is not None:
                        meshes.append((row, shape.pose, triangles))
        return meshes

    def _of(self, shape: Shape) -> Array | None:
        key = _KEY(shape.geometry)
        if key not in self._triangles:
            self._triangles[key] = triangles_of(shape.geometry)
        return self._triangles[key]


def triangles_of(geometry: Geometry) -> Array | None:
    """Triangles (n, 3, 3) [m] of a visual as Gazebo renders it; None: unknown, or unreadable."""
    if geometry.kind == "mesh":
        try:
            return _mesh_triangles(geometry)
        except ModelError:  # of which the renderer tells
            return None
    if geometry.kind not in ("box", "cylinder", "sphere"):
        return None
    kind = "plane" if geometry.flat else geometry.kind
    corners, triangles = solid(kind, SEGMENTS, SEGMENTS)
    return np.asarray(corners[triangles, :3] * factors(geometry))


def _mesh_triangles(geometry: Geometry) -> Array:
    parts = [
        np.asarray(mesh.triangles, float) @ transform[:3, :3].T + transform[:3, 3]
        for mesh, transform in read_parts(geometry)
    ]
    triangles = np.concatenate(parts)
    if not np.isfinite(triangles).all():
        raise ModelError(f"mesh '{geometry.path}' has corners that are no numbers")
    return np.asarray(triangles * np.asarray(geometry.scale))

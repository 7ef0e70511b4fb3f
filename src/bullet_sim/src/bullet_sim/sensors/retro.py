"""Intensities of lidars: the <laser_retro> of the collision or visual that a ray hits."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from bullet_sim.meshes.triangles import mesh_box
from bullet_sim.pose import Array, Pose

if TYPE_CHECKING:
    from bullet_sim.description.model import Shape
    from bullet_sim.models.model import Model

_CLOSE = 2e-3  # [m] of a hit to the shape that it is on
_FLAT = 0.01  # of a radius, by which a polygon of a visual is inside of it


def intensities(models: Iterable[Model], points: Array, seen: str = "collisions") -> Array | None:
    """Intensities (n,) float32 of hits.

    Args:
        points: (n, 3) [m] in the world, without noise; what is not finite has none.
        seen: what the rays hit: 'collisions' or 'visuals'.

    Returns:
        0 where nothing with a <laser_retro> is hit; None: no model has one.
    """
    retros = None
    for model in models:
        for part, link in model.rigid_parts.items():
            shapes = [shape for shape in getattr(link, seen) if shape.laser_retro]
            if not shapes:
                continue
            if retros is None:
                retros = np.zeros(len(points), np.float32)
            frame = Pose(*model.body.link_motion(part)[:2])
            for shape in shapes:
                pose = frame * shape.pose
                local = (points - np.asarray(pose.position)) @ pose.matrix
                retros[_is_on(shape, local)] = shape.laser_retro
    return retros


def _is_on(shape: Shape, points: Array) -> Array:
    """Which points (n, 3), in a shape's axes, are on it; of a mesh: in the box around it."""
    kind, size = shape.geometry.kind, np.asarray(shape.geometry.size, float)
    with np.errstate(invalid="ignore"):
        if kind == "sphere":
            outside = np.linalg.norm(points, axis=1) - size[0]
            near: Array = (outside <= _CLOSE) & (outside >= -_CLOSE - _FLAT * size[0])
        elif kind == "cylinder":
            radial = np.hypot(points[:, 0], points[:, 1]) - size[0]
            axial = np.abs(points[:, 2]) - size[1] / 2.0
            outside = np.maximum(radial, axial)
            near = (outside <= _CLOSE) & (outside >= -_CLOSE - _FLAT * size[0])
        elif kind == "box":
            near = np.abs((np.abs(points) - size / 2.0).max(axis=1)) <= _CLOSE
        elif kind == "plane":
            near = np.abs(points[:, 2]) <= _CLOSE
        else:
            low, high = mesh_box(shape.geometry.path) * np.asarray(shape.geometry.scale)
            near = ((points >= low - _CLOSE) & (points <= high + _CLOSE)).all(axis=1)
    return near

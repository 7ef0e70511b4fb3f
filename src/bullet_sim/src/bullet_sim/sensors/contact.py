"""Contacts of a body as a bumper reports them: grouped by pairs of collision shapes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from bullet_sim.description.collisions import collision_names, merged
from bullet_sim.description.model import ModelDescription, Shape
from bullet_sim.pose import Vector


def watched(spec: Any, description: ModelDescription) -> tuple[set[str], list[str]]:
    """Collisions of a ContactSpec, by their names in Gazebo: LINK::COLLISION.

    As there a name has to be that of a collision of the sensor's link, of a URDF as sdformat writes
    it, see collision_names; without names they are those of the link in the file.

    Returns:
        Names that there are, and those of the ContactSpec that name nothing.
    """
    names = collision_names(description)
    if not spec.collisions:
        return {name for (link, _), name in names.items() if link == spec.link}, []
    body, known = merged(description)[spec.link], set(names.values())
    missing = [name for name in spec.collisions if f"{body}::{name}" not in known]
    return {f"{body}::{name}" for name in spec.collisions} & known, missing


def distance(shape: Shape, point: Vector) -> float:
    """Distance [m] from a point of the link's frame to a shape's surface, 0 inside.

    Exact for spheres, boxes and cylinders; a mesh counts as a point at its origin, a plane as
    its surface.
    """
    local = shape.pose.matrix.T @ (np.asarray(point) - np.asarray(shape.pose.position))
    geometry = shape.geometry
    if geometry.kind == "box":
        outside = np.maximum(np.abs(local) - np.asarray(geometry.size) / 2.0, 0.0)
        return float(np.linalg.norm(outside))
    if geometry.kind == "sphere":
        return max(0.0, float(np.linalg.norm(local)) - geometry.size[0])
    if geometry.kind == "cylinder":
        radius, length = geometry.size
        return float(
            np.hypot(
                max(0.0, np.hypot(local[0], local[1]) - radius),
                max(0.0, abs(local[2]) - length / 2.0),
            )
        )
    return abs(float(local[2])) if geometry.kind == "plane" else float(np.linalg.norm(local))


def nearest(shapes: Sequence[Shape], point: Vector) -> Shape | None:
    """The shape of a link that a contact point belongs to, or None when it has none.

    Args:
        shapes: collision Shapes in the link's frame.
        point: (3,) [m] in that frame.
    """
    if len(shapes) < 2:
        return shapes[0] if shapes else None
    return min(shapes, key=lambda shape: distance(shape, point))

"""Contacts of a body as a bumper reports them: grouped by pairs of collision shapes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bullet_sim.description.model import ModelDescription, Shape
from bullet_sim.errors import ModelError
from bullet_sim.plugins.forces import ContactSpec
from bullet_sim.pose import Vector


def watched_links(spec: ContactSpec, description: ModelDescription) -> set[tuple[str, str]]:
    """Links and shape names of a ContactSpec.

    Names are those of the description's collisions or, as sdformat makes them, LINK_collision,
    LINK_collision_1 ... and PARENT_fixed_joint_lump__LINK_collision ... for links on fixed
    joints.

    Returns:
        Set of (link, shape name); shape name '' means all shapes of the link.

    Raises:
        ModelError: a name matches nothing; lists the valid names.
    """
    if not spec.collisions:
        return {(spec.link, "")}
    known = {
        shape.name: link.name for link in description.links.values() for shape in link.collisions
    }
    watched = set()
    for name in spec.collisions:
        plain = name.rsplit("::", 1)[-1].rsplit("_fixed_joint_lump__", 1)[-1]
        if plain in known:
            numbered = "_fixed_joint_lump__" in name  # sdformat numbers those through
            watched.add((known[plain], "" if numbered else plain))
            continue
        link = plain.rsplit("_collision", 1)[0]
        if link not in description.links or not description.links[link].collisions:
            raise ModelError(
                f"contact sensor '{spec.name}' watches collision '{name}', which "
                f"does not exist; collisions are {', '.join(known) or '(none)'}"
            )
        watched.add((link, ""))
    return watched


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

"""A model's collisions: their names in Gazebo, which of its links collide with each other."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable

from bullet_sim.description.lump import LumpedModel, as_created
from bullet_sim.description.model import Link, ModelDescription, Shape

_HULL_OVERLAP = 1e-3  # [m]


def merged(model: ModelDescription) -> dict[str, str]:
    """Link -> the one that sdformat merges it into, itself where it stays."""
    body = {name: name for name in model.links}
    for joint in as_created(model) if model.is_urdf else ():
        kept = joint.name in model.kept or joint.name in model.measured
        if joint.kind == "fixed" and not kept:
            body[joint.child] = body[joint.parent]
    return body


def collision_names(model: ModelDescription) -> dict[tuple[str, int], str]:
    """The collisions as Gazebo names and orders them, those without a shape as well.

    Those of a URDF are as sdformat writes them: numbered within the link that fixed joints merge
    them into, whose name comes first.

    Returns:
        (link in the file, number there) -> LINK::COLLISION.
    """
    body, order = merged(model), list(model.links)
    if model.is_urdf:
        order = [model.root, *model.loose, *(joint.child for joint in as_created(model))]
    count = dict.fromkeys(order, 0)
    names = {}
    for link in sorted(order, key=lambda name: order.index(body[name])):
        own = model.links[link]
        for shape in sorted([*own.collisions, *own.hollow], key=lambda shape: shape.number):
            name = shape.name or "collision"
            if model.is_urdf:
                name = _name_by_sdformat(shape.given or link, body[link], count[body[link]])
                count[body[link]] += 1
            names[link, shape.number] = f"{body[link]}::{name}"
    return names


def _name_by_sdformat(stem: str, body: str, number: int) -> str:
    name = f"{stem}_collision" + (f"_{number}" if number else "")
    return name if name.startswith(body) else f"{body}_fixed_joint_lump__{name}"


def is_passable(shape: Shape, link: Link) -> bool:
    """Whether a collision of a link pushes nothing (<collide_without_contact>)."""
    return (shape.surface or link.surface).without_contact


def self_colliding(description: ModelDescription, lumped: LumpedModel) -> list[tuple[str, str]]:
    """Pairs of links that collide with each other, in the order of the links.

    None that a joint connects. As in Gazebo it is enough that one has self_collide; where one has a
    mesh, whose hull counts here, both need it.
    """
    links = lumped.links
    joints = (*lumped.joints, *lumped.welds)
    neighbors = {frozenset((joint.parent, joint.child)) for joint in joints}
    wanted = {n for n, link in links.items() if description.self_collide or link.self_collide}
    meshes = {name for name, link in links.items() if _has_mesh(link)}
    return [
        (one, other)
        for one, other in (itertools.combinations(links, 2) if wanted else ())
        if (one in wanted) + (other in wanted) > (one in meshes or other in meshes)
        and frozenset((one, other)) not in neighbors
    ]


def _has_mesh(link: Link) -> bool:
    return any(shape.geometry.kind == "mesh" for shape in link.collisions)


def without_overlapping_hulls(
    pairs: Iterable[tuple[str, str]],
    description: ModelDescription,
    lumped: LumpedModel,
    depth: Callable[[str, str], float],
) -> list[tuple[str, str]]:
    """Of self_colliding() those whose links do not overlap where the model is added, as a body does
    the wheels in its arches, where a mesh's convex hull counts; each other one is a warning.

    Args:
        depth: function of two links -> how deep they overlap [m].
    """
    links, touching = lumped.links, []
    for one, other in pairs:
        overlap = depth(one, other) if _has_mesh(links[one]) or _has_mesh(links[other]) else 0.0
        if overlap <= _HULL_OVERLAP:
            touching.append((one, other))
            continue
        description.warn(
            f"links {one!r} and {other!r} do not collide with each other: where the model "
            f"is loaded they overlap by {overlap:.3g} m (meshes collide as convex hulls)",
            "pairs of links do not collide with each other",
            f"{one}, {other}",
        )
    return touching

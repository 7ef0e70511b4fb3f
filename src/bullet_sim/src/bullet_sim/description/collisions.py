"""Names of a model's collisions in Gazebo."""

from __future__ import annotations

from bullet_sim.description.lump import as_created
from bullet_sim.description.model import ModelDescription


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

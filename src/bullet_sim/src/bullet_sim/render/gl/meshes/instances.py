"""What one instance of a mesh is: its place in its link, its colours, its label."""

import numpy as np

from bullet_sim.meshes.looks import GREY
from bullet_sim.render.gl.kinematics import pose_matrix
from bullet_sim.render.gl.meshes.batches import Kind


def describe(key, row, moves, shape, look):
    """One instance's numbers, or None when it is invisible."""
    geometry, finish = shape.geometry, shape.finish
    size = _size(geometry)
    local = pose_matrix(shape.pose) @ np.diag([*size, 1.0])
    color = _color(shape, look.part, geometry.kind)
    alpha = color[3] * finish.opacity
    if alpha <= 0.0:
        return None
    specular = look.part.specular if finish.specular is None else finish.specular
    emissive = tuple(np.maximum(look.part.emissive, finish.emissive).tolist())
    ambient = color[:3] if finish.ambient is None else finish.ambient
    kind = Kind(
        textured=look.texture is not None,
        shiny=any(specular) or any(emissive),
        lit=finish.lit,
        double_sided=look.part.double_sided,
        transparent=alpha < 0.999 or look.clear,
    )
    return {
        "group": (look.mesh, look.texture, kind),
        "look": look,
        "row": row,
        "local": local,
        "middle": (*look.mesh.centre, 1.0),
        "half": (look.mesh.high - look.mesh.low) / 2.0,
        "radius": look.mesh.radius * max(size),
        "casts": finish.cast_shadows and alpha > 0.5,
        "still": not moves,
        "colors": [
            *color[:3],
            alpha,
            *ambient,
            finish.shininess,
            *specular,
            0.0,
            *emissive,
            0.0,
            *_label(key),
        ],
    }


def _size(geometry):
    """Factors (3,) from a solid of unit size."""
    if geometry.kind == "cylinder":
        radius, length = geometry.size
        return (radius, radius, length)
    if geometry.kind == "sphere":
        return (geometry.size[0],) * 3
    if geometry.kind == "mesh":
        return (1.0, 1.0, 1.0)
    return tuple(geometry.size) or (1.0, 1.0, 1.0)


def _color(shape, part, kind):
    """RGBA of an instance."""
    if shape.texture:
        return part.color
    if kind != "mesh":
        return shape.color or GREY
    if shape.painted or part.color == GREY:
        return shape.color or GREY
    return part.color


def _label(key):
    """Four numbers 0..1 that make the bytes of a body's key."""
    return [((key >> shift) & 255) / 255.0 for shift in (0, 8, 16)] + [1.0]

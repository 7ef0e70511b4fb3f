"""Sizes and mesh files of shapes, as URDF and SDF both have them."""

import os
from dataclasses import replace

from bullet_sim.description.parts import Geometry

MESH_TYPES = (".obj", ".stl", ".dae")
THIN = 1e-3  # [m] of a side that is given as 0
MISSING = "meshes are missing and left out"


def usable_size(geometry, what, model):
    """The geometry with sizes above 0, or None; a plane or a mesh has none.

    A negative size counts without its sign, a side of 0 becomes thin; what has no size at all
    is left out.

    Args:
        geometry: Geometry.
        what: for messages.
        model: ModelDescription; gets the warning.
    """
    if not geometry.size or min(geometry.size) > 0:
        return geometry
    shown = f"{what} {geometry.kind} size is {geometry.size}, must be greater than 0"
    if not any(geometry.size):
        model.warn(f"{shown}; it is left out", "shapes have no size and are left out", what)
        return None
    sizes = tuple(abs(value) or THIN for value in geometry.size)
    model.warn(f"{shown}; it becomes {sizes}", "shapes have a size of 0 or less", what)
    return replace(geometry, size=sizes)


def mesh_geometry(uri, scale, what, resolve, model):
    """Mesh by URI, or None with a warning that names the file when it cannot be used."""
    try:
        path = resolve(uri)
    except ValueError as error:
        model.warn(f"{what}: mesh '{uri}' is not found ({error}); it is left out", MISSING, uri)
        return None
    if 0.0 in scale:
        model.warn(
            f"{what}: mesh '{uri}' has scale {scale}, must not be 0; it is left out",
            "meshes have scale 0 and are left out",
            uri,
        )
        return None
    if not os.path.isfile(path):
        model.warn(
            f"{what}: mesh file '{path}' (from '{uri}') does not exist; it is left out",
            MISSING,
            uri,
        )
        return None
    if os.path.splitext(path)[1].lower() not in MESH_TYPES:
        model.warn(
            f"{what}: mesh '{path}' is not one of {', '.join(MESH_TYPES)}; it is left out",
            f"meshes are not one of {', '.join(MESH_TYPES)} and are left out",
            uri,
        )
        return None
    return Geometry("mesh", path=path, scale=tuple(scale))

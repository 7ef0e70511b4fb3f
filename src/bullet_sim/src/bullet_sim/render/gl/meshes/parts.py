"""Mesh files -> triangles with normals, texture coordinates and materials, for upload."""

from dataclasses import dataclass

import numpy as np

from bullet_sim.meshes.looks import GREY, WHITE, picture_of, rgba
from bullet_sim.meshes.parts import check_corners, read_parts
from bullet_sim.render.gl.meshes.normals import crease_normals

NO_LIGHT = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Part:
    """Triangles of one material.

    Attributes:
        corners: (n, 8) float32: position [m], normal, texture coordinates.
        triangles: (m, 3) uint32, counter-clockwise seen from outside.
        color: RGBA 0..1.
        picture: Pillow image over the colour, or None.
        specular, emissive: RGB 0..1.
        double_sided: whether the inside is drawn, too.
    """

    corners: np.ndarray
    triangles: np.ndarray
    color: tuple = WHITE
    picture: object = None
    specular: tuple = NO_LIGHT
    emissive: tuple = NO_LIGHT
    double_sided: bool = False


def mesh_parts(geometry):
    """Parts of a mesh file, one for each material, scaled and mirrored as the geometry says.

    Args:
        geometry: Geometry that is a mesh.

    Raises:
        ModelError: it cannot be read or has no triangles.
    """
    scale = np.diag([*geometry.scale, 1.0])
    found = read_parts(geometry)
    shift = np.eye(4)
    if geometry.centered:
        places = [_placed(np.asarray(mesh.vertices, float), place) for mesh, place in found]
        low = np.min([corners.min(axis=0) for corners in places], axis=0)
        high = np.max([corners.max(axis=0) for corners in places], axis=0)
        shift[:3, 3] = -(low + high) / 2.0
    return [_part(mesh, scale @ shift @ place, geometry.path) for mesh, place in found]


def _placed(points, place):
    return points @ place[:3, :3].T + place[:3, 3]


def _part(mesh, place, path):
    """Part of a trimesh at a place."""
    given = mesh._cache["vertex_normals"] if "vertex_normals" in mesh._cache else None
    vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
    uv = getattr(mesh.visual, "uv", None)
    vertices = _placed(vertices, place)
    check_corners(vertices, path)
    if np.linalg.det(place[:3, :3]) < 0.0:  # mirroring turns it inside out
        faces = faces[:, ::-1]
    if given is not None and np.isfinite(given).all():
        turn = np.linalg.inv(place[:3, :3]).T
        normals = np.asarray(given, float) @ turn.T
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.where(lengths > 0.0, normals / np.where(lengths > 0.0, lengths, 1.0), 0.0)
        rows = _rows(vertices, normals, uv)
        triangles = faces
    else:
        normals = crease_normals(vertices, faces)
        chosen = faces.ravel()
        rows = _rows(vertices[chosen], normals, None if uv is None else uv[chosen])
        rows, triangles = _joined(rows)
    looks = _looks(mesh.visual, uv is not None)
    return Part(rows, np.ascontiguousarray(triangles, np.uint32), **looks)


def _rows(positions, normals, uv):
    rows = np.zeros((len(positions), 8), np.float32)
    rows[:, :3], rows[:, 3:6] = positions, normals
    if uv is not None and len(uv) == len(rows):
        rows[:, 6:] = np.nan_to_num(np.asarray(uv, float)[:, :2])
    return rows


def _joined(rows):
    """Rows without repetition, and the triangles of what were three rows each."""
    kept, place = np.unique(
        rows.view(np.dtype((np.void, rows.dtype.itemsize * 8))).ravel(), return_inverse=True
    )
    return kept.view(np.float32).reshape(-1, 8), place.reshape(-1, 3)


def _looks(visual, covered):
    """Keywords of a Part from the visual of a trimesh; covered: it has texture coordinates."""
    material = getattr(visual, "material", None)
    if visual is None or not visual.defined:
        return {"color": GREY}
    if material is None:
        return {"color": rgba(visual.main_color)}
    looks = {"color": rgba(material.main_color)}
    picture = picture_of(material)
    if picture is not None and covered:
        looks.update(picture=picture, color=WHITE[:3] + (looks["color"][3],))
    if hasattr(material, "glossiness"):  # of an MTL
        looks["specular"] = rgba(material.specular)[:3]
    emissive = getattr(material, "emissiveFactor", None)
    if emissive is not None:
        looks["emissive"] = tuple(float(value) for value in emissive[:3])
    looks["double_sided"] = bool(getattr(material, "doubleSided", False))
    return looks

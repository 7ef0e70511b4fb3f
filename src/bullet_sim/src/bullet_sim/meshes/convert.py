"""Writing meshes as OBJ files that PyBullet reads, with trimesh and Pillow loaded on demand."""

import os

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.meshes.box import box_sides
from bullet_sim.meshes.looks import GREY, WHITE, mean_color, open_picture, picture_of, rgba
from bullet_sim.meshes.parts import check_corners, read_parts

MAX_PICTURE = 2048  # [px] longest side of a picture


def convert(shape, signs, role, folder, faults=None):
    """Write a mesh file's parts into a folder.

    Args:
        shape: Shape whose geometry is a mesh; its texture goes over the mesh's materials, and
            so does its colour when it is painted.
        signs: three of +1 or -1: axes to mirror.
        role: 'visual': one part for each material; 'collision': one part.
        folder: where the files go.
        faults: list that takes what is wrong with its pictures, which are left out.

    Returns:
        List of dicts: file; color RGBA or None; textured, whether a picture covers it.

    Raises:
        ModelError: it cannot be read, is empty, or has numbers that are not finite.
    """
    geometry = shape.geometry
    with np.errstate(all="ignore"):  # corners that are not finite are found below
        meshes = _load(geometry, faults)
    for mesh in meshes:
        check_corners(np.asarray(mesh.vertices, float), geometry.path)
    if geometry.centered:
        low = np.min([mesh.vertices.min(axis=0) for mesh in meshes], axis=0)
        high = np.max([mesh.vertices.max(axis=0) for mesh in meshes], axis=0)
        for mesh in meshes:
            mesh.vertices = mesh.vertices - (low + high) / 2.0
    if role == "collision":
        path = os.path.join(folder, "part_0.obj")
        _write(path, meshes, signs)
        return [{"file": path, "color": None, "textured": False}]
    parts = []
    for number, mesh in enumerate(meshes):
        path = os.path.join(folder, f"part_{number}.obj")
        color, picture = _looks(mesh, shape)
        _write(path, [mesh], signs, _library(path, color, picture), picture is not None)
        parts.append({"file": path, "color": color, "textured": picture is not None})
    return parts


def _load(geometry, faults):
    """Trimeshes of a file in metres, transforms of its scene applied."""
    meshes = []
    for found, place in read_parts(geometry, faults):
        mesh = found.copy()
        mesh.apply_transform(place)
        meshes.append(mesh)
    return meshes


def _looks(mesh, shape):
    """(RGBA, Pillow picture or None) of a trimesh as part of a Shape."""
    visual = mesh.visual
    uv = getattr(visual, "uv", None)
    if shape.texture:
        if uv is None:
            return mean_color(shape.texture), None
        return WHITE, open_picture(shape.texture)
    if shape.painted or visual is None or not visual.defined:
        return shape.color or GREY, None
    material = getattr(visual, "material", None)
    if material is None:
        return rgba(visual.main_color), None
    picture = picture_of(material)
    if picture is not None and uv is not None:
        return WHITE, picture
    return rgba(material.main_color), None


def _save(picture, path):
    """Save a picture with sides that are multiples of 4: EGL draws others as stripes."""
    try:
        picture = picture.convert("RGB")
    except (OSError, ValueError, SyntaxError) as error:  # cut off, or broken within
        raise ModelError(f"a picture cannot be read: {error}") from error
    shrink = min(1.0, MAX_PICTURE / max(picture.size))
    size = tuple(max(4, 4 * round(side * shrink / 4)) for side in picture.size)
    if size != picture.size:
        picture = picture.resize(size)
    picture.save(path)


def _write(path, meshes, signs, head=(), covered=False):
    """Write meshes as one OBJ after the lines of `head`; covered: with texture coordinates."""
    lines, first = list(head), 1
    flip = np.prod(signs) < 0  # mirroring turns the normals inwards: reverse the triangles
    for mesh in meshes:
        corners = np.asarray(mesh.vertices, float) * signs
        normals = np.asarray(mesh.vertex_normals, float) * signs
        faces = np.asarray(mesh.faces)[:, :: -1 if flip else 1] + first
        lines += ["v {:.9g} {:.9g} {:.9g}".format(*tuple(row)) for row in corners]
        if covered:
            lines += [
                "vt {:.6g} {:.6g}".format(*tuple(row[:2])) for row in np.asarray(mesh.visual.uv)
            ]
        lines += ["vn {:.6g} {:.6g} {:.6g}".format(*tuple(row)) for row in np.nan_to_num(normals)]
        form = "f %d/%d/%d %d/%d/%d %d/%d/%d" if covered else "f %d//%d %d//%d %d//%d"
        each = 3 if covered else 2
        lines += [form % tuple(row) for row in np.repeat(faces, each, axis=1)]
        first += len(corners)
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def _library(path, color, picture=None):
    """Write the material library of an OBJ, and its picture; gives the lines that name it."""
    base = os.path.splitext(os.path.basename(path))[0]
    folder = os.path.dirname(path)
    lines = [
        "newmtl look",
        "Ka 1 1 1",
        "Kd {:g} {:g} {:g}".format(*tuple(color[:3])),
        f"d {color[3]:g}",
    ]
    if picture is not None:
        _save(picture, os.path.join(folder, f"{base}.png"))
        lines.append(f"map_Kd {base}.png")
    with open(os.path.join(folder, f"{base}.mtl"), "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    return [f"mtllib {base}.mtl", "usemtl look"]


def write_box(size, texture, folder):
    """Write a box of a size [m] with a picture on each side; returns parts as convert does."""
    path = os.path.join(folder, "part_0.obj")
    lines = _library(path, WHITE, open_picture(texture))
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    half = np.asarray(size, float) / 2.0
    for number, (normal, corners) in enumerate(box_sides()):
        lines += ["v {:.9g} {:.9g} {:.9g}".format(*tuple(corner * half)) for corner in corners]
        lines.append("vn {:g} {:g} {:g}".format(*tuple(normal)))
        corner = [f"{4 * number + k}/{k}/{number + 1}" for k in (1, 2, 3, 4)]
        lines += [
            f"f {corner[0]} {corner[1]} {corner[2]}",
            f"f {corner[0]} {corner[2]} {corner[3]}",
        ]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    return [{"file": path, "color": WHITE, "textured": True}]

"""Meshes and textures in the graphics memory; normals where files give none."""

import math
import os
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.meshes.prepare import CORNERS, box_sides
from bullet_sim.meshes.read import (
    GREY,
    WHITE,
    check_corners,
    image_of,
    mean_color,
    open_image,
    read_parts,
    rgba,
)

CREASE = math.radians(35.0)  # faces that meet at a sharper angle keep an edge between them


def crease_normals(vertices, faces, crease=CREASE):
    """Normal of each corner of each face: the mean over the faces there that bend less.

    Args:
        vertices: (n, 3).
        faces: (m, 3) int, counter-clockwise seen from outside.
        crease: [rad].

    Returns:
        (3 m, 3) float64 of length 1, corner by corner; faces without area have (0, 0, 1).
    """
    corners = vertices[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(areas, axis=1, keepdims=True)
    units = np.where(lengths > 0.0, areas / np.where(lengths > 0.0, lengths, 1.0), (0.0, 0.0, 1.0))
    _, place = np.unique(vertices[faces.ravel()], axis=0, return_inverse=True)
    order = np.argsort(place, kind="stable")
    counts = np.bincount(place)
    first = np.cumsum(counts) - counts
    partners = counts[place[order]]  # of each corner, with itself
    one = np.repeat(np.arange(len(order)), partners)
    offset = np.arange(len(one)) - np.repeat(np.cumsum(partners) - partners, partners)
    other = first[place[order]][one] + offset
    face_of_one, face_of_other = order[one] // 3, order[other] // 3
    near = np.einsum("ij,ij->i", units[face_of_one], units[face_of_other]) > math.cos(crease)
    sums = np.empty((len(order), 3))
    for axis in range(3):
        sums[:, axis] = np.bincount(
            order[one[near]], areas[face_of_other[near], axis], minlength=len(order)
        )
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    flat = np.repeat(units, 3, axis=0)
    return np.where(lengths > 0.0, sums / np.where(lengths > 0.0, lengths, 1.0), flat)


SIDES = 48  # of a cylinder, and around a sphere
RINGS = 24  # from pole to pole of a sphere


@lru_cache
def solid(kind):
    """Corners and triangles of a shape of size 1: an edge, a diameter of 2, a length of 1.

    Args:
        kind: 'box', 'cylinder' (along z) or 'sphere'.

    Returns:
        (n, 8) float32 position, normal, texture coordinates (right and up in the picture);
        (m, 3) uint32, counter-clockwise seen from outside.
    """
    corners, triangles = {"box": _box, "cylinder": _cylinder, "sphere": _sphere}[kind]()
    return np.asarray(corners, np.float32), np.asarray(triangles, np.uint32)


def _box():
    """Each side shows the whole picture, upright where the side stands."""
    corners, triangles = [], []
    for normal, places in box_sides():
        first = len(corners)
        for place, (a, b) in zip(places, CORNERS):
            corners.append([*place / 2.0, *normal, (a + 1) / 2.0, (b + 1) / 2.0])
        triangles += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return corners, triangles


def _cylinder():
    corners, triangles = [], []
    angles = np.linspace(0.0, 2.0 * np.pi, SIDES + 1)
    for angle in angles:
        x, y = np.cos(angle), np.sin(angle)
        along = angle / (2.0 * np.pi)
        corners += [[x, y, -0.5, x, y, 0.0, along, 0.0], [x, y, 0.5, x, y, 0.0, along, 1.0]]
    for side in range(SIDES):
        a = 2 * side
        triangles += [[a, a + 2, a + 3], [a, a + 3, a + 1]]
    for end in (1.0, -1.0):
        first = len(corners)
        for angle in angles[:-1]:
            x, y = np.cos(angle), np.sin(angle)
            corners.append([x, y, end / 2.0, 0.0, 0.0, end, 0.5 + x / 2.0, 0.5 + end * y / 2.0])
        for side in range(1, SIDES - 1):
            pair = (side, side + 1) if end > 0 else (side + 1, side)
            triangles.append([first, first + pair[0], first + pair[1]])
    return corners, triangles


def _sphere():
    corners, triangles = [], []
    for ring in range(RINGS + 1):
        polar = np.pi * ring / RINGS
        for side in range(SIDES + 1):
            angle = 2.0 * np.pi * side / SIDES
            x, y = np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle)
            z = np.cos(polar)
            corners.append([x, y, z, x, y, z, side / SIDES, 1.0 - ring / RINGS])
    width = SIDES + 1
    for ring in range(RINGS):
        for side in range(SIDES):
            a = ring * width + side
            b = a + width
            if ring > 0:
                triangles.append([a, b, a + 1])
            if ring < RINGS - 1:
                triangles.append([a + 1, b, b + 1])
    return corners, triangles


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
    picture = image_of(material)
    if picture is not None and covered:
        looks.update(picture=picture, color=WHITE[:3] + (looks["color"][3],))
    if hasattr(material, "glossiness"):  # of an MTL
        looks["specular"] = rgba(material.specular)[:3]
    emissive = getattr(material, "emissiveFactor", None)
    if emissive is not None:
        looks["emissive"] = tuple(float(value) for value in emissive[:3])
    looks["double_sided"] = bool(getattr(material, "doubleSided", False))
    return looks


MAX_PICTURE = 8192  # [px] longest side of a texture


class Mesh:
    """Triangles in the graphics memory.

    Attributes:
        vertices, indices: moderngl Buffers; corners as Part.corners.
        centre (3,), radius: of a sphere around it [m].
        low, high: (3,) of a box around it [m].
        count: of its triangles.
    """

    def __init__(self, gl, corners, triangles):
        self.vertices = gl.buffer(np.ascontiguousarray(corners).tobytes())
        self.indices = gl.buffer(np.ascontiguousarray(triangles).tobytes())
        used = corners[:, :3].astype(float)
        self.low, self.high = used.min(axis=0), used.max(axis=0)
        self.centre = (self.low + self.high) / 2.0
        self.radius = float(np.linalg.norm(used - self.centre, axis=1).max())
        self.count = len(triangles)


class Look:
    """One mesh with its material, as a visual shows it.

    Attributes:
        mesh: Mesh.
        texture: moderngl Texture or None.
        clear: whether the texture lets something through.
        part: Part whose material it is; of a solid, one of white without a picture.
    """

    def __init__(self, mesh, texture, clear, part):
        self.mesh, self.texture, self.clear, self.part = mesh, texture, clear, part


class Store:
    """Uploads of one context, kept while a scene uses them.

    Args:
        gl: moderngl.Context.
        anisotropy: of textures; 1: none.
    """

    def __init__(self, gl, anisotropy):
        self._gl, self._anisotropy = gl, anisotropy
        self._solids, self._files, self._pictures = {}, {}, {}
        self._used = set()

    def begin(self):
        """Begin to note what is used."""
        self._used = set()

    def drop_unused(self):
        """Free what was not asked for since begin()."""
        for table in (self._files, self._pictures):
            for key in [key for key in table if key not in self._used]:
                del table[key]

    def looks(self, shape):
        """Looks of a visual Shape, one for each material.

        Raises:
            ModelError: its mesh or its texture cannot be read.
        """
        geometry = shape.geometry
        if geometry.kind == "mesh":
            return self._covered(self._file(geometry), shape)
        kind = "box" if geometry.kind == "plane" else geometry.kind
        if kind not in self._solids:
            self._solids[kind] = Mesh(self._gl, *solid(kind))
        part = Part(None, None)
        return self._covered([Look(self._solids[kind], None, False, part)], shape)

    def _covered(self, looks, shape):
        if not shape.texture:
            return looks
        texture, clear = self._picture(shape.texture)
        found = []
        for look in looks:
            mapped = look.part.corners is None or look.part.corners[:, 6:].any()
            part = Part(None, None, WHITE if mapped else mean_color(shape.texture))
            found.append(Look(look.mesh, texture if mapped else None, clear and mapped, part))
        return found

    def _file(self, geometry):
        key = (
            geometry.path,
            _stamp(geometry.path),
            tuple(geometry.scale),
            geometry.submesh,
            geometry.centered,
        )
        self._used.add(key)
        if key not in self._files:
            looks = []
            for part in mesh_parts(geometry):
                texture, clear = None, False
                if part.picture is not None:
                    texture, clear = self._upload(part.picture)
                looks.append(
                    Look(Mesh(self._gl, part.corners, part.triangles), texture, clear, part)
                )
            self._files[key] = looks
        return self._files[key]

    def _picture(self, path):
        key = (path, _stamp(path))
        self._used.add(key)
        if key not in self._pictures:
            self._pictures[key] = self._upload(open_image(path, transparent=True))
        return self._pictures[key]

    def _upload(self, picture):
        """(Texture of a Pillow image with its mipmaps, whether it lets something through)."""
        veiled = "A" in picture.getbands() or "transparency" in picture.info
        picture = picture.convert("RGBA" if veiled else "RGB")
        shrink = min(1.0, MAX_PICTURE / max(picture.size))
        if shrink < 1.0:
            picture = picture.resize([max(1, round(side * shrink)) for side in picture.size])
        pixels = np.asarray(picture)[::-1]  # OpenGL's first row is the lowest
        clear = pixels.shape[2] == 4 and int(pixels[:, :, 3].min()) < 250
        texture = self._gl.texture(
            picture.size, pixels.shape[2], np.ascontiguousarray(pixels).tobytes(), alignment=1
        )
        texture.build_mipmaps()
        texture.filter = (self._gl.LINEAR_MIPMAP_LINEAR, self._gl.LINEAR)
        texture.anisotropy = self._anisotropy
        return texture, clear


def _stamp(path):
    try:
        return os.stat(path).st_mtime_ns
    except OSError as error:
        raise ModelError(f"file '{path}' cannot be read: {error.strerror}") from error

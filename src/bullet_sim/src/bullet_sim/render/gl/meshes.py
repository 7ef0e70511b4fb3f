"""Meshes and textures in the graphics memory; normals where files give none."""

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from bullet_sim.description.model import RGB, RGBA, Geometry, Shape
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
from bullet_sim.pose import Array

Rows = list[list[float]]
Triangles = list[list[int]]

CREASE = math.radians(35.0)  # faces that meet at a sharper angle have an edge between them


def crease_normals(vertices: Array, faces: Array) -> Array:
    """Normal of each corner of each face: the mean over the faces there within CREASE.

    Args:
        vertices: (n, 3).
        faces: (m, 3) int, counter-clockwise seen from outside.

    Returns:
        (3 m, 3) float64 of length 1, corner by corner; faces without area have (0, 0, 1).
    """
    corners = vertices[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    units = _normalised(areas, (0.0, 0.0, 1.0))
    _, point = np.unique(vertices[faces.ravel()], axis=0, return_inverse=True)
    order = np.argsort(point, kind="stable")
    counts = np.bincount(point)
    first = np.cumsum(counts) - counts
    partners = counts[point[order]]  # of each corner, with itself
    one = np.repeat(np.arange(len(order)), partners)
    offset = np.arange(len(one)) - np.repeat(np.cumsum(partners) - partners, partners)
    other = first[point[order]][one] + offset
    face_of_one, face_of_other = order[one] // 3, order[other] // 3
    near = np.einsum("ij,ij->i", units[face_of_one], units[face_of_other]) > math.cos(CREASE)
    sums = np.empty((len(order), 3))
    for axis in range(3):
        sums[:, axis] = np.bincount(
            order[one[near]], areas[face_of_other[near], axis], minlength=len(order)
        )
    return _normalised(sums, np.repeat(units, 3, axis=0))


def _normalised(vectors: Array, otherwise: Any) -> Array:
    """Vectors (n, 3) with length 1; `otherwise` where they have none."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(lengths > 0.0, vectors / np.where(lengths > 0.0, lengths, 1.0), otherwise)


SIDES = 48  # of a cylinder, and around a sphere
RINGS = 24  # from pole to pole of a sphere


@lru_cache
def solid(shape: str) -> tuple[Array, Array]:
    """Corners and triangles of a shape of size 1: an edge, a diameter of 2, a length of 1.

    Args:
        shape: 'box', 'cylinder' (along z) or 'sphere'.

    Returns:
        (n, 8) float32 position, normal, texture coordinates (right and up in the image);
        (m, 3) uint32, counter-clockwise seen from outside.
    """
    makers: dict[str, Callable[[], tuple[Rows, Triangles]]]
    makers = {"box": _box, "cylinder": _cylinder, "sphere": _sphere}
    corners, triangles = makers[shape]()
    return np.asarray(corners, np.float32), np.asarray(triangles, np.uint32)


def _box() -> tuple[Rows, Triangles]:
    """Each side shows the full image, upright where the side is vertical."""
    corners: Rows = []
    triangles: Triangles = []
    for normal, points in box_sides():
        first = len(corners)
        for point, (a, b) in zip(points, CORNERS):
            corners.append([*point / 2.0, *normal, (a + 1) / 2.0, (b + 1) / 2.0])
        triangles += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return corners, triangles


def _cylinder() -> tuple[Rows, Triangles]:
    corners: Rows = []
    triangles: Triangles = []
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


def _sphere() -> tuple[Rows, Triangles]:
    corners: Rows = []
    triangles: Triangles = []
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


BLACK: RGB = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Material:
    """How a surface reflects light.

    Attributes:
        image: Pillow image over the color.
        double_sided: whether the inside is rendered, too.
    """

    color: RGBA = WHITE
    image: Any = None
    specular: RGB = BLACK
    emissive: RGB = BLACK
    double_sided: bool = False


@dataclass(frozen=True)
class Part:
    """Triangles of one material.

    Attributes:
        corners: (n, 8) float32: position [m], normal, texture coordinates.
        triangles: (m, 3) uint32, counter-clockwise seen from outside.
    """

    corners: Array
    triangles: Array
    material: Material


def mesh_parts(geometry: Geometry) -> list[Part]:
    """Parts of a mesh file, one for each material, scaled and mirrored as the geometry has it.

    Raises:
        ModelError: it cannot be read or has no triangles.
    """
    scale = np.diag([*geometry.scale, 1.0])
    meshes = read_parts(geometry)
    shift = np.eye(4)
    if geometry.centered:
        points = [_transformed(np.asarray(mesh.vertices, float), pose) for mesh, pose in meshes]
        low = np.min([corners.min(axis=0) for corners in points], axis=0)
        high = np.max([corners.max(axis=0) for corners in points], axis=0)
        shift[:3, 3] = -(low + high) / 2.0
    return [_part(mesh, scale @ shift @ pose, geometry.path) for mesh, pose in meshes]


def _transformed(points: Array, transform: Array) -> Array:
    return points @ transform[:3, :3].T + transform[:3, 3]


def _part(mesh: Any, transform: Array, path: str) -> Part:
    """Part of a trimesh with a transform (4, 4)."""
    given = mesh._cache["vertex_normals"] if "vertex_normals" in mesh._cache else None
    vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
    uv = getattr(mesh.visual, "uv", None)
    vertices = _transformed(vertices, transform)
    check_corners(vertices, path)
    if np.linalg.det(transform[:3, :3]) < 0.0:  # mirroring turns it inside out
        faces = faces[:, ::-1]
    if given is not None and np.isfinite(given).all():
        rotation = np.linalg.inv(transform[:3, :3]).T
        normals = _normalised(np.asarray(given, float) @ rotation.T, 0.0)
        rows, triangles = _rows(vertices, normals, uv), faces
    else:
        normals = crease_normals(vertices, faces)
        corners = faces.ravel()
        rows = _rows(vertices[corners], normals, None if uv is None else uv[corners])
        rows, triangles = _joined(rows)
    material = _material(mesh.visual, uv is not None)
    return Part(rows, np.ascontiguousarray(triangles, np.uint32), material)


def _rows(positions: Array, normals: Array, uv: Any) -> Array:
    rows = np.zeros((len(positions), 8), np.float32)
    rows[:, :3], rows[:, 3:6] = positions, normals
    if uv is not None and len(uv) == len(rows):
        rows[:, 6:] = np.nan_to_num(np.asarray(uv, float)[:, :2])
    return rows


def _joined(rows: Array) -> tuple[Array, Array]:
    """Rows without repetition, and the triangles of what were three rows each."""
    unique, index = np.unique(
        rows.view(np.dtype((np.void, rows.dtype.itemsize * 8))).ravel(), return_inverse=True
    )
    return unique.view(np.float32).reshape(-1, 8), index.reshape(-1, 3)


def _material(visual: Any, has_uv: bool) -> Material:
    """Material of the visual of a trimesh, which may have texture coordinates."""
    material = getattr(visual, "material", None)
    if visual is None or not visual.defined:
        return Material(GREY)
    if material is None:
        return Material(rgba(visual.main_color))
    color, image = rgba(material.main_color), image_of(material) if has_uv else None
    if image is not None:
        color = (*WHITE[:3], color[3])
    specular = emissive = BLACK
    if hasattr(material, "glossiness"):  # of an MTL
        specular = rgba(material.specular)[:3]
    factors = getattr(material, "emissiveFactor", None)
    if factors is not None:
        r, g, b = (float(value) for value in factors[:3])
        emissive = r, g, b
    double_sided = bool(getattr(material, "doubleSided", False))
    return Material(color, image, specular, emissive, double_sided)


MAX_IMAGE_SIDE = 8192  # [px] of a texture


class Mesh:
    """Triangles in the graphics memory.

    Attributes:
        vertices, indices: moderngl Buffers; corners as Part.corners.
        centre (3,), radius: of a sphere around it [m].
        low, high: (3,) of a box around it [m].
        mapped: whether it has texture coordinates.
    """

    def __init__(self, gl: Any, corners: Array, triangles: Array) -> None:
        self.vertices = gl.buffer(np.ascontiguousarray(corners).tobytes())
        self.indices = gl.buffer(np.ascontiguousarray(triangles).tobytes())
        points = corners[:, :3].astype(float)
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        self.centre = (self.low + self.high) / 2.0
        self.radius = float(np.linalg.norm(points - self.centre, axis=1).max())
        self.mapped = bool(corners[:, 6:].any())


@dataclass(frozen=True, eq=False)
class Surface:
    """A mesh with its material, as a visual shows it.

    Attributes:
        texture: moderngl Texture, or None.
        translucent: whether the texture lets something through.
    """

    mesh: Mesh
    material: Material
    texture: Any = None
    translucent: bool = False


class AssetCache:
    """Meshes and textures of one context, stored while a scene uses them.

    Args:
        gl: moderngl.Context.
        anisotropy: of textures; 1: none.
    """

    def __init__(self, gl: Any, anisotropy: float) -> None:
        self._gl, self._anisotropy = gl, anisotropy
        self._solids: dict[str, Mesh] = {}
        self._files: dict[Any, list[Surface]] = {}
        self._textures: dict[Any, tuple[Any, bool]] = {}
        self._used: set[Any] = set()

    def start_scene(self) -> None:
        """Start to note what is used."""
        self._used = set()

    def drop_unused(self) -> None:
        """Free what was not requested since start_scene()."""
        self._files = {key: self._files[key] for key in self._files if key in self._used}
        self._textures = {key: self._textures[key] for key in self._textures if key in self._used}

    def surfaces(self, shape: Shape) -> list[Surface]:
        """Surfaces of a visual Shape, one for each material.

        Raises:
            ModelError: its mesh or its texture cannot be read.
        """
        geometry = shape.geometry
        if geometry.kind == "mesh":
            surfaces = self._file(geometry)
        else:
            solid_type = "box" if geometry.kind == "plane" else geometry.kind
            if solid_type not in self._solids:
                self._solids[solid_type] = Mesh(self._gl, *solid(solid_type))
            surfaces = [Surface(self._solids[solid_type], Material())]
        if not shape.texture:
            return surfaces
        texture, translucent = self._texture(shape.texture)
        return [
            Surface(surface.mesh, Material(), texture, translucent)
            if surface.mesh.mapped
            else Surface(surface.mesh, Material(mean_color(shape.texture)))
            for surface in surfaces
        ]

    def _file(self, geometry: Geometry) -> list[Surface]:
        key = (
            geometry.path,
            _modified(geometry.path),
            tuple(geometry.scale),
            geometry.submesh,
            geometry.centered,
        )
        self._used.add(key)
        if key not in self._files:
            surfaces = []
            for part in mesh_parts(geometry):
                image = part.material.image
                texture, translucent = (None, False) if image is None else self._upload(image)
                mesh = Mesh(self._gl, part.corners, part.triangles)
                surfaces.append(Surface(mesh, part.material, texture, translucent))
            self._files[key] = surfaces
        return self._files[key]

    def _texture(self, path: str) -> tuple[Any, bool]:
        key = (path, _modified(path))
        self._used.add(key)
        if key not in self._textures:
            self._textures[key] = self._upload(open_image(path, transparent=True))
        return self._textures[key]

    def _upload(self, image: Any) -> tuple[Any, bool]:
        """(Texture of a Pillow image with its mipmaps, whether it lets something through)."""
        has_alpha = "A" in image.getbands() or "transparency" in image.info
        image = image.convert("RGBA" if has_alpha else "RGB")
        shrink = min(1.0, MAX_IMAGE_SIDE / max(image.size))
        if shrink < 1.0:
            image = image.resize([max(1, round(side * shrink)) for side in image.size])
        pixels = np.asarray(image)[::-1]  # OpenGL's first row is the lowest
        translucent = pixels.shape[2] == 4 and int(pixels[:, :, 3].min()) < 250
        texture = self._gl.texture(
            image.size, pixels.shape[2], np.ascontiguousarray(pixels).tobytes(), alignment=1
        )
        texture.build_mipmaps()
        texture.filter = (self._gl.LINEAR_MIPMAP_LINEAR, self._gl.LINEAR)
        texture.anisotropy = self._anisotropy
        return texture, translucent


def _modified(path: str) -> int:
    """Time of a file's last change [ns]."""
    try:
        return os.stat(path).st_mtime_ns
    except OSError as error:
        raise ModelError(f"file '{path}' cannot be read: {error.strerror}") from error

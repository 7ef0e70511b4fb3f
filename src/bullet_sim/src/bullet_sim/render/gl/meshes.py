"""Meshes and textures in the graphics memory; normals where files give none."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from typing import Any

import cv2
import numpy as np

from bullet_sim.description.model import Geometry, Layer, Shape, TextureMapping
from bullet_sim.errors import ModelError
from bullet_sim.meshes import terrain
from bullet_sim.meshes.looks import Look, look_of
from bullet_sim.meshes.read import check_corners, open_image, read_parts
from bullet_sim.meshes.solids import solid
from bullet_sim.pose import Array

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
    units = _normalized(areas, (0.0, 0.0, 1.0))
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
    return _normalized(sums, np.repeat(units, 3, axis=0))


def _normalized(vectors: Array, otherwise: Any) -> Array:
    """Vectors (n, 3) with length 1; `otherwise` where they have none."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(lengths > 0.0, vectors / np.where(lengths > 0.0, lengths, 1.0), otherwise)


SIDES, RINGS = 48, 24  # around cylinders and spheres; from pole to pole of a sphere


@dataclass(frozen=True)
class Part:
    """Triangles of one material.

    Attributes:
        corners: (n, 8) float32: position [m], normal, texture coordinates.
        triangles: (m, 3) uint32, counter-clockwise seen from outside.
        look: of the file; None: it has no material.
    """

    corners: Array
    triangles: Array
    look: Look | None


def mesh_parts(geometry: Geometry) -> list[Part]:
    """Parts of a mesh file, one for each material, scaled and mirrored as the geometry has it.

    Raises:
        ModelError: it cannot be read or has no triangles.
    """
    scale = np.diag([*geometry.scale, 1.0])
    return [_part(mesh, scale @ pose, geometry.path) for mesh, pose in read_parts(geometry)]


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
        normals = _normalized(np.asarray(given, float) @ rotation.T, 0.0)
        rows, triangles = _rows(vertices, normals, uv), faces
    else:
        normals = crease_normals(vertices, faces)
        corners = faces.ravel()
        rows = _rows(vertices[corners], normals, None if uv is None else uv[corners])
        rows, triangles = _joined(rows)
    look = look_of(mesh)
    if look is not None and look.image is not None and uv is None:
        look = replace(look, image=None)
    return Part(rows, np.ascontiguousarray(triangles, np.uint32), look)


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


MAX_IMAGE_SIDE = 8192  # [px] of a texture
MIPMAPS = 5  # smaller images of a texture, as in Gazebo: a line far away does not become gray


class Mesh:
    """Triangles in the graphics memory.

    Attributes:
        vertices, indices: moderngl Buffers; corners as Part.corners.
        center (3,), radius: of a sphere around it [m].
        low, high: (3,) of a box around it [m].
        mapped: whether it has texture coordinates.
    """

    def __init__(self, gl: Any, corners: Array, triangles: Array) -> None:
        self.vertices = gl.buffer(np.ascontiguousarray(corners).tobytes())
        self.indices = gl.buffer(np.ascontiguousarray(triangles).tobytes())
        points = corners[:, :3].astype(float)
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        self.center = (self.low + self.high) / 2.0
        self.radius = float(np.linalg.norm(points - self.center, axis=1).max())
        self.mapped = bool(corners[:, 6:].any())


@dataclass(frozen=True, eq=False)
class Surface:
    """A mesh with its material, as a visual shows it.

    Attributes:
        look: of the mesh's file; None: it has no material.
        texture: moderngl Texture, or None.
        layers: texture, operation and matrix (3, 3) float32 bytes from the mesh's texture
            coordinates to its own, of each further image.
        normals: Texture of the normal map, or None.
    """

    mesh: Mesh
    look: Look | None = None
    texture: Any = None
    layers: tuple[tuple[Any, str, bytes], ...] = ()
    normals: Any = None


_CORNERS_AND_TRIANGLES = attrgetter("corners", "triangles")  # of a Part


class AssetCache:
    """Meshes and textures of one context, stored while a scene uses them.

    Args:
        gl: moderngl.Context.
        anisotropy: maximum of textures; 1: none.
    """

    def __init__(self, gl: Any, anisotropy: float) -> None:
        self._gl, self._anisotropy = gl, anisotropy
        self._solids: dict[Any, Mesh] = {}
        self._files: dict[Any, list[tuple[Part, Any]]] = {}
        self._meshes: dict[Any, Mesh] = {}
        self._textures: dict[Any, Any] = {}
        self._used: set[Any] = set()

    def start_scene(self) -> None:
        """Start to note what is used."""
        self._used = set()

    def drop_unused(self) -> None:
        """Free what was not requested since start_scene()."""
        caches: tuple[dict[Any, Any], ...] = (self._files, self._meshes, self._textures)
        for cache in caches:
            for key in [key for key in cache if key not in self._used]:
                del cache[key]

    def surfaces(self, shape: Shape) -> list[Surface]:
        """Surfaces of a visual Shape, one for each material.

        Raises:
            ModelError: its mesh or its texture cannot be read.
        """
        geometry, mapping = shape.geometry, shape.finish.mapping
        transform = mapping.transform if shape.texture else ()
        if geometry.relief is not None:
            relief = geometry.relief
            fields = relief.path, relief.size, relief.sampling
            name = ("relief", *fields, _modified(relief.path), transform)
            made = self._made(name, lambda: terrain.relief(*fields))
            surfaces = [Surface(made)]
        elif geometry.kind == "mesh":
            surfaces = self._file(geometry, transform)
        elif geometry.kind == "road":
            of_road = ("road", geometry.size, geometry.points, transform)
            made = self._made(of_road, lambda: terrain.road(geometry.points, *geometry.size))
            surfaces = [Surface(made)]
        else:
            key = ("plane" if geometry.flat else geometry.kind, transform)
            if key not in self._solids:
                self._solids[key] = self._mesh(*solid(key[0], SIDES, RINGS), transform)
            surfaces = [Surface(self._solids[key])]
        if not shape.painted and not shape.texture:
            return surfaces
        texture = self._texture(shape.texture, mapping) if shape.texture else None
        layers = self._layers(shape.finish.layers, transform)
        file = shape.finish.normal_map
        normals = self._texture(file, TextureMapping()) if file else None
        return [
            Surface(surface.mesh, None, texture, layers, normals)
            if surface.mesh.mapped
            else Surface(surface.mesh)
            for surface in surfaces
        ]

    def _made(self, name: Any, make: Callable[[], tuple[Array, Array]]) -> Mesh:
        """The Mesh of corners (n, 8) and triangles; the last of the name is the transform."""
        self._used.add(name)
        if name not in self._meshes:
            self._meshes[name] = self._mesh(*make(), name[-1])
        return self._meshes[name]

    def _mesh(self, corners: Array, triangles: Array, transform: tuple[float, ...]) -> Mesh:
        corners = transformed_uv(corners.astype(np.float32), transform)
        return Mesh(self._gl, corners, triangles.astype(np.uint32))

    def _layers(
        self, layers: tuple[Layer, ...], transform: tuple[float, ...]
    ) -> tuple[tuple[Any, str, bytes], ...]:
        """As Surface.layers.

        Args:
            transform: of the mesh's texture coordinates, see TextureMapping.
        """
        undone = np.linalg.inv(_matrix(transform))
        return tuple(
            (
                self._texture(layer.path, layer.mapping),
                layer.operation,
                _layer_matrix(layer, undone).T.astype(np.float32).tobytes(),
            )
            for layer in layers
        )

    def _file(self, geometry: Geometry, transform: tuple[float, ...]) -> list[Surface]:
        key = (
            geometry.path,
            _modified(geometry.path),
            tuple(geometry.scale),
            geometry.submesh,
            geometry.centered,
        )
        self._used.add(key)
        if key not in self._files:
            self._files[key] = [
                (
                    part,
                    None
                    if part.look is None or part.look.image is None
                    else self._upload(part.look.image, TextureMapping()),
                )
                for part in mesh_parts(geometry)
            ]
        surfaces = []
        for index, (part, texture) in enumerate(self._files[key]):
            made = partial(_CORNERS_AND_TRIANGLES, part)
            mesh = self._made((*key, index, transform), made)
            surfaces.append(Surface(mesh, part.look, texture))
        return surfaces

    def _texture(self, path: str, mapping: TextureMapping) -> Any:
        key = (path, _modified(path), replace(mapping, transform=()))
        self._used.add(key)
        if key not in self._textures:
            self._textures[key] = self._upload(open_image(path, transparent=True), mapping)
        return self._textures[key]

    def _upload(self, image: Any, mapping: TextureMapping) -> Any:
        """Texture of a Pillow image with its mipmaps."""
        has_alpha = "A" in image.getbands() or "transparency" in image.info
        image = image.convert("RGBA" if has_alpha else "RGB")
        shrink = min(1.0, MAX_IMAGE_SIDE / max(image.size))
        if shrink < 1.0:
            image = image.resize([max(1, round(side * shrink)) for side in image.size])
        pixels = np.asarray(image)[::-1]  # OpenGL's first row is the lowest
        texture = self._gl.texture(
            image.size, pixels.shape[2], np.ascontiguousarray(pixels).tobytes(), alignment=1
        )
        levels = min(MIPMAPS, max(image.size).bit_length() - 1)
        texture.build_mipmaps(max_level=levels)
        for level in range(1, levels + 1):  # a driver's own are up to 4 of 255 too bright
            size = (max(1, image.width >> level), max(1, image.height >> level))
            small = cv2.resize(np.ascontiguousarray(pixels), size, interpolation=cv2.INTER_AREA)
            texture.write(small.tobytes(), level=level, alignment=1)
        linear, nearest = self._gl.LINEAR, self._gl.NEAREST
        texture.filter = (self._gl.LINEAR_MIPMAP_LINEAR, linear)
        if mapping.filtering == "nearest":
            texture.filter = (nearest, nearest)
        texture.anisotropy = min(float(mapping.anisotropy), self._anisotropy)
        texture.repeat_x = texture.repeat_y = mapping.wrap != "clamp"
        return texture


def _layer_matrix(layer: Layer, undone: Array) -> Array:
    """(3, 3) from the mesh's texture coordinates to the layer's; the last row has its blend: height
    and 1 / distance [1/m]."""
    matrix = _matrix(layer.mapping.transform) @ undone
    matrix[2] = layer.blend[0], 1.0 / max(layer.blend[1], 1e-6), 1.0
    return matrix


def _matrix(transform: tuple[float, ...]) -> Array:
    """(3, 3) of TextureMapping.transform."""
    matrix = np.eye(3)
    if transform:
        matrix[:2] = np.reshape(transform, (2, 3))
    return matrix


def transformed_uv(corners: Array, transform: tuple[float, ...]) -> Array:
    """Corners (n, 8) with the texture coordinates of TextureMapping.transform."""
    if not transform:
        return corners
    matrix = _matrix(transform)
    corners = corners.copy()
    corners[:, 6:] = corners[:, 6:] @ matrix[:2, :2].T + matrix[:2, 2]
    return corners


def _modified(path: str) -> int:
    """Time of a file's last change [ns]."""
    try:
        return os.stat(path).st_mtime_ns
    except OSError as error:
        raise ModelError(f"file '{path}' cannot be read: {error.strerror}") from error

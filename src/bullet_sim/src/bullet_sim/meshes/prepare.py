"""Mesh files checked, and converted to what PyBullet loads correctly.

Mesh files and textured shapes -> files that PyBullet reads correctly: OBJ, one material each.
PyBullet reads binary STL and OBJ with one material. Its DAE reader ignores materials and units, it
reads no ASCII STL, mirrored meshes are inside out, an OBJ is rendered in one color however many it
has and black without any, and a broken file can crash the process. So every file is checked, and
other files are rewritten with trimesh (loaded on demand) into a folder next to the prepared URDF,
once for each content.

As in Gazebo and rviz, a DAE's <unit> counts and its <up_axis> does not.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Callable, Dict

import numpy as np

from bullet_sim.description.lump import LumpedModel
from bullet_sim.description.model import RGBA, Geometry, Shape
from bullet_sim.errors import ModelError
from bullet_sim.files import read_file
from bullet_sim.meshes import terrain
from bullet_sim.meshes.looks import rgba
from bullet_sim.meshes.read import (
    GREY,
    MAX_SIZE,
    WHITE,
    check_corners,
    image_of,
    mean_color,
    open_image,
    opened,
    read_parts,
)
from bullet_sim.meshes.solids import box_sides
from bullet_sim.meshes.stl import binary_count, read_stl

if TYPE_CHECKING:
    import trimesh
    from PIL import Image

Part = Dict[str, Any]  # a converted file: file; color RGBA or None; textured
Warn = Callable[[str, str, str], None]  # message, cause, item, see ReadWarning

_BAD_NUMBER = re.compile(rb"^[ \t]*v[nt]?\s[^\n]*?(?:nan|inf)", re.MULTILINE | re.IGNORECASE)
_VERTEX = re.compile(rb"^[ \t]*v\s", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f[ \t]+([^\n]*)$", re.MULTILINE)
_MATERIAL = re.compile(rb"^[ \t]*usemtl[ \t]+(\S+)", re.MULTILINE)
_LIBRARY = re.compile(rb"^[ \t]*mtllib[ \t]+(\S[^\n]*)$", re.MULTILINE)
_IMAGE = re.compile(r"^[ \t]*map_Kd[ \t]+(\S[^\n]*)$", re.MULTILINE)


def mesh_type(path: str, data: bytes) -> str:
    """'obj', 'stl' (binary), 'ascii stl' or 'dae'."""
    suffix = os.path.splitext(path)[1].lower()
    if suffix == ".stl":
        return "stl" if binary_count(data) is not None else "ascii stl"
    return suffix[1:]


def mesh_error(path: str, file_type: str, data: bytes) -> str:
    """Reason why PyBullet must not read a file, or ''; DAE and ASCII STL are checked later."""
    if not data:
        return f"mesh '{path}' is empty"
    if file_type == "stl":
        return _stl_error(path, data)
    return _obj_error(path, data) if file_type == "obj" else ""


def _stl_error(path: str, data: bytes) -> str:
    corners = read_stl(data)
    if not len(corners):
        return f"mesh '{path}' has no triangles"
    if np.isfinite(corners).all() and np.abs(corners).max() <= MAX_SIZE:
        return ""
    return f"mesh '{path}' has corners that are no numbers or beyond {MAX_SIZE:g} m"


def _obj_error(path: str, data: bytes) -> str:
    if _BAD_NUMBER.search(data):
        return f"mesh '{path}' has corners that are no numbers"
    count = len(_VERTEX.findall(data))
    faces = b" ".join(_FACE.findall(data)).split()
    if not faces or not count:
        return f"mesh '{path}' has no faces"
    try:
        used = np.array([int(face.split(b"/", 1)[0]) for face in faces])
    except ValueError:
        return f"mesh '{path}' has a face that is no list of numbers"
    invalid = used[(used > count) | (used < -count) | (used == 0)]
    if not len(invalid):
        return ""
    return f"mesh '{path}' has {count} corners, but a face names number {invalid[0]}"


def loads_correctly(shape: Shape, file_type: str, data: bytes) -> bool:
    """Whether PyBullet loads and renders a mesh file correctly without conversion.

    Not when it is mirrored or only a part of it is used. An OBJ needs one material, in a library
    that exists: with none it is black, and of several only one is used; the
    description's color does not replace it.
    """
    geometry = shape.geometry
    if min(geometry.scale) < 0 or geometry.submesh or file_type not in ("obj", "stl"):
        return False
    if file_type == "stl":
        return True
    libraries = _libraries(geometry.path, data)
    if shape.painted or len(set(_MATERIAL.findall(data))) != 1 or not libraries:
        return False
    folder = os.path.dirname(geometry.path)
    return all(
        _is_readable(image) for library in libraries for image in _image_files(library, folder)
    )


def _libraries(path: str, data: bytes) -> list[str]:
    """Existing material libraries that an OBJ names."""
    folder = os.path.dirname(path)
    names = (library.strip().decode(errors="replace") for library in _LIBRARY.findall(data))
    return [file for file in (os.path.join(folder, name) for name in names) if os.path.isfile(file)]


def _image_files(library: str, folder: str) -> list[str]:
    """Existing image files of a material library; paths are relative to the OBJ's folder."""
    text = read_file(library, "material library", "text_bytes").decode(errors="replace")
    names = [name.split()[-1] for name in _IMAGE.findall(text)]
    files = (os.path.join(folder, name) for name in names)
    return [file for file in files if os.path.isfile(file)]


def _is_readable(image: str) -> bool:
    try:
        with opened(image):
            return True
    except ModelError:
        return False


MAX_IMAGE_SIDE = 2048  # [px]


def convert(
    shape: Shape, signs: tuple[int, ...], role: str, folder: str, notes: list[str] | None = None
) -> list[Part]:
    """Write a mesh file's parts into a folder.

    Args:
        shape: a mesh; its texture replaces the mesh's materials, and so does its color when it is
            painted.
        signs: three of +1 or -1: axes to mirror.
        role: 'visual': one part for each material; 'collision': one part.
        notes: gets sentences about its images that are left out, and about instances.

    Returns:
        List of dicts: file; color RGBA or None; textured, whether it has an image.

    Raises:
        ModelError: it cannot be read, is empty, or has numbers that are not finite.
    """
    geometry = shape.geometry
    meshes = []
    for part, transform in read_parts(geometry, notes, role == "collision"):
        meshes.append(mesh := part.copy())
        with np.errstate(all="ignore"):  # corners that are not finite are an error
            mesh.apply_transform(transform)
        check_corners(np.asarray(mesh.vertices, float), geometry.path)
    if role == "collision":
        path = os.path.join(folder, "part_0.obj")
        _write(path, meshes, signs)
        return [{"file": path, "color": None, "textured": False}]
    parts = []
    for index, mesh in enumerate(meshes):
        path = os.path.join(folder, f"part_{index}.obj")
        color, image = _appearance(mesh, shape)
        _write(path, [mesh], signs, _library(path, color, image), image is not None)
        parts.append({"file": path, "color": color, "textured": image is not None})
    return parts


def _appearance(mesh: trimesh.Trimesh, shape: Shape) -> tuple[RGBA, Image.Image | None]:
    """(RGBA, Pillow image or None) of a trimesh as part of a Shape."""
    visual = mesh.visual
    uv = getattr(visual, "uv", None)
    if shape.texture:
        if uv is None:
            return mean_color(shape.texture), None
        return WHITE, open_image(shape.texture)
    if shape.painted or visual is None or not visual.defined:
        return shape.color or GREY, None
    material = getattr(visual, "material", None)
    if material is None:
        return rgba(visual.main_color), None
    image = image_of(material)
    if image is not None and uv is not None:
        return WHITE, image
    return rgba(material.main_color), None


def _save(image: Image.Image, path: str) -> None:
    """Save an image, smaller if a side is longer than MAX_IMAGE_SIDE."""
    try:
        image = image.convert("RGB")
    except (OSError, ValueError, SyntaxError) as error:  # truncated or damaged
        raise ModelError(f"an image cannot be read: {error}") from error
    image.thumbnail((MAX_IMAGE_SIDE, MAX_IMAGE_SIDE))
    image.save(path)


def _write(
    path: str,
    meshes: list[trimesh.Trimesh],
    signs: tuple[int, ...],
    head: Sequence[str] = (),
    textured: bool = False,
) -> None:
    """Write meshes as one OBJ after the lines of `head`; textured: with texture coordinates."""
    lines, first = list(head), 1
    flip = np.prod(signs) < 0  # mirroring flips the normals inwards: reverse the triangles
    for mesh in meshes:
        corners = np.asarray(mesh.vertices, float) * signs
        normals = np.asarray(mesh.vertex_normals, float) * signs
        faces = np.asarray(mesh.faces)[:, :: -1 if flip else 1] + first
        lines += ["v {:.9g} {:.9g} {:.9g}".format(*tuple(row)) for row in corners]
        if textured:
            lines += [
                "vt {:.6g} {:.6g}".format(*tuple(row[:2])) for row in np.asarray(mesh.visual.uv)
            ]
        lines += ["vn {:.6g} {:.6g} {:.6g}".format(*tuple(row)) for row in np.nan_to_num(normals)]
        template = "f %d/%d/%d %d/%d/%d %d/%d/%d" if textured else "f %d//%d %d//%d %d//%d"
        repeats = 3 if textured else 2
        lines += [template % tuple(row) for row in np.repeat(faces, repeats, axis=1)]
        first += len(corners)
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def _copy(source: str, path: str) -> None:
    """Copy an image file as _save writes it; a PNG that can stay as it is is not written anew."""
    with opened(source) as header:
        stays = (header.format, header.mode) == ("PNG", "RGB") and max(
            header.size
        ) <= MAX_IMAGE_SIDE
    image = open_image(source)  # which fails if it is damaged
    if stays:
        shutil.copyfile(source, path)
    else:
        _save(image, path)


def _library(path: str, color: RGBA, image: Image.Image | str | None = None) -> list[str]:
    """Write the material library of an OBJ, and its image; returns the lines that refer to it.

    Args:
        image: Pillow's, or the path of a file.
    """
    base = os.path.splitext(os.path.basename(path))[0]
    folder = os.path.dirname(path)
    lines = [
        "newmtl look",
        "Ka 1 1 1",
        "Kd {:g} {:g} {:g}".format(*tuple(color[:3])),
        f"d {color[3]:g}",
    ]
    if image is not None:
        (_copy if isinstance(image, str) else _save)(image, os.path.join(folder, f"{base}.png"))
        lines.append(f"map_Kd {base}.png")
    with open(os.path.join(folder, f"{base}.mtl"), "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    return [f"mtllib {base}.mtl", "usemtl look"]


def write_box(size: Sequence[float], texture: str, folder: str) -> list[Part]:
    """Write a box of a size [m] with an image on each side; returns parts as convert does."""
    path = os.path.join(folder, "part_0.obj")
    lines = _library(path, WHITE, texture)
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    half = np.asarray(size, float) / 2.0
    for index, (normal, corners) in enumerate(box_sides()):
        lines += ["v {:.9g} {:.9g} {:.9g}".format(*tuple(corner * half)) for corner in corners]
        lines.append("vn {:g} {:g} {:g}".format(*tuple(normal)))
        corner = [f"{4 * index + k}/{k}/{index + 1}" for k in (1, 2, 3, 4)]
        lines += [
            f"f {corner[0]} {corner[1]} {corner[2]}",
            f"f {corner[0]} {corner[2]} {corner[3]}",
        ]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    return [{"file": path, "color": WHITE, "textured": True}]


def prepare_meshes(lumped: LumpedModel, folder: str, warn: Warn) -> dict[str, list[Shape]]:
    """Replace the meshes and textures of a LumpedModel in place by files that PyBullet reads.

    Args:
        folder: for converted files; they go to <folder>/meshes.
        warn: called for each shape that cannot be used.

    Returns:
        Link name -> the visuals that can be used, unchanged but for heightmaps and polylines, which
        are meshes.
    """
    cache = _MeshCache(os.path.join(folder, "meshes"), warn)
    usable: dict[str, list[Shape]] = {name: [] for name in lumped.links}
    for link in lumped.links.values():
        for shapes, convert in ((link.visuals, cache.visual), (link.collisions, cache.collision)):
            converted = []
            for shape in shapes:
                try:
                    files = convert(shape)
                    converted += files
                    if shapes is link.visuals:
                        seen = files if shape.geometry.kind == "polyline" else [shape]
                        if shape.geometry.kind == "heightmap":  # with its images
                            seen = [replace(shape, geometry=files[0].geometry)]
                        usable[link.name] += seen
                except ModelError as error:
                    label = f"{shape.name or 'a shape'} of link '{shape.link or link.name}'"
                    noun = "heightmaps" if shape.geometry.kind == "heightmap" else "meshes"
                    warn(
                        f"{label} is left out: {error}",
                        f"{noun} cannot be used and are left out",
                        shape.geometry.path or label,
                    )
            shapes[:] = converted
    return usable


class _MeshCache:
    """Converted files in one folder, by content."""

    def __init__(self, folder: str, warn: Warn) -> None:
        self._folder, self._warn = folder, warn

    def visual(self, shape: Shape) -> list[Shape]:
        """Shapes that replace one visual: one for each material."""
        geometry = shape.geometry
        if geometry.kind in _GENERATORS:
            color = mean_color(shape.texture) if shape.texture else shape.color
            return [replace(shape, color=color, texture="", geometry=self._generated(geometry))]
        if geometry.kind != "mesh":
            return [self._textured(shape)] if shape.texture else [shape]
        data, file_type = _read(geometry)
        if loads_correctly(shape, file_type, data) and not shape.texture:
            return [shape]
        notes: list[str] = []
        parts = self._converted(geometry, data, "visual", shape, notes)
        for note in dict.fromkeys(notes):
            path = geometry.path
            self._warn(f"mesh '{path}': {note}", "meshes are not what their files say", path)
        return [
            replace(
                shape,
                texture="",
                geometry=_scaled_mesh(part["file"], geometry),
                color=part["color"],
            )
            for part in parts
        ]

    def collision(self, shape: Shape) -> list[Shape]:
        """Shapes that replace one collision; materials are ignored."""
        geometry = shape.geometry
        if geometry.kind in _GENERATORS:
            return [replace(shape, geometry=self._generated(geometry))]
        if geometry.kind != "mesh":
            return [shape]
        data, file_type = _read(geometry)
        if file_type in ("obj", "stl") and min(geometry.scale) > 0 and not geometry.submesh:
            return [shape]
        parts = self._converted(geometry, data, "collision", shape)
        return [replace(shape, geometry=_scaled_mesh(part["file"], geometry)) for part in parts]

    def _generated(self, geometry: Geometry) -> Geometry:
        """The mesh of a heightmap or a polyline."""
        data = read_file(geometry.path, "mesh", "mesh_bytes") if geometry.path else b""
        described = (geometry.kind, geometry.size, geometry.outlines, geometry.sampling)
        key = _key(data, repr(described))

        def make(folder: str) -> list[Part]:
            path = os.path.join(folder, "shape.obj")
            terrain.write_obj(path, *_GENERATORS[geometry.kind](geometry))
            return [{"file": path, "color": None}]

        relief = geometry if geometry.kind == "heightmap" else None
        return Geometry("mesh", path=self._cached(key, make)[0]["file"], relief=relief)

    def _textured(self, shape: Shape) -> Shape:
        """A box with a texture on its sides; other shapes get the texture's mean color."""
        kind, size = shape.geometry.kind, shape.geometry.size
        if kind != "box":
            return replace(shape, texture="", color=mean_color(shape.texture))
        key = _key(read_file(shape.texture, "image", "mesh_bytes"), repr(size))
        parts = self._cached(key, lambda folder: write_box(size, shape.texture, folder))
        return replace(
            shape,
            texture="",
            color=parts[0]["color"],
            geometry=Geometry("mesh", path=parts[0]["file"]),
        )

    def _converted(
        self,
        geometry: Geometry,
        data: bytes,
        role: str,
        shape: Shape,
        notes: list[str] | None = None,
    ) -> list[Part]:
        signs = tuple(1 if factor > 0 else -1 for factor in geometry.scale)
        appearance = (shape.texture, shape.color, shape.painted) if role == "visual" else ()
        key = _key(
            data,
            repr((geometry.path, signs, geometry.submesh, geometry.centered, role, appearance)),
        )
        return self._cached(key, lambda folder: convert(shape, signs, role, folder, notes))

    def _cached(self, key: str, make: Callable[[str], list[Part]]) -> list[Part]:
        """Parts from the cache, or made now; each a dict of file, color, textured."""
        folder = os.path.join(self._folder, key)
        index = os.path.join(folder, "parts.json")
        if not os.path.isfile(index):
            os.makedirs(folder, exist_ok=True)
            parts = make(folder)
            with open(index, "w", encoding="utf-8") as file:
                json.dump(parts, file)
        with open(index, encoding="utf-8") as file:
            parts = json.load(file)
        return [dict(part, color=part["color"] and tuple(part["color"])) for part in parts]


_GENERATORS: dict[str, Callable[[Geometry], Any]] = {
    "heightmap": lambda shape: terrain.heightmap(shape.path, shape.size, shape.sampling),
    "polyline": lambda shape: terrain.extruded(shape.outlines, shape.size[0]),
}


_SOUND: set[tuple[str, int, int]] = set()  # meshes without an error: path, length, hash


def _read(geometry: Geometry) -> tuple[bytes, str]:
    """Content and type of a mesh file; raises ModelError where PyBullet must not read it."""
    data = read_file(geometry.path, "mesh", "mesh_bytes")
    file_type = mesh_type(geometry.path, data)
    content = geometry.path, len(data), hash(data)
    if content not in _SOUND:
        if error := mesh_error(geometry.path, file_type, data):
            raise ModelError(error)
        if len(_SOUND) >= 10_000:
            _SOUND.clear()
        _SOUND.add(content)
    for library in _libraries(geometry.path, data) if file_type == "obj" else ():
        read_file(library, "material library", "text_bytes")  # which everybody reads with the mesh
    return data, file_type


def _scaled_mesh(path: str, geometry: Geometry) -> Geometry:
    x, y, z = geometry.scale
    return Geometry("mesh", path=path, scale=(abs(x), abs(y), abs(z)), is_converted=True)


def _key(data: bytes, text: str) -> str:
    return hashlib.sha256(data + text.encode()).hexdigest()[:24]

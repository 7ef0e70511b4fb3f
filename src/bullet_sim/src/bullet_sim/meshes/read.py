"""Mesh files: their parts, the files next to them, colors and textures."""

from __future__ import annotations

import io
import os
import re
import warnings
from dataclasses import replace
from typing import TYPE_CHECKING, Any, BinaryIO
from urllib.parse import unquote

import numpy as np

from bullet_sim.description.model import RGBA, Geometry
from bullet_sim.errors import ModelError
from bullet_sim.files import limit, read_file, too_many
from bullet_sim.meshes.collada import Part, mended, read_collada
from bullet_sim.meshes.stl import read_stl
from bullet_sim.pose import Array
from bullet_sim.xml_reader import Document, decoded, repaired

if TYPE_CHECKING:
    import trimesh
    from PIL import Image

WHITE = (1.0, 1.0, 1.0, 1.0)
GREY = (0.7, 0.7, 0.7, 1.0)  # of parts without a color


class TooLarge(ModelError):
    """An image has too many pixels."""


def image_of(material: Any) -> Image.Image | None:
    """Pillow image of a trimesh's material, or None."""
    return getattr(material, "image", None) or getattr(material, "baseColorTexture", None)


def opened(source: str | BinaryIO, path: str = "") -> Image.Image:
    """Pillow image of a file, not read yet; to be closed.

    Args:
        source: path, or a binary stream.
        path: of a stream, for messages.

    Raises:
        ModelError: it is no image, or has too many pixels.
    """
    from PIL import Image

    if isinstance(source, str):
        path, source = source, io.BytesIO(read_file(source, "image", "mesh_bytes"))
    Image.MAX_IMAGE_PIXELS = most = limit("image_pixels")
    try:
        with warnings.catch_warnings():  # of Pillow, which has a limit, too
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            image = Image.open(source)
    except Image.DecompressionBombError as error:
        raise TooLarge(f"image '{path}' has too many pixels, {too_many('image_pixels')}") from error
    except (OSError, ValueError, SyntaxError) as error:
        raise ModelError(f"image '{path}' cannot be read: {error}") from error
    width, height = image.size
    if width * height > most:
        image.close()
        raise TooLarge(f"image '{path}' has {width} x {height} pixels, {too_many('image_pixels')}")
    return image


def open_image(path: str, transparent: bool = False) -> Image.Image:
    """Pillow image of a file; transparent: with its alpha channel if there is one.

    Raises:
        ModelError: it cannot be read.
    """
    try:
        with opened(path) as image:
            return image.convert("RGBA" if transparent and "A" in image.getbands() else "RGB")
    except ModelError:
        raise
    except (OSError, ValueError, SyntaxError) as error:
        raise ModelError(f"image '{path}' cannot be read: {error}") from error


def mean_color(path: str) -> RGBA:
    """Mean RGBA of an image file."""
    mean = np.asarray(open_image(path).resize((32, 32))).reshape(-1, 3).mean(axis=0)
    r, g, b = (mean / 255.0).tolist()
    return r, g, b, 1.0


IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".tga", ".tif", ".tiff")
TEXTURES = os.path.join("..", "materials", "textures")  # of a Gazebo model, relative to its meshes


class MeshFileResolver:
    """Reads files for trimesh, instead of its resolver, which is limited to one folder."""

    def __init__(self, path: str) -> None:
        self.errors: list[str] = []  # of images that are missing or damaged, which trimesh ignores
        self.notes: list[str] = []  # about what Gazebo makes of the file
        self._folder = os.path.dirname(os.path.abspath(path))

    def get(self, name: str) -> bytes:
        """Bytes of a file by the name that the mesh has for it.

        Tried are the name as it is and without its folders, in the mesh's folder and in TEXTURES.

        Raises:
            FileNotFoundError: it is in none of these folders.
        """
        name = unquote(re.sub("^file://", "", name.strip()))
        plain = re.split(r"[\\/]", name)[-1]
        for relative in (name, plain, os.path.join(TEXTURES, plain)):
            path = os.path.normpath(os.path.join(self._folder, relative))
            if os.path.isfile(path):
                return self._read(path)
        text = f"'{name}' is neither in '{self._folder}' nor in its {TEXTURES}"
        if name.lower().endswith(IMAGES):
            self.errors.append(text)
        raise FileNotFoundError(text)

    def _read(self, path: str) -> bytes:
        is_image = path.lower().endswith(IMAGES)
        kind = ("image", "mesh_bytes") if is_image else ("material", "text_bytes")
        content = read_file(path, *kind)
        if is_image:
            try:
                opened(io.BytesIO(content), path)
            except ModelError as error:
                self.errors.append(str(error))
                if isinstance(error, TooLarge):
                    raise FileNotFoundError(str(error)) from error
        return content

    __getitem__ = get  # trimesh reads material libraries with it


MAX_SIZE = 1e6  # [m] larger meshes are refused


def read_parts(
    geometry: Geometry, notes: list[str] | None = None, collides: bool = False
) -> list[tuple[trimesh.Trimesh, Array]]:
    """Trimeshes of a file with their transforms, (mesh, (4, 4) with the scale to meters).

    DAE: <unit> counts, <up_axis> does not (see prepare.py).

    Args:
        geometry: a mesh; its submesh counts, and whether it is centered; its scale does not.
        notes: gets sentences about its images that are left out, and about instances.
        collides: of a submesh the first part of that name; all, where there is none, as in Gazebo.

    Raises:
        ModelError: it cannot be read, or has no triangles or no such submesh.
    """
    try:
        import trimesh
    except ImportError as error:
        raise ModelError(
            f"mesh '{geometry.path}' needs the Python package trimesh: {error}"
        ) from error
    try:
        resolver = MeshFileResolver(geometry.path)
        nodes, unit = _parts(geometry, resolver)
        if notes is not None:
            notes += [f"an image is left out: {error}" for error in resolver.errors]
            notes += [f"{note}, as in Gazebo" for note in resolver.notes]
        names = [name for name, _, _ in nodes]
        parts = [
            (mesh, np.diag([unit] * 3 + [1.0]) @ transform)
            for name, mesh, transform in nodes
            if isinstance(mesh, trimesh.Trimesh)
            and len(mesh.faces)
            and (not geometry.submesh or _is_part(geometry.submesh, name))
        ]
    except Exception as error:  # pylint: disable=broad-except  # its readers raise many types
        kind = "" if isinstance(error, ModelError) else f"{type(error).__name__}: "
        raise ModelError(f"mesh '{geometry.path}' cannot be read: {kind}{error}") from error
    if not parts and geometry.submesh and names and collides:
        return read_parts(replace(geometry, submesh="", centered=False))
    if not parts and geometry.submesh and names:
        raise ModelError(
            f"mesh '{geometry.path}' has no part '{geometry.submesh}'; parts are "
            f"{', '.join(sorted(set(names)))}"
        )
    if not parts:
        raise ModelError(f"mesh '{geometry.path}' has no triangles")
    parts = parts[:1] if geometry.submesh and collides else parts
    return _centered(parts) if geometry.centered else parts


def _centered(parts: list[tuple[trimesh.Trimesh, Array]]) -> list[tuple[trimesh.Trimesh, Array]]:
    """Parts that are moved so that the middle of the box around them is the origin."""
    with np.errstate(all="ignore"):  # corners that are not finite are the reader's error
        points = [np.asarray(mesh.vertices) @ at[:3, :3].T + at[:3, 3] for mesh, at in parts]
        low, high = (
            end([end(corners, axis=0) for corners in points], axis=0) for end in (np.min, np.max)
        )
    shift = np.eye(4)
    shift[:3, 3] = -(low + high) / 2.0
    return [(mesh, shift @ at) for mesh, at in parts]


def check_corners(corners: Array, path: str) -> None:
    """Raise ModelError when corners (n, 3) [m] of a file are not finite or beyond MAX_SIZE."""
    if not np.isfinite(corners).all() or np.abs(corners).max() > MAX_SIZE:
        raise ModelError(f"mesh '{path}' has corners that are no numbers or beyond {MAX_SIZE:g} m")


def _parts(geometry: Geometry, resolver: MeshFileResolver) -> tuple[list[Part], float]:
    """Parts of a file and those that it refers to, and the meters of its unit."""
    import trimesh

    if geometry.path.lower().endswith(".dae"):
        return _collada(geometry, resolver)
    if geometry.path.lower().endswith(".stl"):
        corners = read_stl(read_file(geometry.path, "mesh", "mesh_bytes")).reshape(-1, 3)
        faces = np.arange(len(corners)).reshape(-1, 3)
        return [("", trimesh.Trimesh(corners, faces, process=False), np.eye(4))], 1.0
    options: dict[str, Any] = {"process": False, "resolver": resolver}
    if geometry.submesh:
        options.update(split_objects=True, group_material=False)
    scene = trimesh.load_scene(geometry.path, **options)
    placed = [(*scene.graph[node], node) for node in scene.graph.nodes_geometry]
    return [(name, scene.geometry[name], transform) for transform, name, _ in placed], 1.0


def _collada(geometry: Geometry, resolver: MeshFileResolver) -> tuple[list[Part], float]:
    from PIL import Image

    def image(name: str) -> Image.Image:
        return Image.open(io.BytesIO(resolver.get(name)))

    content = read_file(geometry.path, "mesh", "mesh_bytes")
    if content.startswith(b"PK"):
        raise ModelError("it is a ZIP, which is not unpacked; Gazebo's reader takes XML alone, too")
    if b"xmlns" in content or b"x\0m\0l\0n\0s" in content:
        try:
            return read_collada(content, image, resolver.notes)
        except Exception:  # what TinyXML accepts and lxml does not, such as < in a name, or worse
            resolver.notes.clear()
    text = mended(repaired(decoded(content, Document(geometry.path))))
    return read_collada(text, image, resolver.notes)


def _is_part(submesh: str, name: str) -> bool:
    """Whether a part has a name; trimesh gives those of one name numbers."""
    return re.fullmatch(rf"{re.escape(submesh)}(_\d+)?", name) is not None

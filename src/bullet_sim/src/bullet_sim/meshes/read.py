"""Mesh files: their parts, the files next to them, colours and textures."""

import io
import os
import re
import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, BinaryIO
from urllib.parse import unquote

import numpy as np

from bullet_sim.description.model import RGBA, Geometry
from bullet_sim.errors import ModelError
from bullet_sim.pose import Array
from bullet_sim.xml_reader import Document, decoded, repaired

if TYPE_CHECKING:
    import trimesh
    from PIL import Image

WHITE = (1.0, 1.0, 1.0, 1.0)
MAX_PIXELS = 8192 * 8192
_MOST = f"must have at most {MAX_PIXELS} (as 8192 x 8192 has)"
GREY = (0.7, 0.7, 0.7, 1.0)  # of parts without a colour


class TooLarge(ModelError):
    """A picture has too many pixels."""


def rgba(color: Iterable[float]) -> RGBA:
    """RGBA 0..1 of trimesh's colour of 0..255, which may lack the last number."""
    r, g, b, a = (float(value) / 255.0 for value in (list(color) + [255])[:4])
    return r, g, b, a


def picture_of(material: Any) -> "Image.Image | None":
    """Pillow picture over a trimesh's material, or None."""
    return getattr(material, "image", None) or getattr(material, "baseColorTexture", None)


def opened(source: str | BinaryIO) -> "Image.Image":
    """Pillow picture of a file, not read yet; to be closed.

    Args:
        source: path, or a binary stream with a name.

    Raises:
        ModelError: it is no picture, or has more than MAX_PIXELS.
    """
    from PIL import Image

    path: Any = getattr(source, "name", source)
    if source is path and not os.path.isfile(path):
        raise ModelError(f"picture '{path}' cannot be read: it is no file")
    try:
        with warnings.catch_warnings():  # of Pillow, which has a bound of its own
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            picture = Image.open(source)
    except Image.DecompressionBombError as error:
        raise TooLarge(f"picture '{path}' has too many pixels, {_MOST}") from error
    except (OSError, ValueError, SyntaxError) as error:
        raise ModelError(f"picture '{path}' cannot be read: {error}") from error
    width, height = picture.size
    if width * height > MAX_PIXELS:
        picture.close()
        raise TooLarge(f"picture '{path}' has {width} x {height} pixels, {_MOST}")
    return picture


def open_picture(path: str, transparent: bool = False) -> "Image.Image":
    """Pillow picture of a file, with its transparency if wanted and there.

    Raises:
        ModelError: it cannot be read.
    """
    try:
        with opened(path) as found:
            return found.convert("RGBA" if transparent and "A" in found.getbands() else "RGB")
    except ModelError:
        raise
    except (OSError, ValueError, SyntaxError) as error:
        raise ModelError(f"picture '{path}' cannot be read: {error}") from error


def mean_color(path: str) -> RGBA:
    """Mean RGBA of a picture file."""
    mean = np.asarray(open_picture(path).resize((32, 32))).reshape(-1, 3).mean(axis=0)
    r, g, b = (mean / 255.0).tolist()
    return r, g, b, 1.0


PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tga", ".tif", ".tiff")
TEXTURES = os.path.join("..", "materials", "textures")  # of a Gazebo model, beside its meshes


class Beside:
    """Reads files for trimesh, in the place of its own resolver, which stays in one folder.

    Args:
        path: of the mesh.
    """

    def __init__(self, path: str) -> None:
        self.faults: list[
            str
        ] = []  # of pictures that cannot be used, which trimesh leaves out silently
        self._folder = os.path.dirname(os.path.abspath(path))

    def get(self, name: str) -> bytes:
        """Bytes of a file by the name that the mesh has for it.

        A name counts as it is, then without its folders, beside the mesh and in TEXTURES.

        Raises:
            FileNotFoundError: it is in none of these places.
        """
        name = unquote(name.strip().removeprefix("file://"))
        plain = re.split(r"[\\/]", name)[-1]
        for place in (name, plain, os.path.join(TEXTURES, plain)):
            path = os.path.normpath(os.path.join(self._folder, place))
            if os.path.isfile(path):
                return self._read(path)
        raise FileNotFoundError(f"'{name}' is neither in '{self._folder}' nor in its {TEXTURES}")

    def _read(self, path: str) -> bytes:
        with open(path, "rb") as file:
            if path.lower().endswith(PICTURES):
                try:
                    opened(file)
                except ModelError as error:
                    self.faults.append(str(error))
                    if isinstance(error, TooLarge):
                        raise FileNotFoundError(str(error)) from error
                file.seek(0)
            return file.read()

    __getitem__ = get  # as trimesh asks for material libraries


MAX_SIZE = 1e6  # [m] larger meshes are refused


def read_parts(
    geometry: Geometry, faults: list[str] | None = None
) -> list[tuple["trimesh.Trimesh", Array]]:
    """Trimeshes of a file and their places, (mesh, (4, 4) with the scale to metres).

    DAE: <unit> counts, <up_axis> does not (see prepare.py).

    Args:
        geometry: a mesh; its submesh counts, its scale does not.
        faults: gets what is wrong with its pictures, which are left out.

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
        beside = Beside(geometry.path)
        scene = _scene(geometry, beside)
        if faults is not None:
            faults += beside.faults
        parts, names = [], []
        for node in scene.graph.nodes_geometry:
            place, name = scene.graph[node]
            names.append(name)
            found = scene.geometry[name]
            if (
                isinstance(found, trimesh.Trimesh)
                and len(found.faces)
                and (not geometry.submesh or _is_part(geometry.submesh, name, node))
            ):
                parts.append((found, np.diag([_unit(scene.units)] * 3 + [1.0]) @ place))
    except Exception as error:  # pylint: disable=broad-except  # its readers raise many types
        raise ModelError(
            f"mesh '{geometry.path}' cannot be read: {type(error).__name__}: {error}"
        ) from error
    if not parts and geometry.submesh and names:
        raise ModelError(
            f"mesh '{geometry.path}' has no part '{geometry.submesh}'; parts are "
            f"{', '.join(sorted(set(names)))}"
        )
    if not parts:
        raise ModelError(f"mesh '{geometry.path}' has no triangles")
    return parts


def check_corners(corners: Array, path: str) -> None:
    """Raise ModelError when corners (n, 3) [m] of a file are not finite or far out."""
    if not np.isfinite(corners).all() or np.abs(corners).max() > MAX_SIZE:
        raise ModelError(f"mesh '{path}' has corners that are no numbers or beyond {MAX_SIZE:g} m")


def _scene(geometry: Geometry, beside: Beside) -> "trimesh.Scene":
    """trimesh's Scene of a file and those beside it."""
    import trimesh

    options = {"process": False, "resolver": beside}
    if geometry.submesh and geometry.path.lower().endswith(".obj"):
        options |= {"split_objects": True, "group_material": False}
    try:
        return trimesh.load_scene(geometry.path, **options)
    except Exception:  # XML that TinyXML takes and lxml does not, such as < in a name?
        if not geometry.path.lower().endswith(".dae"):
            raise
        with open(geometry.path, "rb") as file:
            text = repaired(decoded(file.read(), Document(geometry.path)))
    return trimesh.load_scene(io.BytesIO(text.encode()), file_type="dae", **options)


def _is_part(wanted: str, *names: str) -> bool:
    return any(name == wanted or str(name).startswith(wanted) for name in names)


def _unit(text: str | None) -> float:
    """Metres in a file's unit: trimesh says 'meters' or '0.0254 * meters'."""
    found = re.match(r"\s*([-+.\deE]+)\s*\*", str(text or ""))
    return float(found.group(1)) if found else 1.0

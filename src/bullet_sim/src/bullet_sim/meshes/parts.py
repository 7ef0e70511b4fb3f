"""Parts of a mesh file as trimesh reads them, with their places in the file's scene."""

import io
import re

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.formats.xml_parse import Document, decoded, mended
from bullet_sim.meshes.beside import Beside

MAX_SIZE = 1e6  # [m] larger meshes are refused


def read_parts(geometry, faults=None):
    """Trimeshes of a file and their places, (mesh, (4, 4) with the scale to metres).

    DAE: <unit> counts, <up_axis> does not (see localise.py).

    Args:
        geometry: Geometry that is a mesh; its submesh counts, its scale does not.
        faults: list that takes what is wrong with its pictures, which are left out.

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


def check_corners(corners, path):
    """Raise ModelError when corners (n, 3) [m] of a file are not finite or far out."""
    if not np.isfinite(corners).all() or np.abs(corners).max() > MAX_SIZE:
        raise ModelError(f"mesh '{path}' has corners that are no numbers or beyond {MAX_SIZE:g} m")


def _scene(geometry, beside):
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
            text = mended(decoded(file.read(), Document(geometry.path)))
    return trimesh.load_scene(io.BytesIO(text.encode()), file_type="dae", **options)


def _is_part(wanted, *names):
    return any(name == wanted or str(name).startswith(wanted) for name in names)


def _unit(text):
    """Metres in a file's unit: trimesh says 'meters' or '0.0254 * meters'."""
    found = re.match(r"\s*([-+.\deE]+)\s*\*", str(text or ""))
    return float(found.group(1)) if found else 1.0

"""COLLADA files (.dae) as trimesh's meshes, with the materials as Gazebo reads them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import IO, TYPE_CHECKING, Any, Callable, Tuple

import numpy as np

from bullet_sim.description.model import RGB
from bullet_sim.meshes.looks import KEY, Look
from bullet_sim.pose import Array

if TYPE_CHECKING:
    import trimesh

Part = Tuple[str, "trimesh.Trimesh", Array]  # name of its geometry, mesh, pose (4, 4) in the file
OpenImage = Callable[[str], Any]  # name in the file -> Pillow image; raises OSError, ModelError


def read_collada(file: IO[bytes], open_image: OpenImage) -> tuple[list[Part], float]:
    """Triangles of a file.

    Args:
        file: binary stream.
        open_image: opens its images.

    Returns:
        One part for each material of each geometry, and the meters of the file's unit. Each mesh
        has its Look as metadata KEY.

    Raises:
        collada.common.DaeError, AttributeError, ValueError ...: it is broken.
    """
    import collada

    document = collada.Collada(file, ignore=[collada.common.DaeError])
    looks: dict[Any, Look] = {}
    names: dict[str, int] = {}
    parts = []
    for node, pose in _geometries(document.scene.nodes if document.scene else [], np.eye(4)):
        materials = {material.symbol: material.target for material in node.materials}
        for primitive in node.geometry.primitives:
            if isinstance(primitive, collada.polylist.Polylist):
                primitive = primitive.triangleset()
            if not isinstance(primitive, collada.triangleset.TriangleSet):
                continue
            if primitive.vertex is None or not len(primitive.vertex_index):
                continue
            material = materials.get(primitive.material)
            if material is not None and material.id not in looks:
                looks[material.id] = _look(material.effect, open_image)
            name = node.geometry.id
            names[name] = names.get(name, 0) + 1
            unique = name if names[name] == 1 else f"{name}_{names[name] - 1}"
            look = None if material is None else looks[material.id]
            parts.append((unique, _mesh(primitive, look), pose))
    unit = document.assetInfo.unitmeter
    return parts, 1.0 if unit is None else float(unit)


def _geometries(nodes: Any, pose: Array) -> Iterator[tuple[Any, Array]]:
    """GeometryNodes below some nodes, with their poses."""
    import collada

    for node in nodes:
        if isinstance(node, collada.scene.GeometryNode):
            yield node, pose
        elif getattr(node, "children", None) is not None:
            yield from _geometries(node.children, pose @ node.matrix)


def _mesh(primitive: Any, look: Look | None) -> trimesh.Trimesh:
    import trimesh

    corners = primitive.vertex[primitive.vertex_index].reshape(-1, 3)
    normals = None
    if primitive.normal is not None:
        normals = primitive.normal[primitive.normal_index].reshape(-1, 3)
    uv = None
    if len(primitive.texcoordset):
        uv = primitive.texcoordset[0][primitive.texcoord_indexset[0]].reshape(-1, 2)
    mesh = trimesh.Trimesh(
        vertices=corners,
        faces=np.arange(len(corners)).reshape(-1, 3),
        vertex_normals=normals,
        process=False,
    )
    if look is not None:
        mesh.metadata[KEY] = look
        material = trimesh.visual.material.SimpleMaterial(image=look.image, diffuse=look.diffuse)
        mesh.visual = trimesh.visual.texture.TextureVisuals(uv=uv, material=material)
    return mesh


def _look(effect: Any, open_image: OpenImage) -> Look:
    """Look of an effect; a texture counts wherever it is, what is missing is Gazebo's default."""
    import collada

    image = None
    for value in (effect.diffuse, effect.specular, effect.emission, effect.ambient):
        if image is None and isinstance(value, collada.material.Map):
            image = _opened(value, open_image)
    gray = 0.5 if image is None else 1.0
    red, green, blue, alpha = _rgba(effect.diffuse) or (gray, gray, gray, 1.0)
    return Look(
        (red, green, blue, alpha * _opacity(effect)),
        _rgb(effect.ambient, (0.4, 0.4, 0.4)),
        _rgb(effect.specular, (0.0,) * 3) if effect.shadingtype != "lambert" else (0.0,) * 3,
        _number(effect.shininess),
        _rgb(effect.emission, (0.0,) * 3),
        image,
    )


def _opened(image: Any, open_image: OpenImage) -> Any:
    try:
        return open_image(image.sampler.surface.image.path)
    except (AttributeError, OSError, ValueError):
        return None  # open_image has noted it


def _opacity(effect: Any) -> float:
    """Of <transparent> and <transparency>; 1 without <transparent>, as in Gazebo."""
    import collada

    color = _rgba(effect.transparent)
    if color is None:
        return 1.0
    transparency = 1.0 if effect.transparency is None else _number(effect.transparency)
    if effect.opaque_mode == collada.material.OPAQUE_MODE.RGB_ZERO:
        return min(1.0, max(0.0, 1.0 - color[0] * transparency))
    return min(1.0, max(0.0, color[3] * transparency))


def _rgba(value: Any) -> tuple[float, ...] | None:
    """Four numbers of a color; None: it is none."""
    if value is None or not isinstance(value, (tuple, list, np.ndarray)) or len(value) < 3:
        return None
    numbers = [float(number) for number in value]
    return tuple((*numbers, 1.0)[:4]) if np.isfinite(numbers).all() else None


def _rgb(value: Any, default: RGB) -> RGB:
    color = _rgba(value)
    return default if color is None else (color[0], color[1], color[2])


def _number(value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        return 0.0
    return number if np.isfinite(number) else 0.0

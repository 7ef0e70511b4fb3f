"""COLLADA files (.dae) as trimesh's meshes, with the materials as Gazebo reads them."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Callable, Tuple

import numpy as np

from bullet_sim.description.model import RGB
from bullet_sim.meshes.looks import KEY, Look
from bullet_sim.pose import Array

if TYPE_CHECKING:
    import trimesh

Part = Tuple[str, "trimesh.Trimesh", Array]  # name of its node, mesh, pose (4, 4) in the file
OpenImage = Callable[[str], Any]  # name in the file -> Pillow image; raises OSError, ModelError
_ROOT = re.compile(r"<COLLADA\b(?![^>]*\sxmlns\s*=)")
_SPACE = '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"'
_MATERIAL = re.compile(r'<material\b[^>]*?\bid="([^"]*)"')
_BOUND = re.compile(
    r'<instance_material\b[^>]*?\btarget="#([^"]*)"[^>]*?(?:/>|(?<!/)>.*?</instance_material>)',
    re.DOTALL,
)


def mended(text: str) -> str:
    """A text with a namespace, and without materials that do not exist: Gazebo needs neither."""
    known = set(_MATERIAL.findall(text))
    text = _BOUND.sub(lambda match: match.group() if match.group(1) in known else "", text)
    return _ROOT.sub(_SPACE, text, count=1)


def read_collada(
    text: str | bytes, open_image: OpenImage, notes: list[str]
) -> tuple[list[Part], float]:
    """Triangles of a file.

    Args:
        text: of the file; of a str the elements that are broken are left out.
        open_image: opens its images.
        notes: gets sentences about what Gazebo makes of it.

    Returns:
        One part for each material of each geometry, and the meters of the file's unit. Each mesh
        has its Look as metadata KEY. As in Gazebo, which keeps the corners of a geometry for all
        that instantiate it, each of these is where the first one is.

    Raises:
        collada.common.DaeError, AttributeError, ValueError ...: it is broken.
    """
    import collada

    content = text if isinstance(text, bytes) else text.encode()
    kinds = (kind for kind in vars(collada.common).values() if isinstance(kind, type))
    broken = [kind for kind in kinds if issubclass(kind, collada.common.DaeError)]
    document = collada.Collada(io.BytesIO(content), ignore=[] if content is text else broken)
    looks: dict[Any, Look] = {}
    places: dict[str, Array] = {}  # of each geometry where it is used first
    parts = []
    for name, node, geometry, pose in _geometries(document):
        materials = {material.symbol: material.target for material in node.materials}
        if not np.array_equal(places.setdefault(geometry.id, pose), pose):
            notes.append(f"all instances of geometry '{geometry.id}' are where the first is")
        for primitive in geometry.primitives:
            if isinstance(primitive, collada.polylist.Polylist):
                primitive = primitive.triangleset()
            if not isinstance(primitive, collada.triangleset.TriangleSet):
                continue
            if primitive.vertex is None or not len(primitive.vertex_index):
                continue
            material = materials.get(primitive.material)
            if material is not None and material.id not in looks:
                looks[material.id] = _look(material.effect, open_image)
            look = None if material is None else looks[material.id]
            parts.append((name, _mesh(primitive, look), places[geometry.id]))
    unit = document.assetInfo.unitmeter
    return parts, 1.0 if unit is None else float(unit)


def _geometries(document: Any) -> Iterator[tuple[str, Any, Any, Array]]:
    """Instances of geometries in the order of Gazebo's ColladaLoader: the name of the last node
    that has one, the instance, its geometry, its pose.

    Of a skin it is that of its bones' first pose; bind_shape_matrix counts for polylists alone.
    """
    import collada

    name = ""
    pending = [(node, np.eye(4)) for node in (document.scene.nodes if document.scene else [])]
    while pending:
        node, pose = pending.pop(0)
        own = getattr(node, "node", node)  # of an <instance_node>
        if isinstance(node, collada.scene.GeometryNode):
            yield name, node, node.geometry, pose
        elif isinstance(node, collada.scene.ControllerNode):
            skin = node.controller
            if hasattr(skin, "geometry"):
                polygons = skin.geometry.primitives
                bends = any(isinstance(item, collada.polylist.Polylist) for item in polygons)
                yield name, node, skin.geometry, pose @ skin.bind_shape_matrix if bends else pose
        elif getattr(own, "children", None) is not None:
            name = own.xmlnode.get("name") or name
            pose = pose @ node.matrix
            inner = sorted(own.children, key=lambda child: not hasattr(child, "children"))
            pending[:0] = [(child, pose) for child in inner]


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

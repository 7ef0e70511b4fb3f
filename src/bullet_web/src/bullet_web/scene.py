"""A scene of `/gazebo/scene` as browsers load it: instances of meshes, the meshes, the images.

Meshes, materials and textures are read as the camera renderer reads them (`AssetCache`,
`describe`); instead of a graphics memory, `Memory` takes the triangles and pixels. No ROS.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Mapping
from typing import Any, Dict, NamedTuple

import numpy as np
from bullet_sim.description.model import Finish, Geometry, Shape, TextureMapping
from bullet_sim.errors import ModelError
from bullet_sim.pose import Pose
from bullet_sim.render.gl.meshes import AssetCache
from bullet_sim.render.gl.scene import describe
from bullet_sim.render.renderer import HORIZON, ZENITH
from PIL import Image

MAX_SIDE = 4096  # [px] of an image; tablets have no larger textures
QUALITY = 88  # of JPEG
DIGITS = 20  # of an asset's name
Scene = Dict[str, Any]


class Asset(NamedTuple):
    """A file for browsers. name: derived from the content, so that browsers may keep it."""

    name: str
    type: str
    data: bytes


class Buffer:
    """Bytes that a renderer would upload."""

    def __init__(self, data: bytes) -> None:
        self.data = data


class Texture:
    """Pixels (rows from the lowest to the uppermost) that a renderer would upload."""

    anisotropy = 1.0
    filter: tuple[int, int] = (0, 0)
    repeat_x = repeat_y = True

    def __init__(self, size: tuple[int, int], components: int, data: bytes) -> None:
        self.asset = image_asset(size, components, data)

    def build_mipmaps(self, max_level: int) -> None:
        """Browsers make them."""

    def write(self, data: bytes, level: int, alignment: int) -> None:
        """Take a smaller image of the same; browsers make their own."""


class Memory:
    """What AssetCache uses of a moderngl.Context."""

    LINEAR_MIPMAP_LINEAR = LINEAR = NEAREST = 0

    def buffer(self, data: bytes) -> Buffer:
        return Buffer(data)

    def texture(
        self, size: tuple[int, int], components: int, data: bytes, alignment: int
    ) -> Texture:
        return Texture(size, components, data)


def image_asset(size: tuple[int, int], components: int, data: bytes) -> Asset:
    """PNG of an image with transparency, JPEG of any other, of at most MAX_SIDE.

    Args:
        size: width, height [px].
        components: 3 or 4 bytes a pixel.
        data: rows from the lowest to the uppermost.
    """
    image = Image.frombytes("RGB" if components == 3 else "RGBA", size, data)
    image = image.transpose(Image.FLIP_TOP_BOTTOM)
    image.thumbnail((MAX_SIDE, MAX_SIDE))
    stream = io.BytesIO()
    if components == 4:
        image.save(stream, "PNG")
    else:
        image.save(stream, "JPEG", quality=QUALITY)
    return named("image/png" if components == 4 else "image/jpeg", stream.getvalue())


def mesh_asset(corners: bytes, triangles: bytes) -> Asset:
    """Number of corners (uint32), corners (n, 8) float32 as of Part, triangles (m, 3) uint32."""
    count = np.array([len(corners) // 32], "<u4").tobytes()
    return named("application/octet-stream", count + corners + triangles)


def named(content_type: str, data: bytes) -> Asset:
    """Asset with the name that its content gives it."""
    return Asset(hashlib.sha256(data).hexdigest()[:DIGITS], content_type, data)


def _geometry_of(fields: Mapping[str, Any]) -> Geometry:
    geometry = dict(fields)
    for name in ("size", "scale"):
        geometry[name] = tuple(geometry[name])
    geometry["points"] = tuple(map(tuple, geometry["points"]))
    geometry["outlines"] = tuple(tuple(map(tuple, line)) for line in geometry["outlines"])
    relief = geometry["relief"]
    geometry["relief"] = None if relief is None else _geometry_of(relief)
    return Geometry(**geometry)


def shape_of(fields: Mapping[str, Any]) -> Shape:
    """Shape of its fields in JSON."""
    position: Any = tuple(fields["pose"]["position"])
    orientation: Any = tuple(fields["pose"]["orientation"])
    color: Any = fields["color"] and tuple(fields["color"])
    finish = dict(fields["finish"], layers=())  # the page shows the lowest image alone
    mapping = finish.get("mapping") or {}
    transform = tuple(mapping.get("transform", ()))
    finish["mapping"] = TextureMapping(**{**mapping, "transform": transform})
    return Shape(
        _geometry_of(fields["geometry"]),
        Pose(position, orientation),
        color,
        fields["texture"],
        fields["painted"],
        fields["name"],
        fields["link"],
        Finish(**finish),
    )


class SceneMaker:
    """Makes scenes for browsers; what several scenes in a row use is read once.

    Attributes:
        assets: meshes and images of the newest scene by name.
        problems: messages about visuals that cannot be shown.
    """

    def __init__(self) -> None:
        self._cache = AssetCache(Memory(), 1.0)
        self._meshes: dict[int, tuple[Any, Asset]] = {}  # id of a Mesh -> it and its asset
        self.assets: dict[str, Asset] = {}
        self.problems: list[str] = []

    def make(self, source: Mapping[str, Any]) -> Scene:
        """The scene of a response of `/gazebo/scene`.

        Returns:
            As the response, with "instances" instead of "shapes" in each link: mesh and image
            (names of assets), matrix (4, 4) in the link column by column, colors and flags; and
            "sky": RGB 0..1 of the horizon and the zenith.
        """
        self.assets, self.problems = {}, []
        before, self._meshes = self._meshes, {}
        self._cache.start_scene()
        bodies = [self._body(body, before) for body in source["bodies"]]
        self._cache.drop_unused()
        sky = [[value / 255.0 for value in color] for color in (HORIZON, ZENITH)]
        return {**source, "bodies": bodies, "sky": sky, "problems": self.problems}

    def _body(self, body: Mapping[str, Any], before: Mapping[int, Any]) -> Scene:
        links = []
        for link in body["links"]:
            instances = []
            for fields in link["shapes"]:
                try:
                    instances += self._instances(shape_of(fields), before)
                except ModelError as error:
                    self.problems.append(f"{body['name']}: {error}")
            links.append({**link, "shapes": None, "instances": instances})
        return {**body, "links": links}

    def _instances(self, shape: Shape, before: Mapping[int, Any]) -> list[Scene]:
        """One for each material of a shape."""
        result = []
        for surface in self._cache.surfaces(shape):
            instance = describe(0, 0, False, shape, surface)
            if instance is None:  # invisible
                continue
            mesh = self._mesh(surface.mesh, before)
            image = None if surface.texture is None else surface.texture.asset
            for asset in filter(None, (mesh, image)):
                self.assets[asset.name] = asset
            colors = [round(value, 4) for value in instance.colors]
            result.append(
                {
                    "mesh": mesh.name,
                    "image": image and image.name,
                    "matrix": [round(value, 7) for value in instance.local.T.ravel().tolist()],
                    "color": colors[:4],
                    "ambient": colors[4:7],
                    "shininess": colors[7],
                    "specular": colors[8:11],
                    "emissive": colors[12:15],
                    "lit": instance.type.lit,
                    "double_sided": instance.type.double_sided,
                    "transparent": instance.type.transparent,
                    "casts": instance.casts,
                }
            )
        return result

    def _mesh(self, mesh: Any, before: Mapping[int, Any]) -> Asset:
        kept = before.get(id(mesh)) or self._meshes.get(id(mesh))
        if kept is None:
            kept = mesh, mesh_asset(mesh.vertices.data, mesh.indices.data)
        self._meshes[id(mesh)] = kept
        return kept[1]

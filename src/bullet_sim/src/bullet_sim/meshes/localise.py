"""Mesh files and textured shapes -> files that PyBullet reads correctly: OBJ, one material each.

PyBullet reads binary STL and OBJ with one material. Its DAE reader ignores materials and units, it
reads no ASCII STL, mirrored meshes are inside out, an OBJ is drawn in one colour however many it
has and black without any, EGL draws stripes where an image's width is no multiple of 4, and a
broken file can crash the process. So every file is checked, and other files are rewritten with
trimesh (loaded on demand) into a folder next to the prepared URDF, once for each content.

As in Gazebo and rviz, a DAE's <unit> counts and its <up_axis> does not.
"""

import hashlib
import json
import os
from dataclasses import replace

from bullet_sim.description.parts import Geometry
from bullet_sim.errors import ModelError
from bullet_sim.meshes import check as mesh_check
from bullet_sim.meshes import convert as mesh_convert
from bullet_sim.meshes import terrain
from bullet_sim.meshes.looks import mean_color
from bullet_sim.system.files import read_file

MAX_BYTES = 400_000_000  # of a mesh file


def localise(lumped, folder, warn):
    """Replace the meshes and textures of a LumpedModel in place by files that PyBullet reads.

    Args:
        lumped: LumpedModel.
        folder: for converted files; they go to <folder>/meshes.
        warn: function that takes a sentence, its cause and item (see ReadWarning) for each shape
            that cannot be used.

    Returns:
        Link name -> the visuals that can be used, as they were.
    """
    store = _Store(os.path.join(folder, "meshes"), warn)
    usable = {name: [] for name in lumped.links}
    for link in lumped.links.values():
        for shapes, convert in ((link.visuals, store.visual), (link.collisions, store.collision)):
            ready = []
            for shape in shapes:
                try:
                    ready += convert(shape)
                    if shapes is link.visuals:
                        usable[link.name].append(shape)
                except ModelError as error:
                    what = f"{shape.name or 'a shape'} of link '{shape.link or link.name}'"
                    warn(
                        f"{what} is left out: {error}",
                        "meshes cannot be used and are left out",
                        shape.geometry.path or what,
                    )
            shapes[:] = ready
    return usable


class _Store:
    """Converted files below one folder."""

    def __init__(self, folder, warn):
        self._folder, self._warn = folder, warn

    def visual(self, shape):
        """Shapes that replace one visual: one for each material."""
        if shape.geometry.kind in _MADE:
            shape = replace(shape, color=self._color(shape), texture="")
            return [replace(shape, geometry=self._made(shape.geometry))]
        geometry = shape.geometry
        if geometry.kind != "mesh":
            return [self._covered(shape)] if shape.texture else [shape]
        data = read_file(geometry.path, "mesh", MAX_BYTES)
        kind = mesh_check.kind_of(geometry.path, data)
        fault = mesh_check.fault(geometry.path, kind, data)
        if fault:
            raise ModelError(fault)
        if mesh_check.is_plain(shape, kind, data) and not shape.texture:
            return [shape]
        faults = []
        parts = self._converted(geometry, data, "visual", shape, faults)
        for fault in dict.fromkeys(faults):
            self._warn(
                f"a picture of mesh '{geometry.path}' is left out: {fault}",
                "pictures of meshes cannot be used and are left out",
                geometry.path,
            )
        return [
            replace(
                shape, texture="", geometry=_beside(part["file"], geometry), color=part["color"]
            )
            for part in parts
        ]

    def collision(self, shape):
        """Shapes that replace one collision; materials are ignored."""
        if shape.geometry.kind in _MADE:
            return [replace(shape, geometry=self._made(shape.geometry))]
        geometry = shape.geometry
        if geometry.kind != "mesh":
            return [shape]
        data = read_file(geometry.path, "mesh", MAX_BYTES)
        kind = mesh_check.kind_of(geometry.path, data)
        fault = mesh_check.fault(geometry.path, kind, data)
        if fault:
            raise ModelError(fault)
        if kind in ("obj", "stl") and min(geometry.scale) > 0 and not geometry.submesh:
            return [shape]
        parts = self._converted(geometry, data, "collision", shape)
        return [replace(shape, geometry=_beside(part["file"], geometry)) for part in parts]

    def _made(self, geometry):
        """The mesh of a heightmap or a polyline."""
        data = read_file(geometry.path, "mesh", MAX_BYTES) if geometry.path else b""
        key = _key(data, repr((geometry.kind, geometry.size, geometry.points)))

        def make(folder):
            path = os.path.join(folder, "shape.obj")
            terrain.write_obj(path, *_MADE[geometry.kind](geometry))
            return [{"file": path, "color": None}]

        return Geometry("mesh", path=self._kept(key, make)[0]["file"])

    @staticmethod
    def _color(shape):
        return mean_color(shape.texture) if shape.texture else shape.color

    def _covered(self, shape):
        """A box with a texture on its sides; other shapes get the texture's mean colour."""
        kind, size = shape.geometry.kind, shape.geometry.size
        if kind != "box":
            return replace(shape, texture="", color=mean_color(shape.texture))
        key = _key(read_file(shape.texture, "picture", MAX_BYTES), repr(size))
        parts = self._kept(key, lambda folder: mesh_convert.write_box(size, shape.texture, folder))
        return replace(
            shape,
            texture="",
            color=parts[0]["color"],
            geometry=Geometry("mesh", path=parts[0]["file"]),
        )

    def _converted(self, geometry, data, role, shape, faults=None):
        signs = tuple(1 if factor > 0 else -1 for factor in geometry.scale)
        looks = (shape.texture, shape.color, shape.painted) if role == "visual" else ()
        key = _key(
            data, repr((geometry.path, signs, geometry.submesh, geometry.centered, role, looks))
        )
        return self._kept(
            key, lambda folder: mesh_convert.convert(shape, signs, role, folder, faults)
        )

    def _kept(self, key, make):
        """Parts made before, or made now; each a dict of file, color, textured."""
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


_MADE = {
    "heightmap": lambda geometry: terrain.heightmap(geometry.path, geometry.size),
    "polyline": lambda geometry: terrain.extruded(geometry.points, geometry.size[0]),
}


def _beside(path, geometry):
    return Geometry("mesh", path=path, scale=tuple(abs(factor) for factor in geometry.scale))


def _key(data, text):
    return hashlib.sha256(data + text.encode()).hexdigest()[:24]

"""Meshes and textures in the graphics memory: one upload for each, however often it is drawn."""

import os

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.meshes.looks import WHITE, mean_color, open_picture
from bullet_sim.render.gl.meshes.parts import Part, mesh_parts
from bullet_sim.render.gl.meshes.solids import solid

MAX_PICTURE = 8192  # [px] longest side of a texture


class Mesh:
    """Triangles in the graphics memory.

    Attributes:
        vertices, indices: moderngl Buffers; corners as Part.corners.
        centre (3,), radius: of a sphere around it [m].
        low, high: (3,) of a box around it [m].
        count: of its triangles.
    """

    def __init__(self, gl, corners, triangles):
        self.vertices = gl.buffer(np.ascontiguousarray(corners).tobytes())
        self.indices = gl.buffer(np.ascontiguousarray(triangles).tobytes())
        used = corners[:, :3].astype(float)
        self.low, self.high = used.min(axis=0), used.max(axis=0)
        self.centre = (self.low + self.high) / 2.0
        self.radius = float(np.linalg.norm(used - self.centre, axis=1).max())
        self.count = len(triangles)


class Look:
    """One mesh with its material, as a visual shows it.

    Attributes:
        mesh: Mesh.
        texture: moderngl Texture or None.
        clear: whether the texture lets something through.
        part: Part whose material it is; of a solid, one of white without a picture.
    """

    def __init__(self, mesh, texture, clear, part):
        self.mesh, self.texture, self.clear, self.part = mesh, texture, clear, part


class Store:
    """Uploads of one context, kept while a scene uses them.

    Args:
        gl: moderngl.Context.
        anisotropy: of textures; 1: none.
    """

    def __init__(self, gl, anisotropy):
        self._gl, self._anisotropy = gl, anisotropy
        self._solids, self._files, self._pictures = {}, {}, {}
        self._used = set()

    def begin(self):
        """Begin to note what is used."""
        self._used = set()

    def drop_unused(self):
        """Free what was not asked for since begin()."""
        for table in (self._files, self._pictures):
            for key in [key for key in table if key not in self._used]:
                del table[key]

    def looks(self, shape):
        """Looks of a visual Shape, one for each material.

        Raises:
            ModelError: its mesh or its texture cannot be read.
        """
        geometry = shape.geometry
        if geometry.kind == "mesh":
            return self._covered(self._file(geometry), shape)
        kind = "box" if geometry.kind == "plane" else geometry.kind
        if kind not in self._solids:
            self._solids[kind] = Mesh(self._gl, *solid(kind))
        part = Part(None, None)
        return self._covered([Look(self._solids[kind], None, False, part)], shape)

    def _covered(self, looks, shape):
        if not shape.texture:
            return looks
        texture, clear = self._picture(shape.texture)
        found = []
        for look in looks:
            mapped = look.part.corners is None or look.part.corners[:, 6:].any()
            part = Part(None, None, WHITE if mapped else mean_color(shape.texture))
            found.append(Look(look.mesh, texture if mapped else None, clear and mapped, part))
        return found

    def _file(self, geometry):
        key = (
            geometry.path,
            _stamp(geometry.path),
            tuple(geometry.scale),
            geometry.submesh,
            geometry.centered,
        )
        self._used.add(key)
        if key not in self._files:
            looks = []
            for part in mesh_parts(geometry):
                texture, clear = None, False
                if part.picture is not None:
                    texture, clear = self._upload(part.picture)
                looks.append(
                    Look(Mesh(self._gl, part.corners, part.triangles), texture, clear, part)
                )
            self._files[key] = looks
        return self._files[key]

    def _picture(self, path):
        key = (path, _stamp(path))
        self._used.add(key)
        if key not in self._pictures:
            self._pictures[key] = self._upload(open_picture(path, transparent=True))
        return self._pictures[key]

    def _upload(self, picture):
        """(Texture of a Pillow image with its mipmaps, whether it lets something through)."""
        veiled = "A" in picture.getbands() or "transparency" in picture.info
        picture = picture.convert("RGBA" if veiled else "RGB")
        shrink = min(1.0, MAX_PICTURE / max(picture.size))
        if shrink < 1.0:
            picture = picture.resize([max(1, round(side * shrink)) for side in picture.size])
        pixels = np.asarray(picture)[::-1]  # OpenGL's first row is the lowest
        clear = pixels.shape[2] == 4 and int(pixels[:, :, 3].min()) < 250
        texture = self._gl.texture(
            picture.size, pixels.shape[2], np.ascontiguousarray(pixels).tobytes(), alignment=1
        )
        texture.build_mipmaps()
        texture.filter = (self._gl.LINEAR_MIPMAP_LINEAR, self._gl.LINEAR)
        texture.anisotropy = self._anisotropy
        return texture, clear


def _stamp(path):
    try:
        return os.stat(path).st_mtime_ns
    except OSError as error:
        raise ModelError(f"file '{path}' cannot be read: {error.strerror}") from error

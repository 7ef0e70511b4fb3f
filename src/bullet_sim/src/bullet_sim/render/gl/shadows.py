"""The sun's shadows: one depth image of what never moves, one of what does, from the sun.

The first is rendered again only when the scene changes or, in a wide world, when the camera comes
to another part of it. The second is rendered for each snapshot and fits what moves, so that it is
fine.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bullet_sim.pose import Array, Vector
from bullet_sim.render.gl.scene import Instances

WIDEST = 32.0  # [m] edge of the part of the world that a map covers
CELL = 8.0  # [m] the part follows the camera in steps of this
NEAR_BY = 0.4  # [m] where a texel of what moves is a pixel
FINEST = 0.002  # [m] texels need not be smaller
MIN_TEXTURE = 256  # [px] minimum edge of a map's texture
MIN_EDGE = 0.25  # [m] minimum edge of a map
NOTHING = "nothing"  # what a map shows without casters
OFFSET = 1.6  # texels by which surfaces that the sun grazes are moved out before the comparison


def sun_axes(towards: Vector) -> Array:
    """(3, 3) whose rows are two axes across the light and the one away from the sun.

    Args:
        towards: (3,) of length 1.
    """
    away = -np.asarray(towards, float)
    helper = np.array([0.0, 1.0, 0.0]) if abs(away[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    right = np.cross(helper, away)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(away, right), away])


class Map:
    """One depth image from the sun.

    Args:
        gl: moderngl.Context.
        max_edge: [px].

    Attributes:
        texture: moderngl depth texture that compares.
        target: Framebuffer of the texture.
        clip: (4, 4) from positions relative to the instances' origin to OpenGL's clip space.
        offset: [m] along the normal, see OFFSET.
    """

    def __init__(self, gl: Any, max_edge: int) -> None:
        self._gl, self._max_edge = gl, max_edge
        self._textures: dict[int, tuple[Any, Any]] = {}
        self.clip, self.offset = np.eye(4), 0.0
        self.content: object = NOTHING
        self._choose(MIN_TEXTURE)

    def _choose(self, size: int) -> None:
        """Use a texture of that edge [px]."""
        if size not in self._textures:
            texture = self._gl.depth_texture((size, size))
            texture.compare_func = "<="
            texture.filter = (self._gl.LINEAR, self._gl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
            self._textures[size] = texture, self._gl.framebuffer(depth_attachment=texture)
        self.texture, self.target = self._textures[size]

    def fit(
        self, axes: Array, low: Array, high: Array, origin: Array, finest: float = FINEST
    ) -> None:
        """Cover a box of the light's axes.

        Args:
            axes: as sun_axes returns them.
            low, high: (3,) [m] in these axes.
            origin: (3,) [m] of the instances.
            finest: texels need not be smaller [m].
        """
        edge = max(*(high - low)[:2], MIN_EDGE) * 1.02
        edge = 2.0 ** (np.ceil(2.0 * np.log2(edge)) / 2.0)  # few sizes: shadows do not crawl
        size = 2.0 ** np.ceil(np.log2(edge / finest))
        size = int(min(max(size, MIN_TEXTURE), self._max_edge))
        self._choose(size)
        texel = edge / size
        center = np.round((low + high)[:2] / 2.0 / texel) * texel
        depth = max(high[2] - low[2], 1e-3) * 1.02 + 4.0 * texel
        start = (low[2] + high[2]) / 2.0 - depth / 2.0
        clip = np.eye(4)
        clip[:3, :3] = axes
        clip[:3, 3] = axes @ origin - (*center, start)
        self.clip = np.diag([2.0 / edge, 2.0 / edge, 1.0 / depth, 1.0]) @ clip
        self.offset = OFFSET * texel

    def lookup(self) -> Array:
        """(4, 4) from positions to texture coordinates and depth, all 0..1."""
        half = np.diag([0.5, 0.5, 1.0, 1.0])
        half[:2, 3] = 0.5
        return half @ self.clip


class Shadows:
    """The maps of a scene.

    Args:
        gl: moderngl.Context.
        program: shaders.Programs.depth.
        size: edge of the map of what never moves [px].
    """

    def __init__(self, gl: Any, program: Any, size: int) -> None:
        self._gl, self._program = gl, program
        self.fixed, self.moving = Map(gl, size), Map(gl, size // 4)

    def update(
        self, instances: Instances, casts: Array, towards: Vector, eye: Array, focal: float
    ) -> None:
        """Render the maps that have changed.

        Args:
            casts: (n,) bool, the instances whose shadows may be visible.
            towards: (3,) to the sun.
            eye: (3,) [m] of the camera in the world.
            focal: length of the camera [px]; what moves has no finer shadows than it can see.
        """
        finest = max(FINEST, NEAR_BY / focal)
        axes = sun_axes(towards)
        part = tuple(np.round(axes[:2] @ eye / CELL).tolist())
        light = tuple(map(float, towards))
        fixed = instances.casts & instances.fixed
        for shadow, chosen, version, name, texel in (
            (self.fixed, fixed, instances.fixed_version, "fixed", FINEST),
            (self.moving, casts & ~instances.fixed, instances.moving_version, "moving", finest),
        ):
            key = (version, light, part, chosen.tobytes(), texel) if chosen.any() else NOTHING
            if shadow.content == key:
                continue
            shadow.content = key
            if key != NOTHING:
                self._render(shadow, instances, chosen, axes, part, name, texel)

    @property
    def present(self) -> int:
        """1 if the map of what never moves shows something, and 2 if that of what moves does."""
        return (self.fixed.content != NOTHING) + 2 * (self.moving.content != NOTHING)

    def _render(
        self,
        shadow: Map,
        instances: Instances,
        casts: Array,
        axes: Array,
        part: tuple[float, ...],
        name: str,
        texel: float,
    ) -> None:
        centers, radii = instances.centers @ axes.T, instances.radii[:, None]
        low, high = centers - radii, centers + radii
        center = np.array(part) * CELL
        near = (low[:, :2] < center + WIDEST / 2).all(axis=1)
        casts = casts & near & (high[:, :2] > center - WIDEST / 2).all(axis=1)
        if not casts.any():
            shadow.fit(axes, np.zeros(3), np.ones(3), instances.origin)
            self._clear(shadow)
            return
        low, high = low[casts].min(axis=0), high[casts].max(axis=0)
        low[:2] = np.maximum(low[:2], center - WIDEST / 2)
        high[:2] = np.minimum(high[:2], center + WIDEST / 2)
        shadow.fit(axes, low, high, instances.origin, texel)
        self._clear(shadow)
        self._program["clip"].write(shadow.clip.T.astype(np.float32).tobytes())
        for batch in instances.batches:
            selection = instances.select(batch, casts, name)
            if selection:
                instances.render(batch, selection, self._program)

    def _clear(self, shadow: Map) -> None:
        shadow.target.use()
        self._gl.enable_only(self._gl.DEPTH_TEST | self._gl.CULL_FACE)
        self._gl.front_face = "ccw"
        self._gl.depth_func = "<"
        shadow.target.clear(depth=1.0)

"""The sky of a world with <sky>: the colors of Gazebo Classic's dome, in all directions.

Light of the sun that air and dust scatter towards the eye, summed over a few points of each ray as
in O'Neil, "Accurate Atmospheric Scattering", GPU Gems 2 (2005), chapter 16, with the numbers that
Gazebo 11's dome has. Its clouds, moon and stars are not rendered: its cameras have no clouds and no
moon either.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from bullet_sim.description.world import Daytime
from bullet_sim.pose import Array, Vec3

GROUND, TOP = 9.77501, 10.2963  # radii of the planet and of its air
EYE = GROUND + 0.01 * (TOP - GROUND)  # distance of the eye from the planet's center
REACH = 1.0  # length of a ray
POINTS = 4  # of a ray
AIR, DUST = 0.0022, 0.000675  # how much they scatter
SUN = 30.0  # its power
WAVELENGTHS = np.array([0.57, 0.54, 0.44])  # of red, green and blue light
FORWARD = 0.991  # how much dust scatters ahead rather than aside, 0 to 1
EXPOSURE = 2.5
THICKNESS = TOP - GROUND
MEAN_HEIGHT = THICKNESS / 2.0  # of the air
MAX_EXPONENT = 80.0  # far below the horizon, where nothing is shown of it
NIGHT = np.array([0.05, 0.05, 0.1])
BELOW = 0.7  # gray of what is seen below the dome
CIRCLES, CIRCLES_BELOW = 83, 12  # of the dome above and below the horizon
PIXELS = 256  # edge of each of the six images
# What the images' centers, right edges and lower edges look at: OpenGL's order and axes.
SIDES = np.array(
    [
        [[1, 0, 0], [0, 0, -1], [0, -1, 0]],
        [[-1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[0, 1, 0], [1, 0, 0], [0, 0, 1]],
        [[0, -1, 0], [1, 0, 0], [0, 0, -1]],
        [[0, 0, 1], [1, 0, 0], [0, -1, 0]],
        [[0, 0, -1], [-1, 0, 0], [0, -1, 0]],
    ],
    float,
)

VERTEX = """
uniform mat3 corner;   // columns: towards the image's center, its right edge, its upper edge
in vec2 in_corner;
out vec3 v_direction;
void main() {
    gl_Position = vec4(in_corner.x, -in_corner.y, 0.0, 1.0);
    v_direction = corner * vec3(1.0, in_corner);
}
"""
FRAGMENT = """
in vec3 v_direction;
uniform samplerCube colors;
out vec4 out_color;
void main() { out_color = vec4(texture(colors, v_direction).rgb, 1.0); }
"""


def sun_direction(daytime: Daytime) -> Vec3:
    """Towards the sun, of length 1: it rises at +y and sets at -y."""
    hour, sunrise, sunset = daytime
    day = min(max(sunset - sunrise, 1e-3), 24.0 - 1e-3)
    if sunrise <= hour <= sunset:
        angle = np.pi * (hour - sunrise) / day
    else:
        angle = np.pi * (1.0 + (hour - sunset) % 24.0 / (24.0 - day))
    return 0.0, float(np.cos(angle)), float(np.sin(angle))


def _depth(cosines: Array) -> Array:
    """How much air a ray from the ground crosses, by the cosine of its angle to the vertical."""
    x = 1.0 - cosines
    return MEAN_HEIGHT * np.exp(-0.00287 + x * (0.459 + x * (3.83 + x * (-6.80 + x * 5.25))))


def _density(heights: Array) -> Array:
    """Of the air at distances from the planet's center, 1 on the ground."""
    return np.exp((GROUND - heights) / (THICKNESS * MEAN_HEIGHT))


def colors(directions: Array, daytime: Daytime) -> Array:
    """The dome's colors, (..., 3) uint8.

    Args:
        directions: (..., 3) of length 1, z upwards.
    """
    sun, eye = np.array(sun_direction(daytime)), np.array([0.0, 0.0, EYE])
    rays = REACH * directions + (0.0, 0.0, GROUND - EYE)  # from the eye to the dome
    lengths = np.linalg.norm(rays, axis=-1, keepdims=True)
    ahead = rays / lengths
    start = _density(np.array(EYE)) * _depth(ahead[..., 2:])
    loss = 4.0 * np.pi * (AIR / WAVELENGTHS**4 + DUST)
    light = np.zeros(directions.shape)
    for number in range(POINTS):
        points = eye + rays * ((number + 0.5) / POINTS)
        heights = np.linalg.norm(points, axis=-1, keepdims=True)
        density = _density(heights)
        to_sun = (points @ sun)[..., None] / heights
        to_eye = (points * ahead).sum(axis=-1, keepdims=True) / heights
        crossed = start + density * (_depth(to_sun) - _depth(to_eye))
        light += np.exp(np.minimum(-crossed * loss, MAX_EXPONENT)) * density
    light *= lengths / (POINTS * THICKNESS) * SUN
    cosines = (ahead @ sun)[..., None]
    aside = 1.0 + FORWARD**2 - 2.0 * FORWARD * cosines
    dust = 1.5 * (1.0 - FORWARD**2) / (2.0 + FORWARD**2) * (1.0 + cosines**2) / aside**1.5
    air = 0.75 * (1.0 + 0.5 * cosines**2)
    dome = 1.0 - np.exp(-EXPOSURE * light * (air * AIR / WAVELENGTHS**4 + dust * DUST))
    dark = np.clip(1.0 - 10.0 * dome.max(axis=-1, keepdims=True), 0.0, 1.0)
    height = directions[..., 2:]
    dome += dark * NIGHT * (2.0 - 0.75 * max(-sun[2], 0.0)) * (1.0 - height) ** 3
    dome = BELOW + _opacity(height) * (dome - BELOW)
    return np.rint(255.0 * np.clip(dome, 0.0, 1.0)).astype(np.uint8)


def _opacity(heights: Array) -> Array:
    """Of the dome, which fades out below the horizon."""
    circles = np.degrees(np.arcsin(np.clip(-heights, 0.0, 1.0))) / (90.0 / CIRCLES)
    left = np.clip((CIRCLES_BELOW - circles) / CIRCLES_BELOW, 0.0, 1.0)
    return np.minimum(2.0 * left**0.75, 1.0)


@lru_cache(maxsize=4)
def images(daytime: Daytime) -> Array:
    """The colors on the six sides of a cube, (6, PIXELS, PIXELS, 3) uint8, as OpenGL has them."""
    steps = (np.arange(PIXELS) + 0.5) / PIXELS * 2.0 - 1.0
    right, down = np.meshgrid(steps, steps)
    sides = SIDES[:, None, None]
    directions = (
        sides[..., 0, :] + right[..., None] * sides[..., 1, :] + down[..., None] * sides[..., 2, :]
    )
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    result = np.full(directions.shape, round(255.0 * BELOW), np.uint8)
    above = _opacity(directions[..., 2]) > 0.0
    result[above] = colors(directions[above], daytime)
    return result


class Sky:
    """Renders the sky where nothing else is.

    Args:
        gl: moderngl.Context.
        program: of VERTEX and FRAGMENT.
    """

    def __init__(self, gl: Any, program: Any) -> None:
        corners = np.array([-1, -1, 3, -1, -1, 3], np.float32)
        self._program = program
        self._array = gl.vertex_array(program, [(gl.buffer(corners.tobytes()), "2f", "in_corner")])
        self._texture = gl.texture_cube((PIXELS, PIXELS), 3)
        self._texture.filter = gl.NEAREST, gl.NEAREST  # half of the time of LINEAR on a processor
        self._daytime: Daytime | None = None

    def render(
        self, rotation: Array, shown: Array, size: tuple[int, int], daytime: Daytime
    ) -> None:
        """Render it.

        Args:
            rotation: (3, 3) of the camera in the world.
            shown: (2, 3), see sensors.camera.shown_intrinsics.
            size: width and height of the image [px].
        """
        if daytime != self._daytime:
            for side, image in enumerate(images(daytime)):
                self._texture.write(side, image.tobytes())
            self._daytime = daytime
        half = np.diag(size) / 2.0
        aside = np.linalg.inv(shown[:, :2])  # from columns and rows to the right and down
        center = aside @ (half.sum(axis=0) - shown[:, 2])
        forward, left, up = rotation.T
        across = np.array([-left, -up])
        corner = np.vstack([forward + center @ across, (aside @ half * (1.0, -1.0)).T @ across])
        corner = np.ascontiguousarray(corner, np.float32)
        self._program["corner"].write(corner.tobytes())
        self._texture.use(0)
        self._array.render()

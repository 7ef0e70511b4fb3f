"""The uniform block `Frame` of the shaders: camera, lights and fog of one picture."""

import numpy as np

from bullet_sim.errors import RenderError

MAX_LIGHTS = 16  # point and spot lights, and suns beyond the first
MATRICES, VECTORS, LIGHT = 3, 7, 5  # numbers of 4x4, of 4, and of 4 a light
KINDS = {"directional": 0.0, "point": 1.0, "spot": 2.0}
SIZE = 16 * MATRICES + 4 * VECTORS + 4 * LIGHT * MAX_LIGHTS

FRAME = """
struct Light { vec4 place; vec4 direction; vec4 diffuse; vec4 specular; vec4 fall; };
layout(std140) uniform Frame {
    mat4 clip;            // from the origin's axes
    mat4 fixed_shadow;    // to texture coordinates and depth of the shadow maps
    mat4 moving_shadow;
    vec4 eye;             // camera; w: offset of shadows along the normal [m], moving map
    vec4 sun;             // towards it; w: the same, fixed map
    vec4 sun_diffuse;
    vec4 sun_specular;
    vec4 ambient;
    vec4 fog;             // colour
    vec4 fog_reach;       // start, 1 / (end - start), density
    Light lights[16];
};
"""


def frame_buffer(gl):
    """moderngl Buffer for the block."""
    return gl.buffer(reserve=4 * SIZE, dynamic=True)


def frame_bytes(clip, eye, scene, sun, lights, shadows):
    """Content of the block (std140).

    Args:
        clip: (4, 4) from places relative to the origin to clip space.
        eye: (3,) [m] of the camera relative to the origin.
        scene: Scene.
        sun: Light that shines from everywhere, or None.
        lights: (n, 5, 4) of the others, as light_rows gives them.
        shadows: Shadows, or None.
    """
    block = np.zeros(SIZE, np.float32)
    fixed = shadows.fixed.lookup() if shadows else np.eye(4)
    moving = shadows.moving.lookup() if shadows else np.eye(4)
    for number, matrix in enumerate((clip, fixed, moving)):
        block[16 * number : 16 * number + 16] = matrix.T.ravel()
    vectors = block[16 * MATRICES : 16 * MATRICES + 4 * VECTORS].reshape(VECTORS, 4)
    vectors[0] = (*eye, shadows.moving.offset if shadows else 0.0)
    if sun is not None:
        vectors[1] = (*(-np.array(sun.direction)), shadows.fixed.offset if shadows else 0.0)
        vectors[2, :3], vectors[3, :3] = sun.diffuse, sun.specular
    vectors[4, :3] = scene.ambient
    if scene.fog is not None:
        fog = scene.fog
        vectors[5, :3] = fog.color
        vectors[6, :3] = fog.start, 1.0 / max(fog.end - fog.start, 1e-6), fog.density
    rows = block[16 * MATRICES + 4 * VECTORS :].reshape(MAX_LIGHTS, LIGHT, 4)
    for row, light in zip(rows, lights):
        row[:] = light
    return block.tobytes()


def light_rows(lights, origin):
    """(n, 5, 4) of the lights in the block.

    Args:
        lights: Lights.
        origin: (3,) [m] to which their places are relative.

    Raises:
        RenderError: too many.
    """
    if len(lights) > MAX_LIGHTS:
        raise RenderError(f"the world has {len(lights)} lights, at most {MAX_LIGHTS} are drawn")
    rows = np.zeros((len(lights), LIGHT, 4), np.float32)
    for row, light in zip(rows, lights):
        row[0] = (*(np.array(light.position) - origin), light.reach)
        row[1] = (*light.direction, np.cos(light.outer / 2.0))
        row[2] = (*light.diffuse, np.cos(light.inner / 2.0))
        row[3] = (*light.specular, light.falloff)
        row[4] = (light.constant, light.linear, light.quadratic, KINDS[light.kind])
    return rows

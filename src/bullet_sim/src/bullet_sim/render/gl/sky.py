"""A sky behind everything, bluer higher up."""

import math

import numpy as np

from bullet_sim.render.sky import HORIZON, ZENITH


class Sky:
    """Draws the sky where nothing else is.

    Args:
        gl: moderngl.Context.
        program: shaders.Programs.sky.
    """

    def __init__(self, gl, program):
        corners = np.array([-1, -1, 3, -1, -1, 3], np.float32)
        self._program = program
        self._array = gl.vertex_array(program, [(gl.buffer(corners.tobytes()), "2f", "in_corner")])
        program["zenith"].value = tuple(value / 255.0 for value in ZENITH)
        program["horizon"].value = tuple(value / 255.0 for value in HORIZON)

    def draw(self, rotation, horizontal_fov, aspect):
        """Draw it.

        Args:
            rotation: (3, 3) of the camera in the world.
            horizontal_fov: [rad].
            aspect: width / height.
        """
        half = math.tan(horizontal_fov / 2.0)
        forward, left, up = rotation.T
        corner = np.array([forward, -half * left, half / aspect * up], np.float32)
        self._program["corner"].write(corner.tobytes())
        self._array.render()

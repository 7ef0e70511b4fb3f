"""Cameras as OpenGL has them: clip matrices with reversed depth, what they see, distances."""

import math

import numpy as np

from bullet_sim.sensors.camera import view_matrix


def projection(horizontal_fov, aspect, near, far):
    """(4, 4) from the eye's axes to clip space, upside down, with depth 1 near and 0 far.

    Upside down, since OpenGL's first row is the lowest and a picture's the uppermost.

    Args:
        horizontal_fov: [rad].
        aspect: width / height.
        near, far: clip distances [m].
    """
    x = 1.0 / math.tan(horizontal_fov / 2.0)
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = x, -x * aspect
    matrix[2, 2], matrix[2, 3] = near / (far - near), near * far / (far - near)
    matrix[3, 2] = -1.0
    return matrix


def view(position, rotation):
    """(4, 4) from the world to the eye (x right, y up, looking along -z)."""
    return np.reshape(view_matrix(position, rotation), (4, 4)).T


def view_planes(clip):
    """The six planes of a view, (6, 4): distance of a point inside is positive [m].

    Args:
        clip: (4, 4) to clip space as `projection` has it (Gribb and Hartmann 2001).
    """
    sides = clip[3] + np.array([clip[0], -clip[0], clip[1], -clip[1]])
    planes = np.vstack([sides, clip[3] - clip[2], clip[2]])
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)


def in_view(planes, centres, radii, ends=None):
    """Which spheres touch a view, (n,) bool.

    Args:
        planes: as view_planes gives them.
        centres: (n, 3) [m].
        radii: (n,) [m].
        ends: (n, 3) to which they are swept, or None.
    """
    distances = centres @ planes[:, :3].T + planes[:, 3]
    if ends is not None:
        distances = np.maximum(distances, ends @ planes[:, :3].T + planes[:, 3])
    return (distances > -radii[:, None]).all(axis=1)


def metres(buffer, near, far, out=None):
    """Distances along the optical axis of a reversed depth buffer.

    Args:
        buffer: (H, W) float32, 1 at the near plane ... 0 at the far plane and where nothing is.
        near, far: clip distances [m].
        out: array that takes the result; None: a new one.

    Returns:
        (H, W) float32 [m].
    """
    scale, shift = near * far / (far - near), near / (far - near)
    out = np.add(buffer, np.float32(shift), out=out)
    np.divide(np.float32(scale), out, out=out)
    out[buffer == 0.0] = far
    return out

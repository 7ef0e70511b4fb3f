"""A camera that orbits a point, and its projection of points in the world."""

import math

import numpy as np
from bullet_sim.pose import matrix_from_rpy

RADIANS_PER_PIXEL = 0.006
ZOOM_PER_NOTCH = 0.85
NEAREST, FARTHEST = 0.05, 500.0  # [m] from the target
STEEPEST = math.radians(89.0)


class OrbitCamera:
    """Looks at `target` from `distance`.

    Attributes:
        target: (3,) [m], world frame.
        distance: [m].
        yaw: heading of the view [rad], 0 looks along the world's x.
        pitch: downward tilt of the view [rad].
        horizontal_fov: [rad].
    """

    def __init__(
        self,
        target=(0.0, 0.0, 0.0),
        distance=4.0,
        yaw=math.radians(35.0),
        pitch=math.radians(30.0),
        horizontal_fov=math.radians(60.0),
    ):
        self.target = np.array(target, float)
        self.distance, self.yaw, self.pitch = distance, yaw, pitch
        self.horizontal_fov = horizontal_fov

    @property
    def rotation(self):
        """(3, 3): camera frame (x along the view, y left, z up) in the world."""
        return matrix_from_rpy((0.0, self.pitch, self.yaw))

    @property
    def position(self):
        """(3,) [m], world frame."""
        return self.target - self.distance * self.rotation[:, 0]

    @property
    def pose(self):
        """(xyz [m], rpy [rad]) of the camera frame in the world, as tuples of floats."""
        return (tuple(self.position.tolist()), (0.0, float(self.pitch), float(self.yaw)))

    @property
    def clip(self):
        """(near, far) [m]."""
        return max(0.01, 0.02 * self.distance), max(200.0, 20.0 * self.distance)

    def orbit(self, right, down):
        """Turn around the target as if the pointer dragged the scene by so many pixels."""
        self.yaw = math.remainder(self.yaw - RADIANS_PER_PIXEL * right, 2.0 * math.pi)
        pitch = self.pitch + RADIANS_PER_PIXEL * down
        self.pitch = min(STEEPEST, max(-STEEPEST, pitch))

    def pan(self, right, down, width):
        """Shift so that what lies at the target's distance follows the pointer.

        Args:
            right, down: drag [px].
            width: of the picture [px].
        """
        metres = 2.0 * self.distance * math.tan(self.horizontal_fov / 2.0) / width
        _, left, up = self.rotation.T
        self.target = self.target + metres * (right * left + down * up)

    def zoom(self, notches):
        """Move nearer by so many notches of the wheel."""
        self.distance = min(FARTHEST, max(NEAREST, self.distance * ZOOM_PER_NOTCH**notches))


def project(points, pose, horizontal_fov, width, height):
    """Project points into a camera's picture.

    Args:
        points: (n, 3) [m], world frame.
        pose: (xyz [m], rpy [rad]) of the camera.
        horizontal_fov: [rad].
        width, height: of the picture [px].

    Returns:
        (n, 2) [px] right and down from the upper left corner, and (n,) depth along the view [m];
        pixels of points whose depth is not positive are meaningless.
    """
    xyz, rpy = pose
    seen = (np.asarray(points, float) - xyz) @ matrix_from_rpy(rpy)
    depth = seen[:, 0]
    focal = width / (2.0 * math.tan(horizontal_fov / 2.0))
    scale = focal / np.where(depth > 0.0, depth, np.inf)
    return np.column_stack(
        [width / 2.0 - scale * seen[:, 1], height / 2.0 - scale * seen[:, 2]]
    ), depth


def project_rays(origin, ends, pose, horizontal_fov, width, height, near=0.01):
    """Project rays into lines; the part behind the camera is clipped.

    Args:
        origin: (3,) [m], world frame.
        ends: (n, 3) [m], world frame.
        pose, horizontal_fov, width, height: as in project.
        near: depth at which lines are clipped [m].

    Returns:
        (m, 4) [px]: x, y of the start and of the end; m <= n.
    """
    ends = np.asarray(ends, float)
    starts = np.broadcast_to(np.asarray(origin, float), ends.shape)
    forward = matrix_from_rpy(pose[1])[:, 0]
    first, last = (starts - pose[0]) @ forward, (ends - pose[0]) @ forward
    keep = (first > near) | (last > near)
    starts, ends, first, last = starts[keep], ends[keep], first[keep], last[keep]
    run = np.where(first == last, 1.0, last - first)
    cut = starts + ((near - first) / run)[:, None] * (ends - starts)
    starts = np.where((first < near)[:, None], cut, starts)
    ends = np.where((last < near)[:, None], cut, ends)
    view = (pose, horizontal_fov, width, height)
    return np.hstack([project(starts, *view)[0], project(ends, *view)[0]])

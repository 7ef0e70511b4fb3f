"""Rigid transforms: positions [m] with unit quaternions (x, y, z, w)."""

import math
from dataclasses import dataclass

import numpy as np

MAX_POSITION = 1e9  # [m] further out nothing can be placed
QUATERNION_LENGTHS = (1e-6, 1e6)  # of those that can be normalised
PLACEABLE = (
    f"must be finite, at most {MAX_POSITION:g} m along each axis, the length of the "
    "quaternion {:g} to {:g}".format(*QUATERNION_LENGTHS)
)


def cross(a, b):
    """Cross product (3,) of two vectors of three numbers; numpy's takes 30 times as long."""
    (ax, ay, az), (bx, by, bz) = a, b
    return np.array((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))


def quaternion_from_rpy(roll, pitch, yaw):
    """Quaternion of fixed-axis angles [rad], as URDF and SDF define them (Rz Ry Rx)."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def rpy_from_quaternion(quaternion):
    """Fixed-axis angles (roll, pitch, yaw) [rad] of a unit quaternion."""
    x, y, z, w = quaternion
    pitch = max(-1.0, min(1.0, 2 * (w * y - z * x)))
    return (
        math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        math.asin(pitch),
        math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    )


def matrix_from_quaternion(quaternion):
    """Rotation matrix (3, 3) of a unit quaternion."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def multiply(a, b):
    """Product of two quaternions."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


@dataclass(frozen=True)
class Pose:
    """A frame's position [m] and orientation (x, y, z, w) in a parent frame."""

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)

    @classmethod
    def from_xyz_rpy(cls, xyz=(0, 0, 0), rpy=(0, 0, 0)):
        """Pose from a translation [m] and fixed-axis angles [rad]."""
        return cls(tuple(float(v) for v in xyz), quaternion_from_rpy(*rpy))

    @property
    def rpy(self):
        """Fixed-axis angles [rad]."""
        return rpy_from_quaternion(self.orientation)

    @property
    def matrix(self):
        """Rotation matrix (3, 3)."""
        return matrix_from_quaternion(self.orientation)

    def __mul__(self, other):
        """Compose: the other pose, given in this frame, in this frame's parent."""
        position = np.asarray(self.position) + self.matrix @ np.asarray(other.position)
        return Pose(tuple(position.tolist()), multiply(self.orientation, other.orientation))

    def inverse(self):
        """The parent's pose in this frame."""
        x, y, z, w = self.orientation
        back = (-x, -y, -z, w)
        position = -(matrix_from_quaternion(back) @ np.asarray(self.position))
        return Pose(tuple(position.tolist()), back)

    def is_placeable(self):
        """Whether something can be put there: what PLACEABLE says."""
        length = math.sqrt(sum(q * q for q in self.orientation))
        return (
            all(abs(value) <= MAX_POSITION for value in self.position)
            and QUATERNION_LENGTHS[0] <= length <= QUATERNION_LENGTHS[1]
        )

    def normalised(self):
        """The same pose with a unit quaternion."""
        length = math.sqrt(sum(q * q for q in self.orientation))
        return Pose(self.position, tuple(q / length for q in self.orientation))

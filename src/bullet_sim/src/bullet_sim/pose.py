"""Rigid transforms: positions [m] with unit quaternions (x, y, z, w)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Vector = Sequence[float] | np.ndarray
Point = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

MAX_POSITION = 1e9  # [m] bound of a placeable position
QUATERNION_LENGTHS = (1e-6, 1e6)  # lengths that can be normalised
PLACEABLE = (
    f"must be finite, at most {MAX_POSITION:g} m along each axis, the length of the "
    "quaternion {:g} to {:g}".format(*QUATERNION_LENGTHS)
)


def cross(a: Vector, b: Vector) -> np.ndarray:
    """Cross product (3,) of two vectors of three numbers; numpy's is 30 times as slow."""
    (ax, ay, az), (bx, by, bz) = a, b
    return np.array((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))


def quaternion_from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
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


def rpy_from_quaternion(quaternion: Vector) -> Point:
    """Fixed-axis angles (roll, pitch, yaw) [rad] of a unit quaternion."""
    x, y, z, w = quaternion
    pitch = max(-1.0, min(1.0, 2 * (w * y - z * x)))
    return (
        math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        math.asin(pitch),
        math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    )


def matrix_from_quaternion(quaternion: Vector) -> np.ndarray:
    """Rotation matrix (3, 3) of a unit quaternion."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def multiply(a: Vector, b: Vector) -> Quaternion:
    """Product of two quaternions."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def compose(
    position: Vector, orientation: Vector, offset: Vector, turn: Vector
) -> tuple[Point, Quaternion]:
    """Pose of a frame that has a pose in another one; numbers alone, several times Pose's pace.

    (PyBullet's multiplyTransforms has single precision.)

    Args:
        position, orientation: of the other frame, unit quaternion.
        offset, turn: of the frame in it.
    """
    x, y, z, w = orientation
    a, b, c = offset
    # t = 2 q x v; v' = v + w t + q x t
    i, j, k = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (
        position[0] + a + w * i + y * k - z * j,
        position[1] + b + w * j + z * i - x * k,
        position[2] + c + w * k + x * j - y * i,
    ), multiply(orientation, turn)


@dataclass(frozen=True)
class Pose:
    """A frame's position [m] and orientation (x, y, z, w) in a parent frame."""

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)

    @classmethod
    def from_xyz_rpy(cls, xyz: Vector = (0, 0, 0), rpy: Vector = (0, 0, 0)) -> "Pose":
        """Pose from a translation [m] and fixed-axis angles [rad]."""
        x, y, z = xyz
        return cls((float(x), float(y), float(z)), quaternion_from_rpy(*rpy))

    @property
    def rpy(self) -> Point:
        """Fixed-axis angles [rad]."""
        return rpy_from_quaternion(self.orientation)

    @property
    def matrix(self) -> np.ndarray:
        """Rotation matrix (3, 3)."""
        return matrix_from_quaternion(self.orientation)

    def __mul__(self, other: "Pose") -> "Pose":
        """Compose: the other pose, given in this frame, in this frame's parent."""
        position = np.asarray(self.position) + self.matrix @ np.asarray(other.position)
        x, y, z = position.tolist()
        return Pose((x, y, z), multiply(self.orientation, other.orientation))

    def inverse(self) -> "Pose":
        """The parent's pose in this frame."""
        x, y, z, w = self.orientation
        back = (-x, -y, -z, w)
        a, b, c = (-(matrix_from_quaternion(back) @ np.asarray(self.position))).tolist()
        return Pose((a, b, c), back)

    def is_placeable(self) -> bool:
        """Whether a body can be placed there, see PLACEABLE."""
        length = math.sqrt(sum(q * q for q in self.orientation))
        return (
            all(abs(value) <= MAX_POSITION for value in self.position)
            and QUATERNION_LENGTHS[0] <= length <= QUATERNION_LENGTHS[1]
        )

    def normalised(self) -> "Pose":
        """The same pose with a unit quaternion."""
        length = math.sqrt(sum(q * q for q in self.orientation))
        x, y, z, w = self.orientation
        return Pose(self.position, (x / length, y / length, z / length, w / length))

"""Rigid transforms and rotations: positions [m] with unit quaternions (x, y, z, w).

A pose is (position (3,) [m], orientation quaternion (x, y, z, w)). `R` of frame B in frame A
rotates a vector written in B into the same vector written in A.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Sequence, Tuple, Union

import numpy as np

if TYPE_CHECKING:
    from typing_extensions import TypeAlias

Array: TypeAlias = np.ndarray  # numpy.typing takes 6 to 30 ms to import
Vector = Union[Sequence[float], Array]
Vec3 = Tuple[float, float, float]
Quat = Tuple[float, float, float, float]
PoseTuple = Tuple[Vec3, Vec3]  # xyz [m], rpy [rad]
Motion = Tuple[Vec3, Quat, Vec3, Vec3]  # position, orientation, linear [m/s], angular [rad/s]
UNTURNED: Quat = (0.0, 0.0, 0.0, 1.0)

ZERO: Vec3 = (0.0, 0.0, 0.0)
ZERO_POSE: PoseTuple = (ZERO, ZERO)
MAX_POSITION = 1e9  # [m] bound of a placeable position
QUATERNION_LENGTHS = (1e-6, 1e6)  # lengths that can be normalized
PLACEABLE = (
    f"must be finite, at most {MAX_POSITION:g} m along each axis, the length of the "
    "quaternion {:g} to {:g}".format(*QUATERNION_LENGTHS)
)


def cross(a: Vector, b: Vector) -> Array:
    """Cross product (3,) of two vectors of three numbers; numpy's is 30 times as slow."""
    (ax, ay, az), (bx, by, bz) = a, b
    return np.array((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))


def vector3(values: Vector) -> Vec3:
    """Three floats."""
    x, y, z = values
    return float(x), float(y), float(z)


def quaternion_from_yaw(yaw: float) -> Quat:
    """Quaternion of an angle [rad] about z."""
    return 0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)


def quaternion_from_rpy(roll: float, pitch: float, yaw: float) -> Quat:
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


def rpy_from_quaternion(quaternion: Vector) -> Vec3:
    """Fixed-axis angles (roll, pitch, yaw) [rad] of a unit quaternion.

    By half the sum and half the difference of yaw and roll, which stay exact where the pitch is
    90 degrees: one of them counts alone there, and the other may be anything (Bernardes and
    Viollet, "Quaternion to Euler angles conversion", PLoS ONE 17(11), 2022).
    """
    x, y, z, w = quaternion
    half_sum, half_difference = math.atan2(z + x, w - y), math.atan2(z - x, w + y)
    return (
        math.remainder(half_sum - half_difference, math.tau),
        2.0 * math.atan2(math.hypot(z - x, w + y), math.hypot(z + x, w - y)) - 0.5 * math.pi,
        math.remainder(half_sum + half_difference, math.tau),
    )


def matrix_from_quaternion(quaternion: Vector) -> Array:
    """Rotation matrix (3, 3) of a unit quaternion."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def multiply(a: Vector, b: Vector) -> Quat:
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
    position: Vector, orientation: Vector, offset: Vector, rotation: Vector
) -> tuple[Vec3, Quat]:
    """Pose of a frame that has a pose in another one.

    On plain numbers, several times as fast as Pose.
    (PyBullet's multiplyTransforms has single precision.)

    Args:
        position, orientation: of the other frame, unit quaternion.
        offset, rotation: of the frame in it.
    """
    x, y, z, w = orientation
    a, b, c = offset
    # t = 2 q x v; v' = v + w t + q x t
    i, j, k = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (
        position[0] + a + w * i + y * k - z * j,
        position[1] + b + w * j + z * i - x * k,
        position[2] + c + w * k + x * j - y * i,
    ), multiply(orientation, rotation)


def velocity_at(point: Vec3, center: Vec3, linear: Vec3, angular: Vec3) -> Vec3:
    """Velocity [m/s] of a rigid body's material at a point [m].

    Args:
        center, linear, angular: a point of the body [m], its velocity, and the body's [rad/s].
    """
    (u, v, w), (a, b, c) = linear, angular
    x, y, z = point[0] - center[0], point[1] - center[1], point[2] - center[2]
    return u + b * z - c * y, v + c * x - a * z, w + a * y - b * x


@dataclass(frozen=True)
class Pose:
    """A frame's position [m] and orientation (x, y, z, w) in a parent frame."""

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)

    @classmethod
    def from_xyz_rpy(cls, xyz: Vector = (0, 0, 0), rpy: Vector = (0, 0, 0)) -> Pose:
        """Pose from a translation [m] and fixed-axis angles [rad]."""
        x, y, z = xyz
        return cls((float(x), float(y), float(z)), quaternion_from_rpy(*rpy))

    @property
    def rpy(self) -> Vec3:
        """Fixed-axis angles [rad]."""
        return rpy_from_quaternion(self.orientation)

    @property
    def matrix(self) -> Array:
        """Rotation matrix (3, 3)."""
        return matrix_from_quaternion(self.orientation)

    def __mul__(self, other: Pose) -> Pose:
        """Compose: the other pose, given in this frame, in this frame's parent."""
        position = np.asarray(self.position) + self.matrix @ np.asarray(other.position)
        x, y, z = position.tolist()
        return Pose((x, y, z), multiply(self.orientation, other.orientation))

    def inverse(self) -> Pose:
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

    def normalized(self) -> Pose:
        """The same pose with a unit quaternion."""
        length = math.sqrt(sum(q * q for q in self.orientation))
        x, y, z, w = self.orientation
        return Pose(self.position, (x / length, y / length, z / length, w / length))

    normalised = normalized  # the former name


def rows_from_quaternion(quaternion: Vector) -> tuple[Vec3, Vec3, Vec3]:
    """Rotation matrix of a quaternion as three tuples: numpy is several times as slow.

    Args:
        quaternion: (x, y, z, w), any positive length.

    Raises:
        ValueError: the quaternion has length zero or is not finite.
    """
    x, y, z, w = map(float, quaternion)
    square = x * x + y * y + z * z + w * w
    if not 1e-24 <= square < math.inf:
        raise ValueError(
            f"orientation {tuple(quaternion)} is no rotation: "
            "a quaternion (x, y, z, w) of length 1 is expected"
        )
    return turned_axes(x, y, z, w, 2.0 / square)


def turned_axes(x: Any, y: Any, z: Any, w: Any, s: Any) -> tuple[Any, Any, Any]:
    """Rows of the matrix of a quaternion; s: 2 over the square of its length. Also of arrays."""
    return (
        (1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)),
        (s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)),
        (s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)),
    )


def rotation_matrix(quaternion: Vector) -> Array:
    """As rows_from_quaternion, (3, 3) float64."""
    return np.array(rows_from_quaternion(quaternion))


def matrix_from_rpy(rpy: Vector) -> Array:
    """Rotation matrix of URDF's fixed-axis roll, pitch, yaw: Rz(yaw) Ry(pitch) Rx(roll).

    Args:
        rpy: (roll, pitch, yaw) [rad].

    Returns:
        (3, 3) float64.
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def sensor_in_world(
    link_position: Vector, link_orientation: Vector, pose: tuple[Vector, Vector]
) -> tuple[Array, Array]:
    """Pose of a sensor that is fixed to a link.

    Args:
        link_position: (3,) [m], the link frame's origin in the world.
        link_orientation: (x, y, z, w), link frame in the world.
        pose: (xyz (3,) [m], rpy (3,) [rad]), the sensor in the link frame.

    Returns:
        (position (3,) [m] in the world, R (3, 3) sensor frame in the world).
    """
    xyz, rpy = pose
    link = rotation_matrix(link_orientation)
    position = np.asarray(link_position, dtype=float) + link @ np.asarray(xyz, dtype=float)
    return position, link @ matrix_from_rpy(rpy)

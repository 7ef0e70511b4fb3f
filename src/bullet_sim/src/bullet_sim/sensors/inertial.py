"""Ground truth, IMU, GPS, magnetometer and joint wrenches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.description.lump import WELD_AXIS
from bullet_sim.description.world import Place
from bullet_sim.pose import (
    Array,
    Motion,
    Quat,
    Vec3,
    Vector,
    multiply,
    rotation_matrix,
    rows_from_quaternion,
    turned_axes,
)

if TYPE_CHECKING:
    from bullet_sim.models.model import Model


def specific_force(
    velocity: Vec3, before: tuple[Vec3, float] | None, time: float, gravity: Vec3
) -> Vec3:
    """What an accelerometer feels on average since its last reading, [m/s^2] along world axes.

    At rest that is 9.81 m/s^2 upwards (REP 145).

    Args:
        velocity: [m/s] in the world.
        before: velocity and time [s] of the last reading; None: at rest until now.
        time: [s].
        gravity: [m/s^2] in the world.

    Raises:
        ValueError: no time has passed.
    """
    x, y, z = gravity
    if before is None:
        return -x, -y, -z
    (u, v, w), (a, b, c), elapsed = velocity, before[0], time - before[1]
    if not elapsed > 0.0:
        raise ValueError(f"elapsed {elapsed} s: time > 0 between two readings is expected")
    return (u - a) / elapsed - x, (v - b) / elapsed - y, (w - c) / elapsed - z


def tilt_error(orientation: Vector, bias: Vector, gravity: float, axes: Vector) -> Quat:
    """Orientation that an IMU with a biased accelerometer reports: its bias tilts the vertical.

    As hector's plugin: small angles, about the world's x and y.

    Args:
        bias: (3,) of the accelerometer [m/s^2].
        axes: quaternion of the axes in which the bias counts.
        gravity: [m/s^2], above 0.
    """
    x, y, _ = (rotation_matrix(axes) @ np.asarray(bias, dtype=float)).tolist()
    roll, pitch = 0.5 * y / gravity, -0.5 * x / gravity
    length = math.sqrt(roll * roll + pitch * pitch + 1.0)
    return multiply((roll / length, pitch / length, 0.0, 1.0 / length), orientation)


def twist(
    orientation: Vector, linear_in_world: Vector, angular_in_world: Vector, in_child: bool = True
) -> tuple[Vec3, Vec3]:
    """Twist of a link in the axes an Odometry message asks for.

    nav_msgs/Odometry: the twist is in the child frame. Gazebo's p3d plugin leaves it in the
    world's axes; that is in_child=False.

    Args:
        orientation: (x, y, z, w), link frame in the world.
        linear_in_world: (3,) [m/s], of the link frame's origin, in world axes.
        angular_in_world: (3,) [rad/s], in world axes.
        in_child: write both in the link's axes.

    Returns:
        (linear (3,) [m/s], angular (3,) [rad/s]), plain numbers.

    Raises:
        ValueError: the orientation has length zero or is not finite.
    """
    if not in_child:
        (u, v, w), (p, q, r) = map(float, linear_in_world), map(float, angular_in_world)
        return (u, v, w), (p, q, r)
    (a, d, g), (b, e, h), (c, f, i) = rows_from_quaternion(orientation)  # its transpose
    (u, v, w), (p, q, r) = linear_in_world, angular_in_world
    return (
        (a * u + b * v + c * w, d * u + e * v + f * w, g * u + h * v + i * w),
        (a * p + b * q + c * r, d * p + e * q + f * r, g * p + h * q + i * r),
    )


def specific_forces(
    velocity: Any, before: tuple[Vec3, float] | None, times: Sequence[float], gravity: Vec3
) -> Any:
    """As specific_force() at each of several times: three arrays (k,), of three of velocities."""
    start, since = ((0.0, 0.0, 0.0), times[0] - 1.0) if before is None else before
    elapsed = np.array([after - at for at, after in zip((since, *times), times)])
    forces = []
    for values, first, g in zip(velocity, start, gravity):
        change = np.empty(len(times))
        change[0], change[1:] = values[0] - first, values[1:] - values[:-1]
        forces.append(change / elapsed - g)
        if before is None:
            forces[-1][0] = -g
    return forces


def twists(orientation: Any, linear: Any, angular: Any, in_child: bool = True) -> Any:
    """As twist(), of sequences of arrays (k,)."""
    if not in_child:
        return linear, angular
    x, y, z, w = orientation
    square = x * x + y * y + z * z + w * w
    columns = tuple(zip(*turned_axes(x, y, z, w, 2.0 / square)))
    return tuple(
        tuple(a * u + b * v + c * w for a, b, c in columns) for u, v, w in (linear, angular)
    )


def relative_motion(motion: Motion, frame: Motion) -> Motion:
    """Motion of a link relative to another, as libgazebo_ros_p3d computes it.

    The position is in the frame's axes. The orientation is the link's times the inverse of the
    frame's, and the differences of velocities are rotated by the frame's orientation (not by its
    inverse): they are those of the frame's axes only while it is parallel to the world.

    Args:
        motion, frame: (position [m], orientation, linear [m/s], angular [rad/s]) in the world.
    """
    rotation = rotation_matrix(frame[1])
    x, y, z = (rotation.T @ np.subtract(motion[0], frame[0])).tolist()
    (i, j, k, w), (u, v, s), (p, q, r) = (
        frame[1],
        (rotation @ np.subtract(motion[2], frame[2])).tolist(),
        (rotation @ np.subtract(motion[3], frame[3])).tolist(),
    )
    return (x, y, z), multiply(motion[1], (-i, -j, -k, w)), (u, v, s), (p, q, r)


EQUATORIAL_RADIUS = 6378137.0  # [m], WGS 84
FLATTENING = 1.0 / 298.257223563  # WGS 84


def radii(latitude: float) -> tuple[float, float]:
    """Meters per radian of latitude and of longitude, on the ellipsoid.

    Args:
        latitude: [degrees].

    Returns:
        (north, east) [m]: the radius of curvature in the meridian, and that of the parallel.
    """
    eccentricity = 1.0 - (1.0 - FLATTENING) ** 2  # squared
    sine = math.sin(math.radians(latitude))
    factor = 1.0 / (1.0 - eccentricity * sine * sine)
    vertical = EQUATORIAL_RADIUS * math.sqrt(factor)
    return vertical * (1.0 - eccentricity) * factor, vertical * math.cos(math.radians(latitude))


def to_north_west(heading: float, x: float, y: float) -> tuple[float, float]:
    """Components to the north and to the west of a horizontal vector of the world.

    Args:
        heading: of the world's x axis [rad], clockwise from north.
    """
    c, s = math.cos(heading), math.sin(heading)
    return c * x + s * y, -s * x + c * y


def fix(position: Vector, place: Place, meters: tuple[float, float]) -> Vec3:
    """Geodetic position of a point of the world.

    Args:
        position: (3,) [m] in the world.
        place: of the world.
        meters: per radian, see radii().

    Returns:
        latitude, longitude [degrees], altitude [m].
    """
    north, west = to_north_west(place.heading, position[0], position[1])
    return (
        place.latitude + math.degrees(north / meters[0]),
        place.longitude - math.degrees(west / meters[1]),
        place.altitude + position[2],
    )


def field(magnitude: float, heading: float, declination: float, inclination: float) -> Array:
    """The earth's magnetic field along the world's axes, (3,), in the unit of its magnitude.

    Args:
        magnitude: of the field.
        heading: of the world's x axis [rad], clockwise from north.
        declination: of the field [rad], clockwise from north.
        inclination: of the field [rad], positive downwards.
    """
    level = magnitude * math.cos(inclination)
    return np.array(
        (
            level * math.cos(heading - declination),
            level * math.sin(heading - declination),
            -magnitude * math.sin(inclination),
        )
    )


def joint_wrench(model: Model, joint: str) -> tuple[Array, Array]:
    """Force and torque of a joint's child link on its parent link.

    Args:
        model: of the world; the joint is among those that it measures.

    Returns:
        force (3,) [N], torque (3,) [N m] about the joint, along the child link's axes: what Gazebo
        calls the wrench on body 2.
    """
    motor = model.body.motor(joint)
    force, torque, effort = motor.load()
    limits = model.joints.limits.get(joint)
    axis = np.asarray(limits.axis if limits is not None else WELD_AXIS)
    if limits is not None and motor.applied is not None:
        effort = motor.applied
    part = force if limits is not None and limits.kind == "prismatic" else torque
    part += (effort - part @ axis) * axis
    return -force, -torque


def net_wrench(
    mass: float,
    inertia: Array,
    before: tuple[Array, Array],
    after: tuple[Array, Array],
    period: float,
) -> tuple[Array, Array]:
    """Mean net force and torque on a rigid body over a period.

    Args:
        mass: [kg].
        inertia: (3, 3) [kg m^2] about its center, world axes.
        before, after: (velocity of the center (3,), angular velocity (3,)), world axes.
        period: [s].

    Returns:
        force (3,) [N], torque (3,) [N m], world axes.
    """
    force = mass * (after[0] - before[0]) / period
    spin = inertia @ after[1]
    return force, inertia @ (after[1] - before[1]) / period + np.cross(after[1], spin)

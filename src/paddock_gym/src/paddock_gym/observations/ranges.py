"""The observation `lidar`: ranges of 64 rays over 300 degrees."""

import math

import numpy as np

RAYS = 64
HALF_ANGLE = math.radians(150.0)
FARTHEST = 10.0  # [m]: from here on a ray counts as free
SHAPE = (RAYS,)
ANGLES = np.linspace(-HALF_ANGLE, HALF_ANGLE, RAYS)  # [rad], positive to the left


def ranges(measured):
    """Observe ranges.

    Args:
        measured: (64,) [m] along ANGLES; +inf: nothing there, -inf: too near (REP 117).

    Returns:
        (64,) float32, 0 to 1 of FARTHEST.
    """
    # np.clip and np.nan_to_num take several times as long; fmin turns NaN into FARTHEST
    near = np.maximum(np.fmin(np.asarray(measured, dtype=float), FARTHEST), 0.0)
    return (near / FARTHEST).astype(np.float32)


def pick_rays(angle_min, angle_increment, count):
    """Numbers of the rays of another scan that are nearest to ANGLES.

    Args:
        angle_min, angle_increment: of the scan [rad].
        count: of its rays.

    Returns:
        (64,) int.

    Raises:
        ValueError: the scan does not reach from -150 to 150 degrees, or has too few rays.
    """
    end = angle_min + angle_increment * (count - 1)
    tolerance = abs(angle_increment) / 2.0 + 1e-3
    if count < RAYS or angle_min > -HALF_ANGLE + tolerance or end < HALF_ANGLE - tolerance:
        raise ValueError(
            f"the scan has {count} rays from {math.degrees(angle_min):.0f} to "
            f"{math.degrees(end):.0f} degrees; the policy needs {RAYS} or more from -150 to 150"
        )
    return np.clip(np.rint((ANGLES - angle_min) / angle_increment).astype(int), 0, count - 1)

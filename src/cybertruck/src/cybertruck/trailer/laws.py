"""Steering laws: the truck's curvature for a target trailer curvature or hitch angle."""

import math

import numpy as np

from cybertruck.trailer.geometry import steady_trailer

NEARLY_RIGHT = math.radians(89.9)  # where the tangent of the law below is clipped [rad]


def curvature_law(target_curvature, hitch_angle, geometry):
    """Returns the truck's curvature that sets the trailer's curvature immediately (off-axle hitch).

    F = (κd L2 cos ψ + sin ψ) / (κd L1 L2 sin ψ - L1 cos ψ) = -tan(ψ + atan(κd L2)) / L1:
    the hitch has to move at atan(κd L2) to the trailer, so at ψ + atan(κd L2) to the truck. Beyond
    a right angle, where the fraction changes its sign, the law stays at its maximum, which unfolds.

    Args:
        target_curvature: κd of the trailer [1/m].
        hitch_angle: ψ [rad].
        geometry: Geometry with a hitch behind the axle.

    Returns:
        F [1/m], not limited to what the steering can do.
    """
    angle = hitch_angle + np.arctan(target_curvature * geometry.tongue_length)
    return -np.tan(np.clip(angle, -NEARLY_RIGHT, NEARLY_RIGHT)) / geometry.hitch_offset


def hitch_law(target_angle, hitch_angle, decay_length, geometry):
    """Returns the truck's curvature that makes the hitch angle decay to a target when backing.

    Per meter driven backwards dψ/ds = sin ψ / L2 + (L1/L2 cos ψ + 1) F; the law makes that
    -(ψ - ψd) / decay_length. It works for on-axle hitches, too.

    Args:
        target_angle: ψd [rad].
        hitch_angle: ψ [rad].
        decay_length: Distance in which the difference falls to 1/e [m].

    Returns:
        F [1/m], not limited to what the steering can do.
    """
    target_rate = -(hitch_angle - target_angle) / decay_length
    ratio = geometry.hitch_offset / geometry.tongue_length
    return (target_rate - np.sin(hitch_angle) / geometry.tongue_length) / (
        ratio * np.cos(hitch_angle) + 1.0
    )


def backing_law(target_curvature, hitch_angle, decay_length, geometry):
    """Returns the truck's curvature for a target trailer curvature, for any hitch; see hold_law.

    Off-axle the curvature is set directly. On-axle, or nearly, it follows the hitch angle, which is
    controlled instead: ψd = -atan(κd L2), a cascade.
    """
    if geometry.near_axle:
        return hold_law(target_curvature, hitch_angle, decay_length, geometry)
    return curvature_law(target_curvature, hitch_angle, geometry)


def hold_law(target_curvature, hitch_angle, decay_length, geometry):
    """Returns the truck's curvature with which the trailer settles on a circle, backwards.

    Asymptotic curvature stabilisation after Werling et al. 2014 (doi 10.1109/TITS.2013.2285602):
    the hitch angle of the steady circle is approached along arc length, and the trailer's
    curvature with it.

    Args:
        target_curvature: κd of the trailer [1/m].
        hitch_angle: ψ [rad].
        decay_length: Distance in which the hitch angle's error falls to 1/e [m].
    """
    _, target_angle = steady_trailer(target_curvature, geometry)
    return hitch_law(target_angle, hitch_angle, decay_length, geometry)

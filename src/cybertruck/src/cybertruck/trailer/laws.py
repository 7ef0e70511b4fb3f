"""Steering laws: the truck's curvature for a wanted trailer curvature or hitch angle."""

import math

import numpy as np

from cybertruck.trailer.geometry import steady_trailer

NEARLY_RIGHT = math.radians(89.9)  # where the tangent of the law below is cut off [rad]


def curvature_law(wanted, hitch_angle, geometry):
    """Returns the truck's curvature that gives the trailer a curvature at once (off-axle hitch).

    F = (κd L2 cos ψ + sin ψ) / (κd L1 L2 sin ψ - L1 cos ψ) = -tan(ψ + atan(κd L2)) / L1:
    the hitch has to move at atan(κd L2) to the trailer, so at ψ + atan(κd L2) to the truck. Beyond
    a right angle, where the fraction changes its sign, the law stays at its greatest value, which
    unfolds.

    Args:
        wanted: κd of the trailer [1/m].
        hitch_angle: ψ [rad].
        geometry: Geometry with a hitch behind the axle.

    Returns:
        F [1/m], not limited to what the steering can do.
    """
    angle = hitch_angle + np.arctan(wanted * geometry.tongue_length)
    return -np.tan(np.clip(angle, -NEARLY_RIGHT, NEARLY_RIGHT)) / geometry.hitch_offset


def hitch_law(wanted_angle, hitch_angle, decay_length, geometry):
    """Returns the truck's curvature that makes the hitch angle decay to a wanted one when backing.

    Per metre driven backwards dψ/ds = sin ψ / L2 + (L1/L2 cos ψ + 1) F; the law makes that
    -(ψ - ψd) / decay_length. It works for on-axle hitches, too.

    Args:
        wanted_angle: ψd [rad].
        hitch_angle: ψ [rad].
        decay_length: Distance in which the difference falls to 1/e [m].
        geometry: Geometry.

    Returns:
        F [1/m], not limited to what the steering can do.
    """
    wanted_rate = -(hitch_angle - wanted_angle) / decay_length
    ratio = geometry.hitch_offset / geometry.tongue_length
    return (wanted_rate - np.sin(hitch_angle) / geometry.tongue_length) / (
        ratio * np.cos(hitch_angle) + 1.0
    )


def backing_law(wanted, hitch_angle, decay_length, geometry):
    """Returns the truck's curvature for a wanted trailer curvature, whatever the hitch.

    Off-axle the curvature is set directly. On-axle, or nearly, it follows the hitch angle, which is
    controlled instead: ψd = -atan(κd L2), a cascade.

    Args:
        wanted: κd of the trailer [1/m].
        hitch_angle: ψ [rad].
        decay_length: For the cascade [m].
        geometry: Geometry.
    """
    if geometry.near_axle:
        return hold_law(wanted, hitch_angle, decay_length, geometry)
    return curvature_law(wanted, hitch_angle, geometry)


def hold_law(wanted, hitch_angle, decay_length, geometry):
    """Returns the truck's curvature that lets the trailer settle on a circle, backwards.

    Asymptotic curvature stabilisation after Werling et al. 2014 (doi 10.1109/TITS.2013.2285602):
    the hitch angle of the steady circle is approached along arc length, and the trailer's
    curvature with it.

    Args:
        wanted: κd of the trailer [1/m].
        hitch_angle: ψ [rad].
        decay_length: Distance in which the hitch angle's error falls to 1/e [m].
        geometry: Geometry.
    """
    _, wanted_angle = steady_trailer(wanted, geometry)
    return hitch_law(wanted_angle, hitch_angle, decay_length, geometry)

"""Where a truck's rear axle, its hitch and the trailer's axle are, one by the others.

Every function takes numbers or arrays of one shape. Symbols: C rear axle's center, H hitch (L1
behind C), Q trailer axle's center (L2 behind H); θ1, θ2 headings of truck and trailer, ψ = θ2 - θ1
hitch angle, F the truck's curvature, v the speed of C, negative when backing. The derivation is in
docs/trailer.md.
"""

import numpy as np


def hitch_position(x, y, truck_heading, geometry):
    """Returns the hitch's position (x, y) in the frame of the rear axle's position [m]."""
    return (
        x - geometry.hitch_offset * np.cos(truck_heading),
        y - geometry.hitch_offset * np.sin(truck_heading),
    )


def trailer_axle(x, y, truck_heading, hitch_angle, geometry):
    """Returns the trailer axle's pose from the truck's.

    Args:
        x, y, truck_heading: Rear axle's center and θ1 [m], [rad].
        hitch_angle: ψ [rad].

    Returns:
        (x, y, θ2) of Q [m, m, rad], in the same frame.
    """
    hitch_x, hitch_y = hitch_position(x, y, truck_heading, geometry)
    heading = truck_heading + hitch_angle
    return (
        hitch_x - geometry.tongue_length * np.cos(heading),
        hitch_y - geometry.tongue_length * np.sin(heading),
        heading,
    )


def rear_axle(x, y, trailer_heading, hitch_angle, geometry):
    """Returns the truck's pose from the trailer's, the inverse of trailer_axle.

    Returns:
        (x, y, θ1) of C [m, m, rad].
    """
    heading = trailer_heading - hitch_angle
    return (
        x
        + geometry.tongue_length * np.cos(trailer_heading)
        + geometry.hitch_offset * np.cos(heading),
        y
        + geometry.tongue_length * np.sin(trailer_heading)
        + geometry.hitch_offset * np.sin(heading),
        heading,
    )

"""Places on the earth and its magnetic field, seen from a flat world."""

import math

import numpy as np

EQUATORIAL_RADIUS = 6378137.0  # [m], WGS 84
FLATTENING = 1.0 / 298.257223563  # WGS 84


def radii(latitude):
    """Metres per radian of latitude and of longitude, on the ellipsoid.

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


def to_north_west(heading, x, y):
    """Components to the north and to the west of a horizontal vector of the world.

    Args:
        heading: of the world's x axis [rad], clockwise from north.
    """
    c, s = math.cos(heading), math.sin(heading)
    return c * x + s * y, -s * x + c * y


def fix(position, latitude, longitude, altitude, heading):
    """Geodetic place of a point of the world, whose origin is given.

    Args:
        position: (3,) [m] in the world.
        latitude, longitude: of the world's origin [degrees].
        altitude: of the world's origin [m].
        heading: of the world's x axis [rad], clockwise from north.

    Returns:
        latitude, longitude [degrees], altitude [m].
    """
    north, west = to_north_west(heading, position[0], position[1])
    per_latitude, per_longitude = radii(latitude)
    return (
        latitude + math.degrees(north / per_latitude),
        longitude - math.degrees(west / per_longitude),
        altitude + position[2],
    )


def field(magnitude, heading, declination, inclination):
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

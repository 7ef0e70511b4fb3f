"""Latitude and longitude as positions on a plane: the UTM grid, or east and north of a point.

Ellipsoid: WGS 84. A plane has `forward` and `back`, and the convergence: the angle from true east
to the grid's east, clockwise [rad].
"""

import math
import re

import utm

SEMI_MAJOR = 6378137.0  # [m]
FLATTENING = 1.0 / 298.257223563
ECCENTRICITY_2 = FLATTENING * (2.0 - FLATTENING)
SMALL = 1e-6  # step north that shows where north is on the grid [deg]


class UtmGrid:
    """One zone of the Universal Transverse Mercator grid.

    Args:
        zone: 1..60.
        north: Whether it counts from the equator up; in the south it counts from 10,000 km below.
    """

    name = "utm"

    def __init__(self, zone, north):
        self.zone, self.north = zone, north

    @classmethod
    def at(cls, latitude, longitude):
        """The zone of a place.

        Raises:
            ValueError: UTM does not reach it.
        """
        _, _, zone, _ = utm.from_latlon(latitude, longitude)
        return cls(zone, latitude >= 0.0)

    @classmethod
    def named(cls, text):
        """The zone that a name such as 31U means; letters from N on are north.

        Raises:
            ValueError: It is no such name.
        """
        found = re.fullmatch(r"\s*(\d{1,2})\s*([C-HJ-NP-Xc-hj-np-x]).*", text)
        if found is None or not 1 <= int(found[1]) <= 60:
            raise ValueError(f"UTM zone is '{text}', must be 1 to 60 and a letter, such as 31U")
        return cls(int(found[1]), found[2].upper() >= "N")

    def forward(self, latitude, longitude, altitude=0.0):
        """(east [m], north [m], altitude [m]) of a place.

        Raises:
            ValueError: UTM does not reach it.
        """
        east, north, _, _ = utm.from_latlon(
            latitude, longitude, force_zone_number=self.zone, force_northern=self.north
        )
        return float(east), float(north), altitude

    def back(self, east, north, altitude=0.0):
        """(latitude [deg], longitude [deg], altitude [m]) of a position.

        Raises:
            ValueError: It is not on the grid.
        """
        latitude, longitude = utm.to_latlon(
            east, north, self.zone, northern=self.north, strict=False
        )
        return float(latitude), float(longitude), altitude

    def convergence(self, latitude, longitude):
        """Angle from true east to the grid's east, clockwise [rad]."""
        low, high = max(latitude - SMALL, -80.0), min(latitude + SMALL, 84.0)
        x0, y0, _ = self.forward(low, longitude)
        x1, y1, _ = self.forward(high, longitude)
        return math.atan2(x0 - x1, y1 - y0)


class LocalPlane:
    """East and north of a point, in the plane that touches the ellipsoid there.

    Args:
        latitude: Of the point [deg].
        longitude: [deg].
    """

    name = "local_enu"

    def __init__(self, latitude, longitude):
        phi, lam = math.radians(latitude), math.radians(longitude)
        sp, cp, sl, cl = math.sin(phi), math.cos(phi), math.sin(lam), math.cos(lam)
        self._axes = (
            (-sl, cl, 0.0),
            (-sp * cl, -sp * sl, cp),
            (cp * cl, cp * sl, sp),
        )
        self._origin = _to_earth(phi, lam, 0.0)

    def forward(self, latitude, longitude, altitude=0.0):
        """(east [m], north [m], altitude [m]) of a place; as on the UTM grid, the last is kept."""
        place = _to_earth(math.radians(latitude), math.radians(longitude), altitude)
        way = [a - b for a, b in zip(place, self._origin)]
        east, north, _ = (sum(a * b for a, b in zip(axis, way)) for axis in self._axes)
        return east, north, altitude

    def back(self, east, north, altitude=0.0):
        """(latitude [deg], longitude [deg], altitude [m]) of a position."""
        above = 0.0  # the plane; the ellipsoid falls away below it
        for _ in range(4):
            x, y, z = (
                start
                + sum(axis[place] * way for axis, way in zip(self._axes, (east, north, above)))
                for place, start in enumerate(self._origin)
            )
            phi, lam, height = _from_earth(x, y, z)
            above += altitude - height
        return math.degrees(phi), math.degrees(lam), altitude

    def convergence(self, latitude, longitude):
        """No angle: its north is true north at the point."""
        return 0.0


def _to_earth(phi, lam, height):
    """Earth-centred (x, y, z) [m] of latitude and longitude [rad] and height [m]."""
    normal = SEMI_MAJOR / math.sqrt(1.0 - ECCENTRICITY_2 * math.sin(phi) ** 2)
    out = (normal + height) * math.cos(phi)
    up = (normal * (1.0 - ECCENTRICITY_2) + height) * math.sin(phi)
    return out * math.cos(lam), out * math.sin(lam), up


def _from_earth(x, y, z):
    """Latitude, longitude [rad] and height [m]; fixed-point iteration, to micrometres."""
    out = math.hypot(x, y)
    phi = math.atan2(z, out * (1.0 - ECCENTRICITY_2))
    for _ in range(10):
        normal = SEMI_MAJOR / math.sqrt(1.0 - ECCENTRICITY_2 * math.sin(phi) ** 2)
        phi = math.atan2(z + ECCENTRICITY_2 * normal * math.sin(phi), out)
    normal = SEMI_MAJOR / math.sqrt(1.0 - ECCENTRICITY_2 * math.sin(phi) ** 2)
    # Of two ways to the height, this one holds at the poles and at the equator.
    height = out * math.cos(phi) + z * math.sin(phi) - SEMI_MAJOR**2 / normal
    return phi, math.atan2(y, x), height

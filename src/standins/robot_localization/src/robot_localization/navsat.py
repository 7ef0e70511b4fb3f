"""GPS positions in the map: geodesy, alignment of frames, messages.

Latitude and longitude as positions on a plane: the UTM grid, or east and north of a point.
Ellipsoid: WGS 84. A plane has `forward` and `back`, and the convergence: the angle from true east
to the grid's east, clockwise [rad].
"""

import math
import re

import numpy as np
import utm
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry
from sensor_msgs.msg import NavSatFix, NavSatStatus

from robot_localization.frames import Transform, angles, matrix

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
        """The zone of a position.

        Raises:
            ValueError: UTM does not cover it.
        """
        _, _, zone, _ = utm.from_latlon(latitude, longitude)
        return cls(zone, latitude >= 0.0)

    @classmethod
    def named(cls, text):
        """The zone of a name such as 31U; letters from N on are north.

        Raises:
            ValueError: It is not such a name.
        """
        match = re.fullmatch(r"\s*(\d{1,2})\s*([C-HJ-NP-Xc-hj-np-x]).*", text)
        if match is None or not 1 <= int(match[1]) <= 60:
            raise ValueError(f"UTM zone is '{text}', must be 1 to 60 and a letter, such as 31U")
        return cls(int(match[1]), match[2].upper() >= "N")

    def forward(self, latitude, longitude, altitude=0.0):
        """(east [m], north [m], altitude [m]) of a position on the earth.

        Raises:
            ValueError: UTM does not cover it.
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
        """(east [m], north [m], altitude [m]) of a position; the altitude is kept, as in UTM."""
        position = _to_earth(math.radians(latitude), math.radians(longitude), altitude)
        displacement = [a - b for a, b in zip(position, self._origin)]
        east, north, _ = (sum(a * b for a, b in zip(axis, displacement)) for axis in self._axes)
        return east, north, altitude

    def back(self, east, north, altitude=0.0):
        """(latitude [deg], longitude [deg], altitude [m]) of a position."""
        above = 0.0  # the plane; the ellipsoid falls away below it
        for _ in range(4):
            x, y, z = (
                start
                + sum(
                    axis[index] * displacement
                    for axis, displacement in zip(self._axes, (east, north, above))
                )
                for index, start in enumerate(self._origin)
            )
            phi, lam, height = _from_earth(x, y, z)
            above += altitude - height
        return math.degrees(phi), math.degrees(lam), altitude

    def convergence(self, latitude, longitude):
        """No angle: its north is true north at the point."""
        return 0.0


def _to_earth(phi, lam, height):
    """Earth-centered (x, y, z) [m] of latitude and longitude [rad] and height [m]."""
    normal = SEMI_MAJOR / math.sqrt(1.0 - ECCENTRICITY_2 * math.sin(phi) ** 2)
    out = (normal + height) * math.cos(phi)
    up = (normal * (1.0 - ECCENTRICITY_2) + height) * math.sin(phi)
    return out * math.cos(lam), out * math.sin(lam), up


def _from_earth(x, y, z):
    """Latitude, longitude [rad] and height [m]; fixed-point iteration, to micrometers."""
    out = math.hypot(x, y)
    phi = math.atan2(z, out * (1.0 - ECCENTRICITY_2))
    for _ in range(10):
        normal = SEMI_MAJOR / math.sqrt(1.0 - ECCENTRICITY_2 * math.sin(phi) ** 2)
        phi = math.atan2(z + ECCENTRICITY_2 * normal * math.sin(phi), out)
    normal = SEMI_MAJOR / math.sqrt(1.0 - ECCENTRICITY_2 * math.sin(phi) ** 2)
    # Of two formulas of the height, this one is valid at the poles and at the equator.
    height = out * math.cos(phi) + z * math.sin(phi) - SEMI_MAJOR**2 / normal
    return phi, math.atan2(y, x), height


class NotAligned(RuntimeError):
    """There is no transform between grid and world yet."""


class Alignment:
    """Collects fix, attitude and pose, and converts positions on the earth to the world.

    Args:
        declination: Of magnetic north, where the heading is of a compass [rad].
        yaw_offset: Negative of the heading's value when facing east [rad].
        local: Whether to use east and north of the first fix instead of UTM.
        flat: Whether altitudes of the world are 0.

    Attributes:
        grid: UtmGrid or LocalPlane, or None before the first fix.
        grid_in_world: Transform, or None before it is aligned.
        manual: Whether a datum was set explicitly.
    """

    def __init__(self, declination=0.0, yaw_offset=0.0, local=False, flat=False):
        self._yaw_offset, self._local, self._flat = declination + yaw_offset, local, flat
        self._zone, self.grid, self.manual = None, None, False
        self._fix = self._attitude = self._pose = None
        self._convergence = 0.0
        self.grid_in_world = None

    def set_fix(self, latitude, longitude, altitude):
        """Sets the robot's position [deg, deg, m]; ignored once it is aligned.

        Raises:
            ValueError: UTM does not cover it.
        """
        if self.grid_in_world is None and not self.manual:
            self._set_fix(latitude, longitude, altitude)

    def _set_fix(self, latitude, longitude, altitude):
        if self._local:
            grid = LocalPlane(latitude, longitude)
        else:
            grid = self._zone or UtmGrid.at(latitude, longitude)
        self._fix = np.array(grid.forward(latitude, longitude, altitude))
        self._convergence, self.grid = grid.convergence(latitude, longitude), grid

    def set_attitude(self, rotation):
        """Sets the robot's (3, 3) attitude, in east, north, up."""
        self._attitude = rotation

    def set_pose(self, pose):
        """Sets the robot's pose in its world; ignored once it is aligned."""
        if self.grid_in_world is None and not self.manual:
            self._pose = pose

    def set_datum(self, latitude, longitude, altitude, rotation):
        """Sets the world's origin and attitude explicitly.

        Raises:
            ValueError: UTM does not cover it.
        """
        self._set_fix(latitude, longitude, altitude)
        self.manual, self.grid_in_world = True, None
        self._attitude, self._pose = rotation, Transform(np.eye(3), np.zeros(3))

    def set_zone(self, text):
        """Uses one UTM zone from now on; the next fix, heading and pose align again.

        Raises:
            ValueError: The text names no zone.
        """
        self._zone = UtmGrid.named(text)
        self.manual, self.grid_in_world = False, None
        self._fix = self._attitude = self._pose = None

    def align(self, antenna=None):
        """Computes the transform once fix, attitude and pose are set.

        Args:
            antenna: (3,) position of the receiver on the robot [m].

        Returns:
            Whether it is aligned now.
        """
        missing = self._fix is None or self._attitude is None or self._pose is None
        if self.grid_in_world is not None or missing:
            return self.grid_in_world is not None
        roll, pitch, yaw = angles(self._attitude)
        heading = yaw + self._yaw_offset + self._convergence
        position = self._fix
        if antenna is not None and not self.manual:
            position = position - matrix(roll, pitch, heading) @ antenna
        on_grid = Transform(matrix(0.0, 0.0, heading), position)
        upright = matrix(0.0, 0.0, angles(self._pose.rotation)[2])
        self.grid_in_world = Transform(upright, self._pose.translation).of(on_grid.inverse())
        return True

    def to_world(self, latitude, longitude, altitude):
        """Position (3,) [m] in the world of a position on the earth.

        Raises:
            NotAligned: There is no transform yet.
            ValueError: The grid does not cover it.
        """
        transform = self._transform()
        position = np.array(self.grid.forward(latitude, longitude, altitude))
        return self.flat(transform.rotation @ position + transform.translation)

    def to_geodetic(self, position):
        """(latitude [deg], longitude [deg], altitude [m]) of a position in the world.

        Raises:
            NotAligned: There is no transform yet.
            ValueError: It is not on the grid.
        """
        transform = self._transform().inverse()
        return self.grid.back(*(transform.rotation @ position + transform.translation))

    def flat(self, position):
        """A position with its altitude, or 0 instead."""
        return position * (1.0, 1.0, 0.0) if self._flat else position

    def _transform(self):
        if self.grid_in_world is None:
            raise NotAligned("there is no transform between grid and world yet")
        return self.grid_in_world


def fix_as_odometry(alignment, fix, world, position):
    """A fix in the world's frame.

    Args:
        fix: NavSatFix, for its stamp and covariance.
        world: name of the frame.
        position: (3,) in it [m].
    """
    message = Odometry()
    message.header.stamp, message.header.frame_id = fix.header.stamp, world
    message.pose.pose.position = Point(*position.tolist())
    message.pose.pose.orientation.w = 1.0
    rotation = alignment.grid_in_world.rotation
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = (
        rotation @ np.array(fix.position_covariance, float).reshape(3, 3) @ rotation.T
    )
    message.pose.covariance = covariance.ravel().tolist()
    return message


def odometry_as_fix(alignment, odometry, robot, pose):
    """The robot's position on the earth.

    Args:
        odometry: Odometry, for its stamp and covariance.
        robot: name of the robot's frame.
        pose: of the odometry, see to_transform.

    Raises:
        ValueError: it is beyond what the grid covers.
    """
    message = NavSatFix()
    message.header.stamp, message.header.frame_id = odometry.header.stamp, robot
    message.latitude, message.longitude, message.altitude = alignment.to_geodetic(pose.translation)
    rotation = alignment.grid_in_world.rotation.T
    covariance = np.array(odometry.pose.covariance, float).reshape(6, 6)[:3, :3]
    message.position_covariance = (rotation @ covariance @ rotation.T).ravel().tolist()
    message.position_covariance_type = NavSatFix.COVARIANCE_TYPE_KNOWN
    message.status.status = NavSatStatus.STATUS_GBAS_FIX
    return message

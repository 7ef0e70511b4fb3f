"""Where the robot's world lies on the grid, found from one fix, one heading and one pose."""

import numpy as np

from robot_localization.navsat.geodesy import LocalPlane, UtmGrid
from robot_localization.rotation import Transform, angles, matrix


class NotAligned(RuntimeError):
    """There is no transform between grid and world yet."""


class Alignment:
    """Collects what is needed and turns places into positions of the world.

    Args:
        declination: Of magnetic north, where the heading is of a compass [rad].
        yaw_offset: What the heading reads facing east, with the other sign [rad].
        local: Whether to use east and north of the first fix instead of UTM.
        flat: Whether altitudes of the world are 0.

    Attributes:
        grid: UtmGrid or LocalPlane, or None before the first fix.
        grid_in_world: Transform, or None before it is aligned.
        manual: Whether a datum was set by hand.
    """

    def __init__(self, declination=0.0, yaw_offset=0.0, local=False, flat=False):
        self._turn, self._local, self._flat = declination + yaw_offset, local, flat
        self._zone, self.grid, self.manual = None, None, False
        self._fix = self._attitude = self._pose = None
        self._convergence = 0.0
        self.grid_in_world = None

    def take_fix(self, latitude, longitude, altitude):
        """Takes the robot's place [deg, deg, m]; counts until it is aligned.

        Raises:
            ValueError: UTM does not reach it.
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

    def take_attitude(self, rotation):
        """Takes the robot's (3, 3) attitude, in east, north, up."""
        self._attitude = rotation

    def take_pose(self, pose):
        """Takes the robot's pose in its world; counts until it is aligned."""
        if self.grid_in_world is None and not self.manual:
            self._pose = pose

    def set_datum(self, latitude, longitude, altitude, rotation):
        """Puts the world's origin to a place, with an attitude; from now on by hand.

        Raises:
            ValueError: UTM does not reach it.
        """
        self._set_fix(latitude, longitude, altitude)
        self.manual, self.grid_in_world = True, None
        self._attitude, self._pose = rotation, Transform(np.eye(3), np.zeros(3))

    def set_zone(self, text):
        """Uses one UTM zone from now on; the next fix, heading and pose align anew.

        Raises:
            ValueError: The text names no zone.
        """
        self._zone = UtmGrid.named(text)
        self.manual, self.grid_in_world = False, None
        self._fix = self._attitude = self._pose = None

    def align(self, antenna=None):
        """Finds the transform, when everything was taken.

        Args:
            antenna: (3,) place of the receiver on the robot [m].

        Returns:
            Whether it is aligned now.
        """
        missing = self._fix is None or self._attitude is None or self._pose is None
        if self.grid_in_world is not None or missing:
            return self.grid_in_world is not None
        roll, pitch, yaw = angles(self._attitude)
        heading = yaw + self._turn + self._convergence
        place = self._fix
        if antenna is not None and not self.manual:
            place = place - matrix(roll, pitch, heading) @ antenna
        on_grid = Transform(matrix(0.0, 0.0, heading), place)
        upright = matrix(0.0, 0.0, angles(self._pose.rotation)[2])
        self.grid_in_world = Transform(upright, self._pose.translation).of(on_grid.inverse())
        return True

    def to_world(self, latitude, longitude, altitude):
        """Position (3,) [m] in the world of a place.

        Raises:
            NotAligned: There is no transform yet.
            ValueError: The grid does not reach it.
        """
        transform = self._transform()
        position = np.array(self.grid.forward(latitude, longitude, altitude))
        return self.flat(transform.rotation @ position + transform.translation)

    def to_place(self, position):
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

"""Control laws: goal in the truck's frame -> speed and turning rate. No ROS."""

import math

FINE, COARSE = "fine", "coarse"
ORIGINAL_LINEAR = {COARSE: 0.8, FINE: 0.3}
ORIGINAL_ANGULAR = {COARSE: 2.4, FINE: 1.0}
ORIGINAL_TIME = 2.5  # expected time by which the original divides its gains [s]
ORIGINAL_BOX = 0.5  # reached when both coordinates are within this [m]
ORIGINAL_COARSE = 6.0  # coarse gains beyond this many boxes
BEHIND = math.radians(165.0)  # a goal further off the heading is behind: keep the side of the turn
AWAY_SPEED = 0.4  # greatest speed while driving away from a goal inside the turning circle [m/s]


def circle_distance(forward, left, radius, side):
    """Returns the distance of a point from the centre of a turning circle [m].

    Args:
        forward: Coordinate along the heading, from the rear axle's centre [m].
        left: Coordinate to the left [m].
        radius: Of the circle [m].
        side: 1: the circle to the left; -1: to the right.
    """
    return math.hypot(forward, left - side * radius)


class ShortestLaw:
    """Follows the shortest forward path to a point, by feedback alone.

    The shortest path of a car that drives forward to a point is one turn and a straight line; a
    point inside the turning circle is reached by turning away until it lies on the circle, then
    turning in (Bui et al., "Shortest path synthesis for Dubins non-holonomic robot", 1994). Which
    of the three applies depends only on the present position of the point, so the law needs no
    stored path and recovers from any disturbance.
    """

    def __init__(self, settings):
        """Starts at rest.

        Args:
            settings: GoalSettings.
        """
        self._settings = settings
        self.reset()

    def reset(self):
        """Resets everything: the truck is at rest."""
        self.restart()
        self._speed = 0.0

    def restart(self):
        """Resets the manoeuvre but not the speed, for a new goal."""
        self._away = 0  # side of the goal while the truck drives away from it, or 0
        self._side = 0  # side of a turn towards a goal behind
        self._fresh = True

    def reached(self, forward, left, _error):
        """Returns whether the truck has arrived: about half the tolerance, or nearest within it.

        Args:
            forward: Goal along the heading [m].
            left: Goal to the left [m].
        """
        distance = math.hypot(forward, left)
        near = 0.8 * self._settings.tolerance  # it still rolls a little
        return distance <= 0.6 * near or (distance <= near and forward <= 0.0)

    def command(self, forward, left, period):
        """Returns the next command.

        Args:
            forward: Goal along the heading [m].
            left: Goal to the left [m].
            period: Time since the last command [s].

        Returns:
            (linear.x [m/s], angular.z [rad/s]).
        """
        settings = self._settings
        distance = math.hypot(forward, left)
        curvature = self._curvature(forward, left, distance)
        speed = max(settings.creep, math.sqrt(2.0 * settings.deceleration * distance))
        speed = min(speed, settings.max_linear, settings.max_angular / max(abs(curvature), 1e-9))
        if self._away:
            speed = min(speed, AWAY_SPEED)
        rise = max(self._speed, 0.0) + settings.acceleration * period
        self._speed = min(speed, max(rise, min(settings.creep, speed)))
        return self._speed, self._speed * curvature

    def _curvature(self, forward, left, distance):
        """Returns the curvature to drive now [1/m]."""
        settings = self._settings
        side = 1 if left >= 0.0 else -1
        planned, least = settings.radius, settings.least_radius
        if self._away:
            # between the two radii: the path grows while the wheels turn over
            radius = 0.5 * (planned + least)
            if circle_distance(forward, left, radius, self._away) >= radius:
                self._away = 0
        elif circle_distance(forward, left, planned if self._fresh else least, side) < (
            0.98 * planned if self._fresh else 0.98 * least
        ):
            self._away = side
        self._fresh = False
        if self._away:
            self._side = 0
            return -self._away / planned
        error = math.atan2(left, forward)
        if abs(error) > BEHIND:
            self._side = self._side or side
            return self._side / planned
        self._side = 0
        arc = abs(2.0 * left) / (distance * distance)  # of the circle to the goal, tangent here
        gain = min(settings.turn_gain, settings.turn_rate / max(self._speed, 0.1))
        wanted = min(max(gain * abs(error), arc), max(1.0 / planned, min(arc, 1.0 / least)))
        return math.copysign(wanted, error)


class OriginalLaw:
    """The original's proportional control: speed from distance, turning from heading error."""

    def __init__(self, settings):
        """Stores the limits.

        Args:
            settings: GoalSettings; only its limits are used.
        """
        self._settings = settings

    def reset(self):
        """Does nothing: the law has no state."""

    restart = reset

    def reached(self, _forward, _left, error):
        """Returns whether the truck is in the original's box.

        Args:
            error: Goal minus position in the odometry's frame, (x, y) [m].
        """
        return max(abs(error[0]), abs(error[1])) <= ORIGINAL_BOX

    def command(self, forward, left, _period):
        """Returns the next command.

        Args:
            forward: Goal along the heading [m].
            left: Goal to the left [m].

        Returns:
            (linear.x [m/s], angular.z [rad/s]).
        """
        settings = self._settings
        distance = math.hypot(forward, left)
        kind = COARSE if distance > ORIGINAL_COARSE * ORIGINAL_BOX else FINE
        linear = min(ORIGINAL_LINEAR[kind] / ORIGINAL_TIME * distance, settings.max_linear)
        angular = ORIGINAL_ANGULAR[kind] / ORIGINAL_TIME * math.atan2(left, forward)
        most = min(settings.max_angular, linear / settings.least_radius)
        return linear, min(max(angular, -most), most)


LAWS = {"default": ShortestLaw, "original": OriginalLaw}

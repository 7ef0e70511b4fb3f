"""Go to goal: the control laws, the shortest path, the controller."""

import math
from collections import deque

FINE, COARSE = "fine", "coarse"
ORIGINAL_LINEAR = {COARSE: 0.8, FINE: 0.3}
ORIGINAL_ANGULAR = {COARSE: 2.4, FINE: 1.0}
ORIGINAL_TIME = 2.5  # expected time by which the original divides its gains [s]
ORIGINAL_BOX = 0.5  # reached when both coordinates are within this [m]
ORIGINAL_COARSE = 6.0  # coarse gains beyond this many boxes
BEHIND = math.radians(
    165.0
)  # a goal further off the heading is behind: do not change the side of the turn
AWAY_SPEED = 0.4  # maximum speed while driving away from a goal inside the turning circle [m/s]


def circle_distance(forward, left, radius, side):
    """Returns the distance of a point from the center of a turning circle [m].

    Args:
        forward, left: Of the point along the heading, from the rear axle's center [m].
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
        """Returns whether the truck has arrived.

        It has within about half the tolerance, or at the minimum distance within the tolerance.

        Args:
            forward, left: Goal along the heading [m].
        """
        distance = math.hypot(forward, left)
        tolerance = 0.8 * self._settings.tolerance  # it still rolls a little
        return distance <= 0.6 * tolerance or (distance <= tolerance and forward <= 0.0)

    def command(self, forward, left, period):
        """Returns the next command.

        Args:
            forward, left: Goal along the heading [m].
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
        planned, min_radius = settings.radius, settings.min_turning_radius
        if self._away:
            # between the two radii: the path grows while the steering reverses
            radius = 0.5 * (planned + min_radius)
            if circle_distance(forward, left, radius, self._away) >= radius:
                self._away = 0
        elif circle_distance(forward, left, planned if self._fresh else min_radius, side) < (
            0.98 * planned if self._fresh else 0.98 * min_radius
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
        magnitude = min(max(gain * abs(error), arc), max(1.0 / planned, min(arc, 1.0 / min_radius)))
        return math.copysign(magnitude, error)


class OriginalLaw:
    """The original's proportional control: speed from distance, yaw rate from heading error."""

    def __init__(self, settings):
        # only its limits are used
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
        """Returns the next command, as ShortestLaw."""
        settings = self._settings
        distance = math.hypot(forward, left)
        gains = COARSE if distance > ORIGINAL_COARSE * ORIGINAL_BOX else FINE
        linear = min(ORIGINAL_LINEAR[gains] / ORIGINAL_TIME * distance, settings.max_linear)
        angular = ORIGINAL_ANGULAR[gains] / ORIGINAL_TIME * math.atan2(left, forward)
        limit = min(settings.max_angular, linear / settings.min_turning_radius)
        return linear, min(max(angular, -limit), limit)


LAWS = {"default": ShortestLaw, "original": OriginalLaw}


def shortest_length(forward, left, radius):
    """Returns the length [m] of the shortest forward path with bounded curvature to a point.

    One turn and a straight line to a point outside the turning circles, two opposite turns to one
    inside (Bui et al. 1994); the end heading is free.

    Args:
        forward, left: The point along the heading at the start [m].
        radius: Minimum turning radius [m].
    """
    left = abs(left)  # the mirror image is as long
    outside = circle_distance(forward, left, radius, 1) >= radius
    return turn_and_line(forward, left, radius) if outside else turn_and_turn(forward, left, radius)


def turn_and_line(forward, left, radius):
    """Returns the length [m] of a turn to the left and its tangent to a point outside."""
    distance = circle_distance(forward, left, radius, 1)
    line = math.sqrt(max(distance * distance - radius * radius, 0.0))
    # the angle of the point as seen from the center, less the one between point and tangent point
    seen = math.atan2(left - radius, forward) + math.pi / 2.0
    turn = (seen - math.atan2(line, radius)) % (2.0 * math.pi)
    if 2.0 * math.pi - turn < 1e-9:  # straight ahead
        turn = 0.0
    return radius * turn + line


def turn_and_turn(forward, left, radius):
    """Returns the length of a turn to the right and one to the left, to a point inside the left
    circle [m]."""
    # Turned right by a, the left circle's center is c + 2 r (sin a, cos a) with c = (0, -r). The
    # point lies on that circle: with (dx, dy) = point - c, 4 r² + d² - 4 r (dx sin a + dy cos a) =
    # r².
    dx, dy = forward, left + radius
    square = dx * dx + dy * dy
    phase = math.atan2(dx, dy)
    swing = math.acos(
        min((3.0 * radius * radius + square) / (4.0 * radius * math.sqrt(square)), 1.0)
    )
    lengths = []
    for away in (phase - swing, phase + swing):
        away %= 2.0 * math.pi
        center = (2.0 * radius * math.sin(away), 2.0 * radius * math.cos(away) - radius)
        to_point = math.atan2(left - center[1], forward - center[0])
        to_start = math.atan2(math.cos(away), math.sin(away)) + math.pi
        lengths.append(radius * (away + (to_point - to_start) % (2.0 * math.pi)))
    return min(lengths)


ACTIVE, REACHED, STUCK, RESET = "active", "reached", "stuck", "reset"
LONGEST_STEP = 0.1  # longest period of the control law [s]


class GoalController:
    """One goal at a time; a new one replaces it."""

    def __init__(self, settings):
        self._settings = settings
        self._law = LAWS[settings.gains](settings)
        self.goal = None  # (x, y) in the odometry's frame [m]
        self.driven = 0.0  # path since the goal was set [m]
        self.shortest = None  # shortest path when the goal was set [m]
        self.distance = None  # to the goal at the last update [m]
        self._time = None  # stamp of the last update, with or without a goal [s]

    def refusal(self, position, pose):
        """Returns why a goal is refused.

        Args:
            position: (x, y, z) of the goal [m].
            pose: (x, y, heading) of the truck, or None when nothing is known.

        Returns:
            The reason, or "" for a valid goal.
        """
        for name, value in zip("xyz", position):
            if not math.isfinite(value):
                return f"{name} of the goal is {value}; it must be a finite number"
        if pose is None:
            return "there is no odometry yet"
        distance = math.hypot(position[0] - pose[0], position[1] - pose[1])
        limit = self._settings.max_distance
        if distance > limit:
            return f"the goal is {distance:.1f} m away; it must be within {limit:g} m"
        if abs(position[2]) > self._settings.tolerance:
            return (
                f"z of the goal is {position[2]:g} m; the truck drives on the ground, it must "
                f"be within {self._settings.tolerance:g} m of 0"
            )
        return ""

    def start(self, x, y):
        """Sets a new goal in the odometry's frame [m], which replaces a running one."""
        self.goal = (x, y)
        self.driven, self.shortest, self.distance = 0.0, None, None
        self._last = None  # (x, y, time)
        self._trace = deque()  # (time, x, y) of the last stuck_time
        self._law.restart()

    def stop(self):
        """Cancels the goal; the next one starts from standstill."""
        self.goal = None
        self._law.reset()

    def update(self, x, y, heading, time):
        """Updates with a pose and returns the next command.

        Args:
            x, y: Rear axle's center in the odometry's frame [m].
            heading: [rad], left positive.
            time: Stamp of the pose [s].

        Returns:
            (state, linear.x [m/s], angular.z [rad/s]) with state ACTIVE, REACHED, STUCK or RESET
            (time went back), or None without a goal. The others are returned once, with zeros;
            then there is no goal.
        """
        time_went_back = self._time is not None and time < self._time
        self._time = time
        if self.goal is None:
            return None
        if time_went_back:
            return self._finish(RESET)
        period = 0.0
        if self._last is not None:
            period = min(time - self._last[2], LONGEST_STEP)
            self.driven += math.hypot(x - self._last[0], y - self._last[1])
        self._last = (x, y, time)
        error = (self.goal[0] - x, self.goal[1] - y)
        forward = error[0] * math.cos(heading) + error[1] * math.sin(heading)
        left = error[1] * math.cos(heading) - error[0] * math.sin(heading)
        self.distance = math.hypot(*error)
        if self.shortest is None:
            self.shortest = shortest_length(forward, left, self._settings.radius)
        if self._law.reached(forward, left, error):
            return self._finish(REACHED)
        if self._stuck(x, y, time):
            return self._finish(STUCK)
        return (ACTIVE, *self._law.command(forward, left, period))

    def _finish(self, state):
        self.stop()
        return state, 0.0, 0.0

    def _stuck(self, x, y, time):
        """Returns whether the truck has not moved for too long."""
        trace, settings = self._trace, self._settings
        trace.append((time, x, y))
        while time - trace[0][0] > settings.stuck_time:
            old = trace.popleft()
            if math.hypot(x - old[1], y - old[2]) < settings.stuck_distance and all(
                math.hypot(x - item[1], y - item[2]) < settings.stuck_distance for item in trace
            ):
                return True
        return False

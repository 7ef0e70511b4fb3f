"""Life cycle of a goal around a control law. No ROS."""

import math
from collections import deque

from cybertruck.goal.laws import LAWS
from cybertruck.goal.shortest import shortest_length

ACTIVE, REACHED, STUCK, RESET = "active", "reached", "stuck", "reset"
LONGEST_STEP = 0.1  # longest period of the control law [s]


class GoalController:
    """One goal at a time; a new one replaces it."""

    def __init__(self, settings):
        """Starts without a goal.

        Args:
            settings: GoalSettings.
        """
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
            The reason, or "" for a good goal.
        """
        for name, value in zip("xyz", position):
            if not math.isfinite(value):
                return f"{name} of the goal is {value}; it must be a finite number"
        if pose is None:
            return "there is no odometry yet"
        distance = math.hypot(position[0] - pose[0], position[1] - pose[1])
        most = self._settings.max_distance
        if distance > most:
            return f"the goal is {distance:.1f} m away; it must be within {most:g} m"
        if abs(position[2]) > self._settings.tolerance:
            return (
                f"z of the goal is {position[2]:g} m; the truck drives on the ground, it must "
                f"be within {self._settings.tolerance:g} m of 0"
            )
        return ""

    def start(self, x, y):
        """Sets a new goal, which replaces a running one.

        Args:
            x: In the odometry's frame [m].
            y: In the odometry's frame [m].
        """
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
            x: Rear axle's centre in the odometry's frame [m].
            y: In the odometry's frame [m].
            heading: [rad], left positive.
            time: Stamp of the pose [s].

        Returns:
            (state, linear.x [m/s], angular.z [rad/s]) with state ACTIVE, REACHED, STUCK or RESET
            (time went back), or None without a goal. All but ACTIVE come once, with zeros; then
            there is no goal.
        """
        went_back = self._time is not None and time < self._time
        self._time = time
        if self.goal is None:
            return None
        if went_back:
            return self._end(RESET)
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
            return self._end(REACHED)
        if self._stuck(x, y, time):
            return self._end(STUCK)
        return (ACTIVE, *self._law.command(forward, left, period))

    def _end(self, state):
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

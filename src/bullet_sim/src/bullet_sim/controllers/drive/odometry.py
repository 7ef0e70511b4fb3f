"""Odometry of wheeled robots: integration of travelled arcs to a pose in the plane."""

import collections
import math

MIN_PERIOD = 1e-4  # [s] shorter periods give no velocity
STRAIGHT = 1e-6  # [rad] an arc that turns less counts as straight
MAX_ARC = 1e12  # [m, rad] longer arcs are ignored


class Odometry:
    """Pose in the plane and velocity, from arcs.

    Args:
        window: number of periods over which the velocity is averaged.

    Attributes:
        x, y: [m] in the frame in which it started.
        heading: [rad], left positive, not wrapped.
        linear, angular: [m/s, rad/s] in the robot's own frame.
        lateral: velocity to the left [m/s]: wheels do not slide.
    """

    lateral = 0.0

    def __init__(self, window=10):
        self._arcs = collections.deque(maxlen=max(1, window))
        self.reset()

    def reset(self, time=0.0):
        """Back to the origin, at rest."""
        self.x = self.y = self.heading = 0.0
        self.start(time)

    def start(self, time):
        """Continue from the present pose, at rest."""
        self.linear = self.angular = 0.0
        self._arcs.clear()
        self._time = time

    def move(self, distance, turn, time):
        """Add an arc.

        Args:
            distance: travelled since the last call [m], backwards negative.
            turn: change of heading [rad].
            time: now [s].

        An arc that is NaN or longer than MAX_ARC, which no wheel can travel, is ignored.
        """
        if not (abs(distance) <= MAX_ARC and abs(turn) <= MAX_ARC):
            self._time = time
            return
        start = self.heading
        self.heading += turn
        if abs(turn) < STRAIGHT:
            self.x += distance * math.cos(start + turn / 2)
            self.y += distance * math.sin(start + turn / 2)
        else:
            radius = distance / turn
            self.x += radius * (math.sin(self.heading) - math.sin(start))
            self.y -= radius * (math.cos(self.heading) - math.cos(start))
        period = time - self._time
        if period < MIN_PERIOD:
            return
        self._time = time
        self._arcs.append((distance / period, turn / period))
        self.linear = math.fsum(arc[0] for arc in self._arcs) / len(self._arcs)
        self.angular = math.fsum(arc[1] for arc in self._arcs) / len(self._arcs)

"""Pure pursuit along a path of points.

Source: R. C. Coulter, "Implementation of the Pure Pursuit Path Tracking Algorithm",
CMU-RI-TR-92-01: curvature = 2 y / d^2 for a goal at distance d, y to the left.
"""

import math

import numpy as np
from paddock_common.settings import Number

CLOSED_GAP = 0.01  # first and last point closer than this: a circuit [m]
WINDOW = 1.0  # distance around the last position that is searched [m]


def arc_curvature(x, y):
    """Returns the curvature [1/m, left positive] of the arc to a point (x ahead, y left) [m]."""
    return 2.0 * y / max(x * x + y * y, 1e-6)


class Path:
    """A path to follow, resampled evenly.

    Args:
        points: (N, 2) [m] in driving order; a circuit repeats its first point.
        step: Spacing of the samples [m].
        closed: Whether it is a circuit although its first point is not repeated.

    Raises:
        ValueError: Fewer than 3 points, a number that is not finite, or no length.
    """

    def __init__(self, points, step=0.02, closed=False):
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        if closed:
            points = np.concatenate((points, points[:1]))
        if len(points) < 3 or not np.isfinite(points).all():
            raise ValueError(f"the path has {len(points)} points, must have at least 3, all finite")
        arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
        if arc[-1] < 4 * step:
            raise ValueError(f"the path is {arc[-1]:.3f} m long, must be at least {4 * step} m")
        self.closed = bool(np.linalg.norm(points[0] - points[-1]) < CLOSED_GAP)
        self.length = float(arc[-1])
        count = max(4, round(self.length / step))
        at = np.linspace(0.0, self.length, count + 1)
        samples = np.stack([np.interp(at, arc, column) for column in points.T], axis=1)
        self.points = samples[:-1] if self.closed else samples
        self.step = self.length / count
        ahead = np.roll(self.points, -1, axis=0) - np.roll(self.points, 1, axis=0)
        if not self.closed:
            ahead = np.gradient(self.points, axis=0)
        self.headings = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))

    def nearest(self, x, y, near=None):
        """Returns the index of the nearest sample; near: only around that index, if given."""
        if near is None:
            pick = np.arange(len(self.points))
        else:
            count = int(WINDOW / self.step)
            pick = np.arange(near - count, near + count + 1)
            pick = (
                pick % len(self.points) if self.closed else np.clip(pick, 0, len(self.points) - 1)
            )
        return int(pick[np.argmin(np.hypot(self.points[pick, 0] - x, self.points[pick, 1] - y))])

    def distance(self, x, y):
        """Returns the distance to the nearest sample [m]."""
        return math.dist(self.points[self.nearest(x, y)], (x, y))

    def arc_length(self, start, end):
        """Returns the arc length from one index to another [m]; on a circuit always forwards."""
        count = end - start
        return (count % len(self.points) if self.closed else count) * self.step

    def at(self, index):
        """Returns the sample of an index, which may be beyond the end."""
        count = len(self.points)
        return self.points[index % count if self.closed else min(index, count - 1)]

    def remaining_length(self, index):
        """Returns the distance to the end of an open path [m]; infinite on a circuit."""
        return math.inf if self.closed else (len(self.points) - 1 - index) * self.step

    def curvature_ahead(self, index, length):
        """Returns the maximum |curvature| [1/m] of the path over the next `length` [m]."""
        span = max(2, round(0.16 / self.step))
        steps = np.arange(index, index + max(1, round(length / self.step)) + 1)
        count = len(self.points)

        def heading(i):
            if self.closed:
                rotation = self.headings[-1] - self.headings[0]
                rotation = (
                    2.0 * math.pi * round((rotation + 1e-9) / (2.0 * math.pi))
                    if abs(rotation) > 1.0
                    else 0.0
                )
                return self.headings[i % count] + rotation * (i // count)
            return self.headings[np.clip(i, 0, count - 1)]

        return float(np.abs(heading(steps + span) - heading(steps)).max() / (span * self.step))


class Pursuit:
    """Follows a Path from poses of the rear axle.

    Args:
        lookahead: Distance along the path to the goal point [m].
        max_speed: [m/s].
        max_lateral_acceleration: Lowers the speed in bends [m/s^2].

    Raises:
        ValueError: A number is not above 0.
    """

    def __init__(self, path: Path, lookahead=0.4, max_speed=1.0, max_lateral_acceleration=2.0):
        for name, value in (
            ("lookahead", lookahead),
            ("max_speed", max_speed),
            ("max_lateral_acceleration", max_lateral_acceleration),
        ):
            Number(above=0.0).check(name, value)
        self.path, self.lookahead = path, lookahead
        self.max_speed, self.grip = max_speed, max_lateral_acceleration
        self._index = None

    def command(self, x, y, yaw):
        """Returns (speed [m/s], curvature [1/m, left positive]) for a rear-axle pose.

        Both are 0 at the end of an open path.
        """
        index = self.path.nearest(x, y, self._index)
        if math.dist(self.path.points[index], (x, y)) > 1.0:
            index = self.path.nearest(x, y)  # a service has moved it
        self._index = index
        if self.path.remaining_length(index) < 0.03:
            return 0.0, 0.0
        goal = self.path.at(index + max(1, round(self.lookahead / self.path.step)))
        dx, dy = goal[0] - x, goal[1] - y
        ahead = math.cos(yaw) * dx + math.sin(yaw) * dy
        left = -math.sin(yaw) * dx + math.cos(yaw) * dy
        bend = self.path.curvature_ahead(index, 0.3 + 0.4 * self.max_speed)
        speed = min(self.max_speed, math.sqrt(self.grip / max(bend, 1e-6)))
        return speed, arc_curvature(ahead, left)

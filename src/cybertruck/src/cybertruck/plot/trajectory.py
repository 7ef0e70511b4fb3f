"""A driven path and its goals, written as CSV. No ROS."""

import csv
import math


class Trajectory:
    """Poses in the order of their stamps, and the goals that were given meanwhile."""

    COLUMNS = ("time", "x", "y", "heading")

    def __init__(self, spacing=0.0):
        """Starts empty.

        Args:
            spacing: Poses nearer to the last stored one than this are left out, unless the heading
                changed by more than a degree [m]; 0 stores all.
        """
        self._spacing = spacing
        self.rows = []  # (time [s], x [m], y [m], heading [rad])
        self.goals = []  # (time [s], x [m], y [m])
        self._last = None

    def add(self, time, x, y, heading):
        """Adds a pose; one that is not finite, or older than the last, is left out.

        Args:
            time: Stamp [s].
            x: [m].
            y: [m].
            heading: [rad], left positive.

        Returns:
            Whether the pose was valid.
        """
        row = (time, x, y, heading)
        if not all(map(math.isfinite, row)) or (self._last and time < self._last[0]):
            return False
        self._last = row
        kept = self.rows[-1] if self.rows else None
        if (
            kept is None
            or math.hypot(x - kept[1], y - kept[2]) >= self._spacing
            or abs(math.remainder(heading - kept[3], 2.0 * math.pi)) > math.radians(1.0)
        ):
            self.rows.append(row)
        return True

    def add_goal(self, time, x, y):
        """Adds a goal; the same one again (a latched message) is left out.

        Args:
            time: Stamp [s].
            x: [m].
            y: [m].
        """
        goal = (time, x, y)
        if all(map(math.isfinite, goal)) and goal not in self.goals:
            self.goals.append(goal)

    def finish(self):
        """Stores the last pose, also within the spacing.

        Raises:
            ValueError: There is no pose at all.
        """
        if self._last is None:
            raise ValueError("no pose was recorded")
        if self.rows[-1] != self._last:
            self.rows.append(self._last)

    @property
    def length(self):
        """Length of the path [m]."""
        return sum(math.hypot(b[1] - a[1], b[2] - a[2]) for a, b in zip(self.rows, self.rows[1:]))

    @property
    def duration(self):
        """Time from the first pose to the last [s]."""
        return self.rows[-1][0] - self.rows[0][0] if self.rows else 0.0

    def write_csv(self, path):
        """Writes time [s], x [m], y [m], heading [rad], a row per pose."""
        with open(path, "w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(self.COLUMNS)
            for time, *pose in self.rows:
                writer.writerow([f"{time:.3f}", *(f"{value:.5f}" for value in pose)])

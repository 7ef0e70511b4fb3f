"""Trajectories from bags and topics, and their plots."""

import csv
import math

import numpy as np
from matplotlib.figure import Figure


class Trajectory:
    """Poses in the order of their stamps, and the goals during the recording.

    Args:
        spacing: Poses closer to the last stored one than this are skipped, unless the heading
            changed by more than a degree [m]; 0 stores all.
    """

    COLUMNS = ("time", "x", "y", "heading")

    def __init__(self, spacing=0.0):
        self._spacing = spacing
        self.rows = []  # (time [s], x [m], y [m], heading [rad])
        self.goals = []  # (time [s], x [m], y [m])
        self._last = None

    def add(self, time, x, y, heading):
        """Adds a pose; one that is not finite, or older than the last, is skipped.

        Args:
            time, x, y, heading: Stamp [s], pose [m], [rad], left positive.

        Returns:
            Whether the pose was valid.
        """
        row = (time, x, y, heading)
        if not all(map(math.isfinite, row)) or (self._last and time < self._last[0]):
            return False
        self._last = row
        stored = self.rows[-1] if self.rows else None
        if (
            stored is None
            or math.hypot(x - stored[1], y - stored[2]) >= self._spacing
            or abs(math.remainder(heading - stored[3], 2.0 * math.pi)) > math.radians(1.0)
        ):
            self.rows.append(row)
        return True

    def add_goal(self, time, x, y):
        """Adds a goal, stamp [s] and position [m]; the same one again (latched) is skipped."""
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


ARROWS = 24  # heading arrows along a path, about
INK, PATH, START, GOAL = "0.35", "#1f5fa8", "#2e8b3d", "#c0392b"


def plot(trajectory, path, title="", labels=("x in /odom [m]", "y in /odom [m]")):
    """Plots path, start, end, goals and heading arrows.

    Args:
        trajectory: Trajectory with at least one pose.
    """
    figure = Figure(figsize=(7.0, 7.0), constrained_layout=True)
    axes = figure.subplots()
    _plot_path(axes, trajectory)
    _plot_goals(axes, trajectory)
    _plot_ends(axes, trajectory)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.grid(color="0.88")
    axes.set(axisbelow=True, xlabel=labels[0], ylabel=labels[1], title=title)
    axes.legend(loc="best", framealpha=0.9)
    figure.savefig(path, dpi=110)


def _plot_path(axes, trajectory):
    _, x, y, _ = zip(*trajectory.rows)
    axes.plot(x, y, color=PATH, linewidth=1.8, label=f"path, {trajectory.length:.2f} m")
    arrows = select_spaced(trajectory.rows, max(trajectory.length / ARROWS, 1e-6))
    _, x, y, heading = zip(*arrows)
    look = {"color": INK, "scale": 30.0, "width": 0.004, "pivot": "tail", "zorder": 3}
    axes.quiver(x, y, np.cos(heading), np.sin(heading), angles="xy", **look)
    axes.plot([], [], linestyle="none", marker=(3, 0, -90), color=INK, label="heading")


def _plot_goals(axes, trajectory):
    xs = [row[1] for row in trajectory.rows]
    center = 0.5 * (min(xs) + max(xs))
    for index, (_, goal_x, goal_y) in enumerate(trajectory.goals, 1):
        axes.plot(
            goal_x,
            goal_y,
            "x",
            color=GOAL,
            markersize=11,
            markeredgewidth=2.5,
            label="goals" if index == 1 else None,
            zorder=4,
        )
        axes.annotate(
            f"goal {index} ({goal_x:g}, {goal_y:g})",
            (goal_x, goal_y),
            xytext=(-14, -4) if goal_x > center else (14, -18),
            color=GOAL,
            textcoords="offset points",
            horizontalalignment="right" if goal_x > center else "left",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
        )


def _plot_ends(axes, trajectory):
    (_, *start, _), (_, *end, _) = trajectory.rows[0], trajectory.rows[-1]
    axes.plot(*start, "o", color=START, markersize=8, label="start", zorder=5)
    axes.plot(
        *end,
        "s",
        color=PATH,
        markersize=7,
        markerfacecolor="white",
        markeredgewidth=2.0,
        label="end",
        zorder=5,
    )


def select_spaced(rows, spacing):
    """Selects poses at equal distances along the path.

    Args:
        spacing: [m].
    """
    selected, since = [rows[0]], 0.0
    for before, row in zip(rows, rows[1:]):
        since += math.hypot(row[1] - before[1], row[2] - before[2])
        if since >= spacing:
            selected.append(row)
            since = 0.0
    return selected

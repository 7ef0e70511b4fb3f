"""Plots of driven trajectories over a track."""

import matplotlib
import numpy as np
from track_model.plots import draw_ground

matplotlib.use("Agg")

from matplotlib import pyplot  # noqa: E402


def paths(laps, track, path):
    """Plot driven trajectories over the track, colored by speed."""
    figure, axes = pyplot.subplots(figsize=(9, 6.5), dpi=110)
    draw_ground(axes, track)
    trajectory = np.concatenate([lap.trajectory for lap in laps])
    points = axes.scatter(
        trajectory[:, 0], trajectory[:, 1], c=trajectory[:, 2], s=4, cmap="viridis", zorder=3
    )
    figure.colorbar(points, ax=axes, label="speed [m/s]")
    write(figure, path)


def write(figure, path):
    """Write a figure as a PNG and close it."""
    figure.tight_layout()
    figure.savefig(path)
    pyplot.close(figure)

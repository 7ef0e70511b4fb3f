"""Plots of driven trajectories over a track."""

import cv2
import matplotlib
import numpy as np

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


def draw_ground(axes, track):
    """Plot a track's image as the ground, axes in meters."""
    left, right, low, high = track.extent
    image = cv2.imread(track.texture)
    if image is not None:
        small = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        axes.imshow(small[..., ::-1], extent=(left, right, low, high), alpha=0.6)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")

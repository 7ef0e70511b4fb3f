"""Driven ways over a track, as pictures."""

import cv2
import matplotlib
import numpy as np

matplotlib.use("Agg")

from matplotlib import pyplot  # noqa: E402


def paths(laps, track, path):
    """Draw driven ways over the track, coloured by speed.

    Args:
        laps: Lap list.
        track: Track.
        path: of the PNG.
    """
    figure, axes = pyplot.subplots(figsize=(9, 6.5), dpi=110)
    draw_ground(axes, track)
    way = np.concatenate([lap.way for lap in laps])
    drawn = axes.scatter(way[:, 0], way[:, 1], c=way[:, 2], s=4, cmap="viridis", zorder=3)
    figure.colorbar(drawn, ax=axes, label="speed [m/s]")
    figure.tight_layout()
    figure.savefig(path)
    pyplot.close(figure)


def draw_ground(axes, track):
    """Draw a track's picture as the ground, axes in metres."""
    left, right, low, high = track.extent
    picture = cv2.imread(track.texture)
    if picture is not None:
        small = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        axes.imshow(small[..., ::-1], extent=(left, right, low, high), alpha=0.6)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")

"""Plots over a track; matplotlib is the caller's."""

from __future__ import annotations

from typing import Any

import cv2

from track_model.track import Track


def draw_ground(axes: Any, track: Track) -> None:
    """Plot a track's image as the ground, axes in meters."""
    left, right, low, high = track.extent
    image = cv2.imread(track.texture)
    if image is not None:
        small = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        axes.imshow(small[..., ::-1], extent=(left, right, low, high), alpha=0.6)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")

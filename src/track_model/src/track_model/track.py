"""Tracks as arrays, for drawing pictures of them and for driving along them."""
import os
from dataclasses import dataclass

import numpy as np

from track_model import cache, geometry, spec, texture
from track_model.spec import TrackError  # noqa: F401  (part of this module's interface)


@dataclass(frozen=True)
class Track:
    """A track in its start frame: origin on the start line, +x in driving direction.

    Attributes:
        name: The file's stem.
        centreline: (N, 2) evenly spaced closed curve [m], the first point is the origin.
        width: Lane, outer edge to outer edge of the borders [m].
        inner, outer: (N, 2) edges of the lane [m], inside and outside of the circuit.
        length: Of the centreline [m].
        extent: (xmin, xmax, ymin, ymax) of the texture [m].
        texture: Path of the PNG, +y up.
        directory: Folder of all the files.
        spec: The TrackSpec it was made from.
    """

    name: str
    centreline: np.ndarray
    width: float
    inner: np.ndarray
    outer: np.ndarray
    length: float
    extent: tuple
    texture: str
    directory: str
    spec: spec.TrackSpec


def load_track(name_or_path):
    """Load a track, generating its files if they are not cached.

    Args:
        name_or_path: default, easy, medium, hard, or the path of a YAML file.

    Returns:
        Track.

    Raises:
        TrackError: No such track, or its file is not valid.
    """
    path = spec.find(name_or_path)
    directory = cache.ensure(path)
    parsed = spec.parse(spec.read(path), path)
    curve = geometry.centreline(parsed)
    inner, outer = sorted((geometry.offset(curve, side * parsed.width / 2.0)
                           for side in (-1.0, 1.0)), key=geometry.closed_length)
    return Track(name=parsed.name, centreline=curve, width=parsed.width, inner=inner, outer=outer,
                 length=geometry.closed_length(curve),
                 extent=texture.whole_pixels(texture.extent(curve, parsed.width))[0],
                 texture=os.path.join(directory, 'track.png'), directory=directory, spec=parsed)

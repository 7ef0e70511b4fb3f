"""Tracks as arrays, for rendering them and for driving along them."""

from __future__ import annotations

import dataclasses
import os
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from track_model import curves, geometry, source, spec
from track_model.files import cache, writer
from track_model.spec import TrackError  # noqa: F401  (part of this module's interface)


@dataclass(frozen=True)
class Track:
    """A track in its start frame: origin on the start line, +x in driving direction.

    Attributes:
        name: The file's stem.
        centreline: (N, 2) evenly spaced curve [m], the first point is the origin.
        closed: Whether it is a circuit.
        width: Lane, outer edge to outer edge of the borders, at the widest point [m].
        lane: The centreline with the distances to both edges.
        inner, outer: (N, 2) edges of the lane [m], first the shorter one.
        length: Length of the centreline [m].
        extent: (xmin, xmax, ymin, ymax) of the texture [m].
        texture: Path of the PNG, +y up.
        directory: Folder of all the files.
        spec: The TrackSpec it was made from.
    """

    name: str
    centreline: npt.NDArray[Any]
    closed: bool
    width: float
    lane: geometry.Lane
    inner: npt.NDArray[Any]
    outer: npt.NDArray[Any]
    length: float
    extent: tuple[float, float, float, float]
    texture: str
    directory: str
    spec: spec.TrackSpec

    def sdf(self) -> str:
        """Return its SDF file, with walls if its spec has them; meshes are those of `directory`."""
        return writer.sdf_file(writer.model_sdf(self.lane, self.spec, self.directory))


def load_track(name_or_path: str, walls: bool | None = None) -> Track:
    """Load a track, generating its files if they are not cached.

    Args:
        name_or_path: default, easy, medium, hard, or the path of a YAML, .npy or .csv file.
        walls: Whether the lane has walls; None: as the file says. `directory` is the file's.

    Raises:
        TrackError: There is no such track, or its file is not valid.
    """
    path = source.find(name_or_path)
    directory = cache.ensure(path)
    parsed = source.load(path)
    if walls is not None:
        parsed = dataclasses.replace(parsed, walls=dataclasses.replace(parsed.walls, enabled=walls))
    lane = geometry.lane(parsed)
    inner, outer = sorted(
        (lane.edge(side) for side in (-1.0, 1.0)),
        key=lambda edge: curves.length(edge, lane.closed),
    )
    return Track(
        name=parsed.name,
        centreline=lane.curve,
        closed=lane.closed,
        width=parsed.width,
        lane=lane,
        inner=inner,
        outer=outer,
        length=lane.length,
        extent=writer.whole_pixels(writer.extent(lane))[0],
        texture=os.path.join(directory, "track.png"),
        directory=directory,
        spec=parsed,
    )

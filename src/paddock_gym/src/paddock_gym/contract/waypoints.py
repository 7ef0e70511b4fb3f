"""Waypoints as DeepRacer's reward functions know them."""

import bisect
import math

import numpy as np

SPACING = 0.15  # of the waypoints of tracks that are no routes of DeepRacer [m]


class Waypoints:
    """Points of the centreline.

    A route's waypoints are the points of its file, so that numbers from the console hold; any other
    track's lie some 15 cm apart. On a circuit the last repeats the first.

    Args:
        track: track_model.track.Track.
        projector: its Projector.

    Attributes:
        points: list of (x, y) [m].
        closed: whether it is a circuit.
        length: of the centreline [m].
    """

    def __init__(self, track, projector):
        self.closed, self.length = projector.closed, projector.length
        if track.spec.imported:
            points, along = _of_file(track, projector)
        else:
            count = max(4, round(projector.length / SPACING))
            along = np.arange(count + (not self.closed)) * projector.length / count
            points = [projector.pose(s)[:2] for s in along]
        self._along = [float(s) for s in along]
        self.points = [(float(x), float(y)) for x, y in points]
        if self.closed:
            self._along.append(self.length)
            self.points.append(self.points[0])

    def around(self, s):
        """Numbers [behind, ahead] of the waypoints around an arc length [m]."""
        at = s % self.length if self.closed else min(max(s, 0.0), self.length)
        ahead = min(max(bisect.bisect_right(self._along, at), 1), len(self._along) - 1)
        return [ahead - 1, ahead]


def _of_file(track, projector):
    """The file's points in the track's frame, and their arc lengths in growing order."""
    x, y, yaw = track.lane.origin
    c, s = math.cos(yaw), math.sin(yaw)
    points = (np.asarray(track.spec.points) - (x, y)) @ np.array(((c, -s), (s, c)))
    along, _ = projector.project(points)
    along[np.abs(along - projector.length) < 1e-3] = 0.0 if projector.closed else projector.length
    order = np.argsort(along, kind="stable")
    return points[order], along[order]

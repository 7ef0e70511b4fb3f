"""Boxes and other cars on the track, as a learner and a reward function see them."""

from typing import NamedTuple

import numpy as np

RACES = {"time_trial": "", "object_avoidance": "boxes", "head_to_bot": "bots"}
SEEN = 2  # objects ahead that the observation `state` tells of
FARTHEST = 4.0  # [m] along the course at which they are told of


class Placed(NamedTuple):
    """An object on the track.

    Attributes:
        x, y, yaw: pose [m], [rad].
        s: arc length of its projection [m].
        lateral: distance to the left of the centreline [m].
        speed: along the course [m/s].
    """

    x: float
    y: float
    yaw: float
    s: float
    lateral: float
    speed: float


def seen(objects, s, projector):
    """The next objects ahead.

    Args:
        objects: Placed ones.
        s: arc length of the car [m].
        projector: Projector.

    Returns:
        (2 * SEEN,) float32: distance along the course / FARTHEST (1: none), distance to the left of
        the centreline / half lane, nearest first.
    """
    row = np.tile(np.array((1.0, 0.0), dtype=np.float32), SEEN)
    ahead = sorted(((thing.s - s) % projector.length, thing.lateral) for thing in objects)
    for number, (distance, lateral) in enumerate(ahead[:SEEN]):
        if distance < FARTHEST:
            half = sum(projector.sides(s)) / 2.0
            row[2 * number : 2 * number + 2] = distance / FARTHEST, lateral / half
    return np.clip(row, -1.0, 1.0)

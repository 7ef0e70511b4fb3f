"""Kinds of joints of a description, a row each: its code in quickstep, and how it places a link.

To add one: a row here, its rows of constraints in quickstep (joints.py, constraints.py), its name
in formats/joints.py, and its chain in description/mirrors.py where mirrors have no such joint.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Tuple

import numpy as np

from bullet_sim.engine.quickstep import layout as q
from bullet_sim.pose import Array, Pose

# The frame of a link, and the velocity of its origin and its angular velocity in that of the joint,
# along the world's axes.
Placement = Tuple[Pose, Array, Array]
_STILL = np.zeros(3)


class Kind(NamedTuple):
    """A kind of joint.

    Attributes:
        code: in quickstep.
        place: function of the joint's frame in the world at position 0, its unit axis there and in
            the frame (3,), and its row, whose position and velocity it has.
        at_center: its anchor is at the link's center of mass, not at the frame's origin.
    """

    code: int
    place: Callable[[Pose, Array, Array, Array], Placement]
    at_center: bool = False


def _rotated(frame: Pose, along: Array, axis: Array, row: Array) -> Placement:
    angle = row[q.ANGLE]
    turn = (*(math.sin(0.5 * angle) * axis).tolist(), math.cos(0.5 * angle))
    return frame * Pose((0.0, 0.0, 0.0), turn), _STILL, row[q.RATE] * along


def _slid(frame: Pose, along: Array, axis: Array, row: Array) -> Placement:
    position = frame.position + row[q.ANGLE] * along
    return Pose(tuple(position), frame.orientation), row[q.RATE] * along, _STILL


def _screwed(frame: Pose, along: Array, axis: Array, row: Array) -> Placement:
    frame, _, turned = _rotated(frame, along, axis, row)
    x, y, z = np.add(frame.position, row[q.ANGLE] / row[q.PITCH] * along).tolist()
    return Pose((x, y, z), frame.orientation), row[q.RATE] / row[q.PITCH] * along, turned


KINDS = {
    "revolute": Kind(q.HINGE, _rotated),
    "continuous": Kind(q.HINGE, _rotated),
    "prismatic": Kind(q.SLIDER, _slid, at_center=True),
    "screw": Kind(q.SCREW, _screwed),
    "fixed": Kind(q.FIXED, _rotated, at_center=True),
}

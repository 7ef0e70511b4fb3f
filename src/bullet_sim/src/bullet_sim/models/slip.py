"""Sliding friction of skid-steered wheels, opposite to their slip.

Bullet solves friction along two fixed directions, each with its own effective mass, and scales both
impulses into the friction cone. Along the way a wheel rolls that mass is small, so the force of a
sliding wheel turns towards the axle: a skid-steered base turns at 0.3 to 0.7 of the rate that
Coulomb friction gives. Here the difference between Bullet's force of the last step and the one
opposite to the slip acts as an external force on the next. A wheel that does not slide gets none.
"""

import math

import numpy as np

SLOWEST = 0.01  # [m/s] of slip below which Bullet's force is left alone; full effect at twice that
_APART = 1e-3  # [m] between axles that count as two
_PARALLEL = 0.999  # cosine between axles that count as parallel


def skid_wheels(joints, links):
    """Links that are wheels of a base that must skid to turn.

    Args:
        joints: Joints of a model without fixed ones.
        links: Link by name.

    Returns:
        Names of the children of unlimited joints that share a parent, where three or more have
        parallel axles, not all on one line.
    """
    axles = {}
    for joint in joints:
        if joint.kind in ("revolute", "continuous") and joint.lower is None:
            if links[joint.child].collisions:
                axles.setdefault(joint.parent, []).append(joint)
    found = []
    for siblings in axles.values():
        for first in siblings:
            axis = _axle(first)
            parallel = [j for j in siblings if abs(axis @ _axle(j)) > _PARALLEL]
            if len(parallel) >= 3 and any(_distance(first, j, axis) > _APART for j in parallel):
                found.append(first.child)
    return found


def _axle(joint):
    axis = joint.origin.matrix @ joint.anchor.matrix @ np.asarray(joint.axis)
    return axis / np.linalg.norm(axis)


def _distance(first, second, axis):
    """Distance [m] of two parallel axles."""
    offset = np.subtract(second.origin.position, first.origin.position)
    return float(np.linalg.norm(offset - (offset @ axis) * axis))


class Slip:
    """Turns the friction of sliding wheels against their slip.

    Args:
        engine: the Engine.
    """

    def __init__(self, engine):
        self._engine = engine
        self._wheels = {}  # body -> set of link indices
        self._forces = []  # (body, link, force, point) for the next step

    def assign(self, models):
        """Find the wheels of all models."""
        self._wheels, self._forces = {}, []
        for model in models:
            names = () if model.is_static else skid_wheels(model.parts_joints, model.rigid_parts)
            if names:
                self._wheels[model.body] = {model.index(name) for name in names}

    @property
    def watching(self):
        """Whether there are such wheels."""
        return bool(self._wheels)

    @property
    def active(self):
        """Whether wheels slide, so that every step counts."""
        return bool(self._forces)

    def apply(self):
        """Apply the forces for the next step."""
        for force in self._forces:
            self._engine.apply_force(*force)

    def update(self):
        """Compute the forces from the sliding contacts of the last step."""
        self._forces = [
            (body, link, _correction(force, velocity, limit), point)
            for body, links in self._wheels.items()
            for link, point, force, velocity, limit in self._engine.slip(body, links, SLOWEST)
        ]


def _correction(force, velocity, limit):
    """Coulomb's force [N] against a slip less the force that acts."""
    speed = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2)
    share = min(1.0, speed / SLOWEST - 1.0)
    return tuple(share * (-limit * v / speed - f) for v, f in zip(velocity, force))

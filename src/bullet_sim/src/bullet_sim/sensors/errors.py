"""Errors of hector's sensors: constant offset, a drift that wanders, white noise, a scale."""

from __future__ import annotations

import math
from typing import Any

from bullet_sim.component import Stateful
from bullet_sim.plugins.inertial import ErrorModel
from bullet_sim.plugins.xml import ZERO
from bullet_sim.pose import Vec3


class SensorErrors(Stateful):
    """The drift of one measurement, and its errors.

    Attributes:
        drift: now, along the axes.
    """

    STATE = ("drift",)

    def __init__(self, spec: ErrorModel) -> None:
        self.spec = spec
        self.drift: Vec3 = ZERO

    @property
    def bias(self) -> Vec3:
        """Offset and drift."""
        x, y, z = (offset + drift for offset, drift in zip(self.spec.offset, self.drift))
        return x, y, z

    def restart(self, rng: Any) -> None:
        """Begin with a random drift."""
        self.drift = _normal(self.spec.drift, rng)

    def measured(self, values: Vec3, period: float, rng: Any) -> Vec3:
        """True values with the errors, a time [s] after the last ones.

        As hector's sensor_model, which steps the drift by the period instead of its root:
        exp(-f dt) drift + dt N(0, sqrt(2 f) drift's deviation).
        """
        spec = self.spec
        if any(self.drift) or any(spec.drift):
            deviation = [math.sqrt(2.0 * f) * d for f, d in zip(spec.frequency, spec.drift)]
            steps = _normal((deviation[0], deviation[1], deviation[2]), rng)
            x, y, z = (
                math.exp(-period * f) * now + period * step
                for f, now, step in zip(spec.frequency, self.drift, steps)
            )
            self.drift = x, y, z
        noise = _normal(spec.noise, rng)
        x, y, z = (
            value * scale + offset + drift + random
            for value, scale, offset, drift, random in zip(
                values, spec.scale, spec.offset, self.drift, noise
            )
        )
        return x, y, z


def _normal(deviations: Vec3, rng: Any) -> Vec3:
    """Random numbers with these standard deviations; none is drawn where all are zero."""
    if not any(deviations):
        return ZERO
    a, b, c = rng.standard_normal(3).tolist()
    return a * deviations[0], b * deviations[1], c * deviations[2]

"""Errors of sensors: hector's, with an offset, a drift that wanders, white noise and a scale; the
biases of Gazebo's own noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from bullet_sim.component import Stateful
from bullet_sim.pose import ZERO, Vec3

HOUR: Vec3 = (1.0 / 3600.0,) * 3  # [1/s]


@dataclass(frozen=True)
class ErrorModel:
    """Errors of one measurement of hector's sensors, along its three axes.

    Attributes:
        offset: constant.
        drift: standard deviation of the drift at the start, and of what it wanders to.
        frequency: at which a drift decays [1/s].
        noise: standard deviation of the white noise.
        scale: factor of the true value.
    """

    offset: Vec3 = ZERO
    drift: Vec3 = ZERO
    frequency: Vec3 = HOUR
    noise: Vec3 = ZERO
    scale: Vec3 = (1.0,) * 3


@dataclass(frozen=True)
class BiasModel:
    """What a <noise> of SDF has besides its mean and its deviation, along three axes.

    Attributes:
        mean, stddev: of the bias at the start, which then gets a random sign.
        wander, time: deviation of what is added to it each second, and time [s] in which it decays;
            either 0: it stays.
        precision: to a multiple of which measurements are rounded; 0: they are not.
    """

    mean: Vec3 = ZERO
    stddev: Vec3 = ZERO
    wander: Vec3 = ZERO
    time: Vec3 = ZERO
    precision: Vec3 = ZERO


class SensorErrors(Stateful):
    """The drift of one measurement, and its errors.

    Attributes:
        drift: now, along the axes.
        spec: an ErrorModel, which may be replaced.
    """

    STATE = ("drift", "spec")

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

    def measured(self, values: Vec3, period: float, times: int, rng: Any) -> Vec3:
        """True values with the errors.

        Args:
            period: of the sensor [s].
            times: how many periods ago the last measurement was; 1, unless nobody asked for some,
                which hector's sensors make all the same.
            rng: generator.

        As hector's sensor_model, which steps the drift by the period instead of its root:
        a drift + dt N(0, sqrt(2 f) drift's deviation), a = exp(-f dt); n times at once:
        a^n drift + sqrt((1 - a^2n) / (1 - a^2)) dt N(0, ...).
        """
        spec = self.spec
        if any(self.drift) or any(spec.drift):
            deviation = [
                period * math.sqrt(2.0 * f * _geometric(math.exp(-2.0 * period * f), times)) * d
                for f, d in zip(spec.frequency, spec.drift)
            ]
            steps = _normal((deviation[0], deviation[1], deviation[2]), rng)
            x, y, z = (
                math.exp(-period * f * times) * now + step
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


class Bias(Stateful):
    """Bias of one measurement of Gazebo's own sensors, along three axes.

    One that wanders is an Ornstein-Uhlenbeck process.

    Attributes:
        bias: now.
    """

    STATE = ("bias",)

    def __init__(self, spec: BiasModel) -> None:
        self.spec = spec
        self.bias: Vec3 = ZERO
        self._wanders = any(spec.wander) and any(spec.time)
        self.is_none = not (any(spec.mean) or any(spec.stddev) or self._wanders)
        self.is_none = self.is_none and not any(spec.precision)

    def restart(self, rng: Any) -> None:
        """Begin with a random bias."""
        self.bias = ZERO
        if any(self.spec.mean) or any(self.spec.stddev):
            signs = np.where(rng.random(3) < 0.5, -1.0, 1.0)
            x, y, z = (signs * rng.normal(self.spec.mean, np.abs(self.spec.stddev))).tolist()
            self.bias = x, y, z

    def measured(self, values: Vec3, period: float, rng: Any) -> Vec3:
        """Values with the bias, rounded, a time [s] after the last ones."""
        if self._wanders:
            self._wander(period, rng)
        x, y, z = (value + bias for value, bias in zip(values, self.bias))
        if any(self.spec.precision):
            x, y, z = (
                round(value / to) * to if to > 0.0 else value
                for value, to in zip((x, y, z), self.spec.precision)
            )
        return x, y, z

    def _wander(self, period: float, rng: Any) -> None:
        steps = rng.standard_normal(3).tolist()
        biases = []
        for bias, step, deviation, time in zip(self.bias, steps, self.spec.wander, self.spec.time):
            if deviation > 0.0 and time > 0.0:
                spread = deviation * math.sqrt(-0.5 * time * math.expm1(-2.0 * period / time))
                bias = math.exp(-period / time) * bias + spread * step
            biases.append(bias)
        self.bias = biases[0], biases[1], biases[2]


def _normal(deviations: Vec3, rng: Any) -> Vec3:
    """Random numbers with these standard deviations; none is drawn where all are zero."""
    if not any(deviations):
        return ZERO
    a, b, c = rng.standard_normal(3).tolist()
    return a * deviations[0], b * deviations[1], c * deviations[2]


def _geometric(ratio: float, count: int) -> float:
    """1 + ratio + ... + ratio^(count - 1); ratio: 0..1."""
    return float(count) if ratio >= 1.0 else (1.0 - ratio**count) / (1.0 - ratio)

"""Sensors with hector's errors."""

from __future__ import annotations

from typing import ClassVar

from bullet_sim.parts.base import Sensor
from bullet_sim.sensors.errors import SensorErrors


class TunedSensor(Sensor):
    """A sensor with hector's errors.

    Attributes:
        errors: of its measurements, in the order in which they restart.
    """

    STATE: ClassVar[tuple[str, ...]] = ("errors", "_measured")
    errors: tuple[SensorErrors, ...] = ()

    def reset(self, time: float) -> None:
        """With random errors, as their drifts give them."""
        super().reset(time)
        self._measured = time
        self.restart_errors()

    def restart_errors(self) -> None:
        """Start all of them again."""
        for errors in self.errors:
            errors.restart(self.rng)

    def elapsed(self, time: float) -> float:
        """Time since the last measurement, or the reset [s]."""
        before, self._measured = self._measured, time
        return time - before

    def tuned(self) -> dict[str, SensorErrors]:
        """Namespace -> errors whose parameters can be changed below it."""
        return {}

"""Sensors with hector's errors, which tags of their plugins give."""

from __future__ import annotations

from functools import partial
from typing import Any, ClassVar

from bullet_sim.parts.base import Sensor
from bullet_sim.plugins.spec import reading
from bullet_sim.plugins.xml import PluginXml
from bullet_sim.pose import ZERO, Vec3
from bullet_sim.sensors.errors import HOUR, ErrorModel, SensorErrors

_PARAMETERS = tuple(  # hector_gazebo_plugins/SensorModel.cfg
    (name, "double", default, low, high, text)
    for name, default, low, high, text in (
        ("gaussian_noise", 0.0, 0.0, 10.0, "Standard deviation of the white noise"),
        ("offset", 0.0, -10.0, 10.0, "Constant error"),
        ("drift", 0.0, 0.0, 10.0, "Standard deviation of the drift"),
        ("drift_frequency", 0.0, 0.0, 1.0, "At which the drift decays [1/s]"),
        ("scale_error", 1.0, 0.0, 2.0, "Factor"),
    )
)
_FIELDS = {  # of SensorModel.cfg -> of an ErrorModel
    "gaussian_noise": "noise",
    "offset": "offset",
    "drift": "drift",
    "drift_frequency": "frequency",
    "scale_error": "scale",
}


def sensor_errors(xml: PluginXml, prefix: str = "", noise: float = 0.0) -> ErrorModel:
    """Errors that a plugin's tags give.

    Args:
        prefix: of the tags: "accel" reads <accelOffset>; empty: <offset> ...
        noise: standard deviation of all axes; 0: that of the tag.
    """

    def vector(name: str, default: Vec3) -> Vec3:
        tag = f"{prefix}{name}" if prefix else f"{name[0].lower()}{name[1:]}"
        return xml.vector(tag, default=default, broadcast=True)

    return ErrorModel(
        offset=vector("Offset", ZERO),
        drift=vector("Drift", ZERO),
        frequency=vector("DriftFrequency", HOUR),
        noise=(noise,) * 3 if noise else vector("GaussianNoise", ZERO),
        scale=vector("ScaleError", (1.0,) * 3),
    )


def errors_of(prefix: str = "") -> Any:
    """See sensor_errors."""
    return reading(lambda xml: sensor_errors(xml, prefix), ErrorModel())


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

    def elapsed(self, time: float) -> tuple[float, int]:
        """Time since the last measurement, or the reset, as a period [s] and a number of them.

        More than one: nobody had subscribed.
        """
        elapsed, self._measured = time - self._measured, time
        times = max(1, round(elapsed * self.nominal_rate))
        return elapsed / times, times

    def tuned(self) -> dict[str, SensorErrors]:
        """Namespace -> errors whose parameters can be changed below it."""
        return {}

    def offer(self) -> None:
        """The parameters of errors: their means over the axes; a change is of all axes."""
        super().offer()
        for namespace, errors in self.tuned().items():
            values = {name: sum(getattr(errors.spec, key)) / 3.0 for name, key in _FIELDS.items()}
            self.reconfigure(namespace, _PARAMETERS, values, partial(self._on_change, errors))

    def _on_change(self, errors: SensorErrors, config: Any, _level: int) -> Any:
        spec = {key: (float(config[name]),) * 3 for name, key in _FIELDS.items()}
        self.call(lambda: setattr(errors, "spec", ErrorModel(**spec)))
        return config

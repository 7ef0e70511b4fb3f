"""Errors of hector's sensors, which dynamic_reconfigure changes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bullet_sim.parts import errors as parts
from bullet_sim.plugins.inertial import ErrorModel
from bullet_sim.sensors.errors import SensorErrors
from paddock_common.reconfigure import describe

from bullet_bridge.plugins.base import ModelPlugin, PluginContext

ERRORS = describe(  # hector_gazebo_plugins/SensorModel.cfg
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


class Tuned(ModelPlugin, parts.TunedSensor):
    """A sensor with hector's errors, which dynamic_reconfigure changes."""

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        for namespace, errors in self.tuned().items():
            self.tune(namespace, errors)

    def tune(
        self, namespace: str, errors: SensorErrors, changed: Callable[[], None] = lambda: None
    ) -> None:
        """Offer the parameters of errors: their means over the axes; a change is of all axes.

        Args:
            changed: is called after a change (simulation thread).
        """
        values = {name: sum(getattr(errors.spec, key)) / 3.0 for name, key in _FIELDS.items()}

        def on_change(config: Any, _level: int) -> Any:
            def change() -> None:
                spec = {key: (float(config[name]),) * 3 for name, key in _FIELDS.items()}
                errors.spec = ErrorModel(**spec)
                changed()

            self.call(change)
            return config

        self.reconfigure(namespace, ERRORS, values, on_change)

"""Gains of PIDs as values of dynamic_reconfigure."""

from __future__ import annotations

import math
import types
from collections.abc import Mapping
from typing import Any

from bullet_sim.controllers.pid import PidGains
from bullet_sim.errors import ControllerError
from control_toolbox.cfg import ParametersConfig

from bullet_bridge.transport.reconfigure import widened

NAMES = ("p", "i", "d", "i_clamp_min", "i_clamp_max", "antiwindup")


def values_of(gains: PidGains) -> dict[str, Any]:
    """A configuration's values of gains."""
    return {name: getattr(gains, name) for name in NAMES}


def gains_of(config: Mapping[str, Any]) -> PidGains:
    """PidGains of a configuration; a NaN passes dynamic_reconfigure's bounds.

    Raises:
        ControllerError: a gain is no finite number.
    """
    for name in NAMES:
        if not math.isfinite(config[name]):
            raise ControllerError(
                f"{name} is {config[name]}, must be a finite number; the gains are unchanged"
            )
    return PidGains(**{name: config[name] for name in NAMES})


def config_type(gains: PidGains) -> types.SimpleNamespace:
    """ParametersConfig with ranges widened to include the present gains."""
    return widened(ParametersConfig, values_of(gains))

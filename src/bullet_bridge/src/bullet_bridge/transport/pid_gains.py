"""Gains of PIDs as values of dynamic_reconfigure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import rospy
from bullet_sim.controllers.pid import PidGains
from bullet_sim.errors import ControllerError, SimError

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


def on_change(
    namespace: str, gains: PidGains, apply: Callable[[PidGains], Any]
) -> Callable[[Any, int], Any]:
    """Callback of a server of gains.

    Args:
        apply: function that sets new PidGains in the simulation; its SimErrors and time-outs are
            logged, and the last gains are published again.
    """
    last = values_of(gains)

    def changed(config: Any, _level: int) -> Any:
        try:
            apply(gains_of(config))
            last.update({name: config[name] for name in NAMES})
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s: %s", namespace, error)
            config.update(last)
        return config

    return changed

"""Tuning of PIDs at run time through dynamic_reconfigure, as in control_toolbox."""

import math
import types

import rospy
from bullet_sim.controllers.pid import PidGains
from bullet_sim.errors import ControllerError, SimError
from control_toolbox.cfg import ParametersConfig
from dynamic_reconfigure.server import Server

NAMES = ("p", "i", "d", "i_clamp_min", "i_clamp_max", "antiwindup")


def config_type(gains):
    """ParametersConfig with ranges widened to include the present gains."""
    widened = types.SimpleNamespace(
        **{
            name: getattr(ParametersConfig, name)
            for name in ("config_description", "defaults", "level", "type", "all_level")
        }
    )
    values = {name: getattr(gains, name) for name in NAMES}
    widened.min = {name: min(low, values[name]) for name, low in ParametersConfig.min.items()}
    widened.max = {name: max(high, values[name]) for name, high in ParametersConfig.max.items()}
    return widened


def _checked(config):
    """PidGains of a configuration; a NaN passes dynamic_reconfigure's own bounds.

    Raises:
        ControllerError: a gain is no finite number.
    """
    for name in NAMES:
        if not math.isfinite(config[name]):
            raise ControllerError(
                f"{name} is {config[name]}, must be a finite number; the gains stay as they are"
            )
    return PidGains(**{name: config[name] for name in NAMES})


class _Server(Server):
    """A server whose first values are the PID's, not those of the parameter server."""

    def __init__(self, gains, callback, namespace):
        self._gains = gains
        super().__init__(config_type(gains), callback, namespace)

    def _copy_from_parameter_server(self):
        self.config.update({name: getattr(self._gains, name) for name in NAMES})


class PidTuning:
    """dynamic_reconfigure server of one PID.

    Args:
        namespace: of its topics, service and parameters, e.g. '/bot/arm/pid'.
        gains: PidGains now.
        apply: function that sets new PidGains in the simulation; its SimErrors and time-outs are
            logged, and the last gains are published again.
    """

    def __init__(self, namespace, gains, apply):
        self._namespace, self._apply, self._started = namespace, apply, False
        self._last = gains
        self._server = _Server(gains, self._changed, namespace)
        self._started = True

    def _changed(self, config, _level):
        if self._started:
            try:
                gains = _checked(config)
                self._apply(gains)
                self._last = gains
            except (SimError, TimeoutError) as error:
                rospy.logerr("%s: %s", self._namespace, error)
                config.update({name: getattr(self._last, name) for name in NAMES})
        return config

    def close(self):
        """Shut down the service and unregister the topics."""
        self._server.set_service.shutdown("the PID is gone")
        self._server.descr_topic.unregister()
        self._server.update_topic.unregister()

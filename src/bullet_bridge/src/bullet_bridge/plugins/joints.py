"""Gains of a mimic, of parameters; drives are parts of the core."""

from __future__ import annotations

import rospy
from bullet_sim.controllers.pid import PidGains, parse_pid
from bullet_sim.errors import SimError
from bullet_sim.plugins.joints import MimicPidSpec
from control_toolbox.cfg import ParametersConfig

from bullet_bridge.plugins.base import (
    PluginContext,
    Preparing,
    ros_side,
)
from bullet_bridge.transport.pid_gains import on_change, values_of


@ros_side(MimicPidSpec)
class MimicPidPlugin(Preparing):
    """Gives a joint that follows another one the PID of its parameters, which can be changed.

    As upstream it moves freely without gains.
    """

    STATE = ("_gains",)

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        where = self.spec.topic
        values = rospy.get_param(where, None)
        if not isinstance(values, dict) or "p" not in values:
            rospy.logerr("No p gain specified for pid.  Namespace: %s", where)
            values = {"p": 0.0}
        warnings: list[str] = []
        try:
            gains = parse_pid(values, where, warnings)
        except SimError as error:
            gains = PidGains(0.0)
            warnings.append(f"{error}; the gains are 0")
        for text in warnings:
            rospy.logwarn("%s", text)
        self._gains = gains
        changed = on_change(where, gains, lambda new: self.call(lambda: self._set(new)))
        self.reconfigure(where, ParametersConfig, values_of(gains), changed)

    def _set(self, gains: PidGains) -> None:
        self._gains = gains
        self.model.mimics.set_gains(self.spec.joint, gains)

    def prepare(self) -> None:
        """The gains count."""
        self._set(self._gains)

"""Joint poses, gains of a mimic; drives are parts of the core."""

from __future__ import annotations

from typing import Any

import rospy
from bullet_sim.controllers.pid import PidGains, parse_pid
from bullet_sim.errors import SimError
from bullet_sim.plugins import drives as specs
from control_toolbox.cfg import ParametersConfig
from trajectory_msgs.msg import JointTrajectory

from bullet_bridge.plugins.base import (
    ModelPlugin,
    PluginContext,
    Preparing,
    ros_side,
)
from bullet_bridge.transport.pid_gains import on_change, values_of


@ros_side(specs.JointPosesSpec)
class JointPosesPlugin(ModelPlugin):
    """Puts joints to the points of a trajectory_msgs/JointTrajectory, one after the other.

    As upstream, each point waits for the time_from_start of the point before it, counted from then,
    and a trajectory whose frame_id is neither the world nor a link is refused.
    """

    STATE = ("_points", "_next")
    COMMANDS = {"topic": (JointTrajectory, "_on_trajectory")}
    every_step = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._points: list[tuple[dict[str, float], float]] = []
        self._next = 0.0

    def reset(self, time: float) -> None:
        """Without a trajectory."""
        super().reset(time)
        self._points, self._next = [], 0.0

    def needs_update(self) -> bool:
        """While there are points to come."""
        return bool(self._points)

    def _on_trajectory(self, message: Any) -> None:
        known, topic = set(self.model.joints.names), self.spec.topic
        points = []
        frame = message.header.frame_id
        if frame not in ("world", "map", "/map") and not self._is_link(frame):
            rospy.logerr("%s: frame_id '%s' is neither world nor map nor a link", topic, frame)
            return
        for point in message.points:
            values = dict(zip(message.joint_names, point.positions))
            if len(point.positions) < len(message.joint_names):
                rospy.logerr(
                    "%s: a point has %d positions, must have %d",
                    topic,
                    len(point.positions),
                    len(message.joint_names),
                )
                return
            mine = {name: value for name, value in values.items() if name in known}
            points.append((mine, point.time_from_start.to_sec()))
        self._next = max(message.header.stamp.to_sec(), self.world.time)
        self._points = points

    def _is_link(self, frame: str) -> bool:
        """Whether a frame is the name of one of the model's links, MODEL::LINK or LINK."""
        name = self.model.name
        return any(frame in (link, f"{name}::{link}") for link in self.model.rigid_parts)

    def update(self, time: float, period: float) -> None:
        if not self._points or time < self._next:
            return
        values, wait = self._points.pop(0)
        try:
            self.model.joints.set_positions(values)
        except SimError as error:
            rospy.logerr("%s: %s", self.spec.topic, error)
        self._next += wait


@ros_side(specs.MimicPidSpec)
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

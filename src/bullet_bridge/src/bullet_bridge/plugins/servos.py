"""hector's servos, which turn to an orientation, and its message of resets."""

from __future__ import annotations

import math
import operator
from typing import Any

import rospy
from bullet_sim.parts.schedule import whole_rate
from bullet_sim.plugins.servos import ZYX, ResetMessageSpec, ServoSpec
from bullet_sim.pose import Quat, Vec3, multiply
from geometry_msgs.msg import QuaternionStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from bullet_bridge.plugins.base import ModelPlugin, PluginContext, Preparing, ros_side
from bullet_bridge.transport import conversions

BASE, LEVEL = "base_link", "base_stabilized"  # frames of joints, and of no command


def euler(orientation: Quat, convention: str) -> Vec3:
    """Angles [rad] of the axes of a convention, in its order."""
    x, y, z, w = orientation
    if convention == ZYX:
        one = 2.0 * (x * y + w * z), w * w + x * x - y * y - z * z
        sine = -2.0 * (x * z - w * y)
        last = 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z
    else:
        one = -2.0 * (y * z - w * x), w * w - x * x - y * y + z * z
        sine = 2.0 * (x * z + w * y)
        last = -2.0 * (x * y - w * z), w * w + x * x - y * y - z * z
    return math.atan2(*one), math.asin(max(-1.0, min(1.0, sine))), math.atan2(*last)


@ros_side(ServoSpec)
class ServoPlugin(ModelPlugin):
    """Turns joints to a geometry_msgs/QuaternionStamped, by velocities; publishes their states.

    Without a command they turn level, to the frame base_stabilized; without its transform to
    base_link they stand.
    """

    STATE = ("_command",)
    COMMANDS = {"command_topic": (QuaternionStamped, "_on_command")}

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        spec = self.spec
        self._states = self.publisher(spec.topic, JointState) if spec.topic else None
        self._numbers = [self.model.joints.names.index(name) for name in spec.joints]
        self._buffer = self.transforms()

    def _rate(self) -> float:
        """Updates come when more than the period has passed."""
        rate, step = super()._rate(), self.world.time_step
        return whole_rate(rate, step, operator.gt) if self._asked > 0.0 else rate

    def reset(self, time: float) -> None:
        """Without a command."""
        self._command: tuple[str, Quat] = (LEVEL, (0.0, 0.0, 0.0, 1.0))
        super().reset(time)

    def prepare(self) -> None:
        """The joints stand until the first update."""
        self._turn([0.0] * len(self.spec.joints))

    def _on_command(self, message: Any) -> None:
        q = message.quaternion
        self._command = (message.header.frame_id, (q.x, q.y, q.z, q.w))

    def _in_base(self) -> Quat | None:
        """The command's orientation in base_link; None: there is no transform."""
        from tf2_ros import TransformException

        frame, orientation = self._command
        try:
            turned = self._buffer.lookup_transform(BASE, frame.lstrip("/"), rospy.Time(0))
        except TransformException:
            return None
        q = turned.transform.rotation
        return multiply((q.x, q.y, q.z, q.w), orientation)

    def _turn(self, velocities: list[float]) -> None:
        self.model.joints.impose_velocities(self.spec.joints, velocities)

    def update(self, time: float, period: float) -> None:
        spec = self.spec
        positions, speeds, efforts = self.model.joints.columns(self._numbers)
        orientation = self._in_base()
        velocities = [0.0] * len(spec.joints)
        if orientation is not None:
            wanted = euler(orientation, spec.convention)
            for i, number in enumerate(spec.angles):
                value = spec.proportional * (wanted[number] - positions[i])
                value -= spec.derivative * speeds[i]
                limit = spec.max_velocity or math.inf
                velocities[i] = max(-limit, min(limit, value))
        self._turn(velocities)
        if self._states is not None:
            self._states.publish(
                JointState(
                    header=conversions.header(time, spec.link),
                    name=list(spec.joints),
                    position=positions,
                    velocity=speeds,
                    effort=efforts,
                )
            )


@ros_side(ResetMessageSpec)
class ResetMessagePlugin(Preparing):
    """Publishes std_msgs/String "reset" when its model is reset."""

    CACHE = ("_is_new",)

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._commands = self.publisher(self.spec.topic, String)
        self._is_new = True

    def reset(self, time: float) -> None:
        """Tell of it, but for the first one, before it is used."""
        super().reset(time)
        if not self._is_new:
            self._commands.publish(String("reset"))
        self._is_new = False

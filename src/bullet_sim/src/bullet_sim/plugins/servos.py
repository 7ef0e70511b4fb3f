"""hector's servos, which turn to an orientation, and its message of resets."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass
from typing import Any

from bullet_sim.parts.base import Part, Preparing, part_of
from bullet_sim.parts.outputs import JointStatesOutput, NumbersOutput
from bullet_sim.parts.schedule import whole_rate
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import PluginSpec, not_negative, number, read, reading
from bullet_sim.plugins.xml import PluginXml
from bullet_sim.pose import Pose, Quat, Vec3, multiply

ZYX, XYZ = "zyx", "xyz"
# Axes of the servos, one after the other -> convention of Euler angles, their numbers.
CONVENTIONS = {
    "y": (XYZ, (1,)),
    "zy": (ZYX, (0, 1)),
    "xy": (XYZ, (0, 1)),
    "zyx": (ZYX, (0, 1, 2)),
    "xyz": (XYZ, (0, 1, 2)),
}


def _topic_unless_empty(tag: str, default: str) -> Any:
    """Full name of a topic; empty where its name is."""
    return reading(
        lambda xml: xml.topic(tag, default) if xml.text(tag, default) else "", f"/{default}"
    )


@dataclass(frozen=True)
class ServoSpec(PluginSpec):
    """libhector_servo_plugin: one to three joints that turn to an orientation.

    Attributes:
        joints: of the servos, from the base on.
        convention, angles: Euler angles that the joints have, and which of them each.
        proportional, derivative: velocity per error [1/s], and less per velocity.
        max_velocity: [rad/s]; 0: none.
        rate: of its computations and joint states [Hz]; 0: every physics step.
        command_topic: of geometry_msgs/QuaternionStamped; empty: none.
        topic: of the joint states; empty: none.
    """

    NAME = "servo"
    joints: tuple[str, ...]
    convention: str
    angles: tuple[int, ...]
    proportional: float = number("proportionalControllerGain", 8.0)
    derivative: float = number("derivativeControllerGain")
    max_velocity: float = number("maxVelocity", 0.0, not_negative)
    rate: float = number("controlRate", 0.0, not_negative)
    command_topic: str = _topic_unless_empty("topicName", "drive")
    topic: str = _topic_unless_empty("jointStateName", "joint_states")


@model_plugin("hector_gazebo_reset_plugin")
@dataclass(frozen=True)
class ResetMessageSpec(PluginSpec):
    """libhector_gazebo_reset_plugin: std_msgs/String "reset" when its model is reset."""

    NAME = "reset"
    topic: str = "/syscommand"


_SERVOS = ("first", "second", "third")


@model_plugin("hector_servo_plugin")
def servo(xml: PluginXml) -> ServoSpec | None:
    """ServoSpec; None, with a warning, where upstream would throw an exception."""
    names = [xml.in_scope(xml.text(f"{which}ServoName")) for which in _SERVOS]
    known = [name in xml.model.joints for name in names]
    count = known.index(False) if False in known else len(known)
    axes = "".join(_axis(xml, which) for which in _SERVOS[:count])
    if axes not in CONVENTIONS or (count == 1 and known[2]):
        xml.warn(
            f"{xml.label} has joints {', '.join(filter(None, names)) or '(none)'} of axes "
            f"'{axes}', must be joints of the model, from the first one on, of axes "
            f"{', '.join(CONVENTIONS)}; it is left out"
        )
        return None
    convention, angles = CONVENTIONS[axes]
    return read(ServoSpec, xml, joints=tuple(names[:count]), convention=convention, angles=angles)


def _axis(xml: PluginXml, which: str) -> str:
    """Letter of a servo's axis; "?": none of its numbers is 1."""
    numbers = xml.vector(f"{which}ServoAxis")
    return next((letter for letter, value in zip("xyz", numbers) if value == 1.0), "?")


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


@part_of(ServoSpec)
class ServoPlugin(Part):
    """Turns joints to a geometry_msgs/QuaternionStamped, by velocities; publishes their states.

    Without a command they turn level, to the frame base_stabilized; without its transform to
    base_link they stand.
    """

    STATE = ("_command",)
    needs_ros = True
    COMMANDS = {"command_topic": ("geometry_msgs/QuaternionStamped", "_on_command")}

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec = self.spec
        self._states = None
        if spec.topic:
            self._states = self.output(
                JointStatesOutput(spec.topic, spec.joints, frame_id=spec.link)
            )
        self._numbers = [self.model.joints.names.index(name) for name in spec.joints]
        self._frames = self.transforms()

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
        frame, orientation = self._command
        try:
            turned: Pose = self._frames.pose_in(BASE, frame.lstrip("/"))
        except LookupError:
            return None
        return multiply(turned.orientation, orientation)

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
            self._states.send(time, positions, speeds, efforts)


@part_of(ResetMessageSpec)
class ResetMessagePlugin(Preparing):
    """Publishes std_msgs/String "reset" when its model is reset."""

    CACHE = ("_is_new",)

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._commands = self.output(NumbersOutput(self.spec.topic, "std_msgs/String", {"data": 0}))
        self._is_new = True

    def reset(self, time: float) -> None:
        """Tell of it, but for the first one, before it is used."""
        super().reset(time)
        if not self._is_new:
            self._commands.send(time, "reset")
        self._is_new = False

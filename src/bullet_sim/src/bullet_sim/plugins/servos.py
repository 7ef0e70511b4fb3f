"""hector's servos, which turn to an orientation, and its message of resets: specifications."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import PluginSpec, not_negative, number, read, reading
from bullet_sim.plugins.xml import PluginXml

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

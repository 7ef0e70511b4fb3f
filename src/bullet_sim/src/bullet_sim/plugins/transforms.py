"""Transforms from the simulator itself: their specifications, read from a plugin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.rules import BASE, FrameName
from bullet_sim.plugins.spec import PluginSpec, number, read, reading
from bullet_sim.plugins.xml import PluginXml


@dataclass(frozen=True)
class JointTransformsSpec(PluginSpec):
    """libpaddock_state_publisher: the transforms of all joints, as robot_state_publisher's.

    Attributes:
        prefix: before the links' names.
    """

    NAME = "state_publisher"
    rate: float = number("updateRate", 50.0)
    topic: str = "/tf"
    prefix: str = reading(lambda xml: FrameName("", xml.names.prefix()), "")


@dataclass(frozen=True)
class RootTransformSpec(PluginSpec):
    """The true transform of a model's root link.

    Attributes:
        frame_id: name of the world's frame.
        child_frame_id: of the link.
    """

    NAME = JointTransformsSpec.NAME
    frame_id: str
    rate: float = number("frameRate", 50.0)
    topic: str = "/tf"
    child_frame_id: str = reading(lambda xml: FrameName(xml.model.root, xml.names.prefix()), "")


@model_plugin("paddock_state_publisher", rule=BASE)  # the rule of robot_state_publisher
def state_publisher(xml: PluginXml) -> list[Any]:
    """JointTransformsSpec; with a <frameName> of the world RootTransformSpec, too."""
    specs: list[Any] = [read(JointTransformsSpec, xml)]
    if frame := xml.text("frameName").lstrip("/"):
        specs.append(read(RootTransformSpec, xml, frame_id=frame))
    return specs

"""Bumpers: the specification of a <sensor> of contacts, read from its plugin."""

from __future__ import annotations

from dataclasses import dataclass

from bullet_sim.plugins.registry import sensor_plugin
from bullet_sim.plugins.rules import PLAIN
from bullet_sim.plugins.spec import PluginSpec, frame_of, rate_of, reading, topic_of
from bullet_sim.plugins.xml import SensorXml


def _collisions(xml: SensorXml) -> tuple[str, ...]:
    """As sdformat: the name that it gives where there is none is that of no collision."""
    named = [(element.text or "").strip() for element in xml.sensor.findall("contact/collision")]
    return tuple(filter(None, named or ["__default__"]))


@sensor_plugin("gazebo_ros_bumper", types=("contact",), rule=PLAIN)
@dataclass(frozen=True)
class ContactSpec(PluginSpec):
    """A bumper: contacts of some collision shapes.

    Attributes:
        collisions: names of the monitored collisions in Gazebo, of the link that the sensor is in
            there; empty: all of `link` in the file.
        rate: messages per simulated second [Hz]; 0: every physics step.
    """

    collisions: tuple[str, ...] = reading(_collisions, ())
    rate: float = rate_of(None)
    topic: str = topic_of("bumperTopicName", "bumper_states")
    frame_id: str = frame_of("frameName", "world")

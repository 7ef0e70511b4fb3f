"""Plugins of users' own packages: their specifications, for a class that the bridge loads."""

from dataclasses import dataclass, field

from bullet_sim.plugins.xml import PluginXml, SensorXml, library
from bullet_sim.pose import ZERO_POSE, PoseTuple


@dataclass(frozen=True)
class CustomSpec:
    """A plugin or sensor of a user's own package.

    Attributes:
        name: of the sensor, or of the plugin of a model.
        library: name of the plugin's library without folder, 'lib' and '.so'.
        rate: updates per simulated second [Hz]; 0: every physics step.
        topic: resolved <topicName>, by default the plugin's name.
        frame_id: <frameName>, by default the link.
        pose: (xyz [m], rpy [rad]) of the sensor frame in the link frame.
        xml: the plugin; its methods raise ModelError for invalid values.
    """

    name: str
    link: str
    library: str
    rate: float
    topic: str
    frame_id: str
    pose: PoseTuple
    xml: PluginXml = field(repr=False, compare=False)


def custom_plugin(xml: PluginXml) -> CustomSpec:
    """Reader of a plugin of a model; on the link <bodyName>, by default the root link."""
    link = xml.link("bodyName", xml.model.root)
    rate, name = max(0.0, xml.number("updateRate")), xml.name or library(xml.element)
    return _spec(xml, name, name, link, rate, ZERO_POSE)


def custom_sensor(xml: SensorXml) -> CustomSpec:
    """Reader of a plugin of a sensor."""
    default_topic = xml.plugin_name or library(xml.element)
    return _spec(xml, xml.name, default_topic, xml.parent, xml.rate(), xml.pose)


def _spec(
    xml: PluginXml, name: str, default_topic: str, link: str, rate: float, pose: PoseTuple
) -> CustomSpec:
    topic, frame = xml.topic("topicName", default_topic), xml.frame("frameName", link)
    return CustomSpec(name, link, library(xml.element), rate, topic, frame, pose, xml.strict())

"""Specifications of plugins: dataclasses whose fields say which tag they are read from.

@sensor_plugin("gazebo_ros_thermometer", types=("thermometer",))
@dataclass(frozen=True)
class ThermometerSpec(SensorSpec):
    heat: float = number("heat", 20.0)  # tag, and the default without it
    rate: float = rate_of()
    topic: str = topic_of("topicName", "temperature")
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, ClassVar, TypeVar

from bullet_sim.plugins.xml import SensorXml
from bullet_sim.pose import ZERO_POSE, PoseTuple

_READ = "read"  # a field's reader, in its metadata
S = TypeVar("S")


def reading(reader: Callable[[Any], Any], default: Any = MISSING) -> Any:
    """A field with a reader of its own, a function of the element.

    Args:
        default: of a specification that is made without a file.
    """
    return field(default=default, metadata={_READ: reader})


@dataclass(frozen=True)
class PluginSpec:
    """What a plugin's element says.

    Attributes:
        NAME: of a plugin without a name; empty: it has that of its joint or link.
        INTERFACE: of ros_control, by which a controller reports it; empty: none does.
        name: the plugin's or the sensor's.
        link: the root link of its model, or the link that its sensor is in.
    """

    NAME: ClassVar[str] = ""
    INTERFACE: ClassVar[str] = ""
    name: str
    link: str


@dataclass(frozen=True)
class SensorSpec(PluginSpec):
    """What a <sensor> with a plugin says.

    Attributes:
        pose: (xyz [m], rpy [rad]) of the sensor frame in the link frame.
    """

    pose: PoseTuple = reading(lambda xml: xml.pose, ZERO_POSE)


def read(spec: type[S], xml: Any, **given: Any) -> S:
    """A specification, each field by its reader.

    Args:
        xml: PluginXml or SensorXml.
        given: fields that are known already.
    """
    if issubclass(spec, PluginSpec):
        name = xml.name or spec.NAME or given.get("joint") or given.get("link")
        given.setdefault("name", name or xml.link("bodyName"))
    for attribute in fields(spec):  # type: ignore[arg-type]
        if attribute.name not in given and _READ in attribute.metadata:
            given[attribute.name] = attribute.metadata[_READ](xml)
    if issubclass(spec, PluginSpec) and "link" not in given:
        given["link"] = xml.parent if isinstance(xml, SensorXml) else xml.model.root
    return spec(**given)


def not_negative(value: float) -> float:
    """The number, or 0."""
    return max(0.0, value)


def number(tag: str, default: float = 0.0, then: Callable[[float], Any] = float) -> Any:
    """A finite number; `then` is called with it, and with the default."""
    return reading(lambda xml: then(xml.number(tag, default)), then(default))


def switch(tag: str, default: bool = False) -> Any:
    """True or false, see PluginValues.switch."""
    return reading(lambda xml: xml.switch(tag, default), default)


def vector(tag: str, default: tuple[float, ...] = (0.0, 0.0, 0.0), broadcast: bool = False) -> Any:
    """As many finite numbers as the default has."""
    return reading(lambda xml: xml.vector(tag, len(default), default, broadcast), default)


def text_of(tag: str, default: str = "") -> Any:
    """A text."""
    return reading(lambda xml: xml.text(tag, default), default)


def topic_of(tag: str, default: str) -> Any:
    """Full name of a topic, in the plugin's namespace."""
    return reading(lambda xml: xml.topic(tag, default), "/" + default.strip("/"))


def given_topic(tag: str = "topicName", default: Any = MISSING) -> Any:
    """Full name of a topic without which the plugin does not start."""
    return reading(lambda xml: xml.given_topic(tag), default)


def frame_of(tag: str, default: str, merge: bool = False) -> Any:
    """Name of a frame, see PluginXml.frame."""
    return reading(lambda xml: xml.frame(tag, default, merge=merge), default)


def rate_of(tag: str | None = "updateRate") -> Any:
    """The lower of a sensor's and its plugin's rate [Hz]; 0, every physics step, without one."""
    return reading(lambda xml: xml.rate(tag), 0.0)


def link_of(tag: str = "bodyName") -> Any:
    """Link that a tag names; the plugin is left out where the model has no such link."""
    return reading(lambda xml: xml.link(tag))

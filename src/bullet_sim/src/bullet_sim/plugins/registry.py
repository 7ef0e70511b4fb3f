"""Readers of <plugin> elements by the name of their library, e.g. gazebo_ros_camera.

Attributes of a reader: `types` of <sensor> that it supports; whether it `reads_sensors` that have
no plugin. Readers from a source of a registry may lack them: they support any type, and may read
sensors.
"""

from __future__ import annotations

import functools
from typing import Any, Callable, TypeVar

from bullet_sim.plugins.rules import NONE, RULES, Rule
from bullet_sim.plugins.spec import read
from bullet_sim.plugins.xml import PluginXml, SensorXml
from bullet_sim.registry import Registry

# They return a specification, a list of them, or None; those of plugins may change the model, too.
PluginReader = Callable[[PluginXml], Any]
SensorReader = Callable[[SensorXml], Any]
PLUGINS: Registry[PluginReader] = Registry("plugin")
SENSOR_PLUGINS: Registry[SensorReader] = Registry("plugin of a sensor")


Entry = TypeVar("Entry", bound=Callable[..., Any])


def model_plugin(
    *names: str, rule: Rule = NONE, reads_sensors: bool = False
) -> Callable[[Entry], Entry]:
    """Decorator of what a <plugin> of a model is read by: a function, or a class of spec.py.

    Args:
        names: of its libraries.
        rule: of its namespace and its frames.
    """
    return _entering(PLUGINS, names, rule, reads_sensors=reads_sensors)


def sensor_plugin(
    *names: str, types: tuple[str, ...], rule: Rule = NONE
) -> Callable[[Entry], Entry]:
    """As model_plugin, of a <plugin> in a <sensor> of these types."""
    return _entering(SENSOR_PLUGINS, names, rule, types=types)


def _entering(
    registry: Registry[Any], names: tuple[str, ...], rule: Rule, **facts: Any
) -> Callable[[Entry], Entry]:
    def enter(entry: Entry) -> Entry:
        RULES.update(dict.fromkeys(names, rule))
        reader = functools.partial(read, entry) if isinstance(entry, type) else entry
        registry.register(*names, **facts)(reader)
        return entry

    return enter

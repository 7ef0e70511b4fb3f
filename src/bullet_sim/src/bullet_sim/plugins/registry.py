"""Readers of <plugin> elements by the name of their library, e.g. gazebo_ros_camera.

Attributes of a reader: `types` of <sensor> that it supports; whether it `reads_sensors` that have
no plugin. Readers from a source of a registry may lack them: they support any type, and may read
sensors.
"""

from __future__ import annotations

from typing import Any, Callable

from bullet_sim.plugins.xml import PluginXml, SensorXml
from bullet_sim.registry import Registry

# They return a specification, a list of them, or None; those of plugins may change the model, too.
PluginReader = Callable[[PluginXml], Any]
SensorReader = Callable[[SensorXml], Any]
PLUGINS: Registry[PluginReader] = Registry("plugin")
SENSOR_PLUGINS: Registry[SensorReader] = Registry("plugin of a sensor")


def model_plugin(
    *names: str, reads_sensors: bool = False
) -> Callable[[PluginReader], PluginReader]:
    """Decorator of the reader of a <plugin> of a model, under the names of its libraries."""
    return PLUGINS.register(*names, reads_sensors=reads_sensors)


def sensor_plugin(*names: str, types: tuple[str, ...]) -> Callable[[SensorReader], SensorReader]:
    """Decorator of the reader of a <plugin> in a <sensor>, under the names of its libraries."""
    return SENSOR_PLUGINS.register(*names, types=types)

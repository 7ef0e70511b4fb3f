"""Readers of <plugin> elements by the name of their library, e.g. gazebo_ros_camera.

What a reader is for are attributes of the function: `types` of <sensor> that it takes; whether it
`reads_sensors` that have no plugin. One that a source of a registry gives may leave them out: it
takes any type, and may read sensors.
"""

from collections.abc import Callable
from typing import Any

from bullet_sim.plugins.xml import PluginXml, SensorXml
from bullet_sim.registry import Registry

PluginReader = Callable[[PluginXml], None]  # adds to the model's sensors, or changes the model
SensorReader = Callable[[SensorXml], Any]  # gives a specification or a list of them
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

"""<sensor> and <plugin> elements: their specifications and readers."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Any, cast
from xml.etree.ElementTree import Element

from bullet_sim.description.model import ModelDescription
from bullet_sim.errors import BROKEN, ModelError
from bullet_sim.plugins.registry import PLUGINS, SENSOR_PLUGINS, SensorReader
from bullet_sim.plugins.xml import MissingPart, PluginXml, SensorXml, library
from bullet_sim.pose import Pose
from bullet_sim.registry import Registry, load_files
from bullet_sim.xml_reader import Node, document_root, sdf_pose

__all__ = ["PLUGINS", "SENSOR_PLUGINS", "parse_joint_sensor", "parse_plugin", "parse_sensor"]

load_files(__name__, __path__)

SIMILAR = 0.85  # of two names, by difflib's ratio: one letter of six is wrong or missing


def sensor_types() -> tuple[str, ...]:
    """Types of <sensor> that built-in readers support."""
    names = filter(SENSOR_PLUGINS.is_built_in, SENSOR_PLUGINS.names())
    types = (kind for name in names for kind in SENSOR_PLUGINS.find(name).types)  # type: ignore[attr-defined]
    return tuple(dict.fromkeys(types))


def parse_plugin(element: Element, model: ModelDescription, scope: str = "") -> None:
    """Read one model plugin into the model description; an unknown one is a warning.

    Args:
        scope: see PluginXml.
    """
    reader = _find(PLUGINS, library(element))
    if reader is None:
        name = element.get("filename")
        model.warn(
            f"plugin '{name}' is not known here and is ignored{_nearest(library(element))}",
            "plugins are not known here and are ignored",
            f"'{name}'",
        )
        return
    try:
        _add(reader(PluginXml(element, model, scope)), model)
    except MissingPart as error:
        cause = error.cause or "plugins are left out"
        model.warn(str(error), cause, error.item or str(error))
    except ModelError as error:
        model.warn(f"{error}; the plugin is left out", "plugins are left out", str(error))
    except BROKEN as error:
        _warn_broken(element, error, "plugin", "plugins are left out")


def parse_sensor(element: Element, link: str, model: ModelDescription) -> None:
    """Specifications of one <sensor>, which go into the model's list.

    Args:
        model: its description so far; gets warnings, too.
    """
    sensor_type, name = element.get("type"), element.get("name") or "sensor"
    model.has_sensors = True
    plugins = element.findall("plugin")
    readers = [_sensor_reader(library(plugin), sensor_type) for plugin in plugins]
    if sensor_type not in sensor_types() and not any(readers):
        model.warn(
            f"sensor '{name}' has type '{sensor_type}', known are {', '.join(sensor_types())};"
            " it is left out",
            "sensors have a type that is not known here and are left out",
            f"'{name}' ({sensor_type})",
        )
        return
    if not plugins and not _is_for_a_plugin(element):
        model.warn(
            f"sensor '{name}' has no ROS plugin and so no topic; it is left out",
            "sensors have no ROS plugin and so no topic and are left out",
            f"'{name}'",
        )
    pose = sdf_pose(element, f"sensor '{name}'")
    model.sensor_elements.append((link, pose, element))
    for plugin, reader in zip(plugins, readers):
        if reader is None:
            known = [
                f"lib{own}.so" for own in SENSOR_PLUGINS.names() if _sensor_reader(own, sensor_type)
            ]
            model.warn(
                f"plugin '{plugin.get('filename')}' of sensor '{name}' is not known here "
                f"and is ignored; a sensor of type {sensor_type} takes {', '.join(known)}",
                "plugins of sensors are not known here and are ignored",
                f"'{plugin.get('filename')}'",
            )
            continue
        try:
            _add(reader(SensorXml(plugin, model, element, link, pose)), model)
        except ModelError as error:
            model.warn(f"{error}; sensor '{name}' is left out", "sensors are left out", f"'{name}'")
        except BROKEN as error:
            _warn_broken(element, error, "sensor", "sensors are left out")


def parse_joint_sensor(element: Element, joint: str, model: ModelDescription) -> None:
    """Specifications of the plugins in C++ of a joint's <sensor>, which go into the model's list.

    Others have no topic: Gazebo's own measure by a plugin of the model.
    """
    model.joint_sensor_elements.append((joint, element))
    child = model.joints[joint].child
    for plugin in element.findall("plugin"):
        reader = _sensor_reader(library(plugin), element.get("type"))
        if reader is None:
            continue
        try:
            _add(reader(SensorXml(plugin, model, element, child, Pose())), model)
        except ModelError as error:
            name = f"'{element.get('name')}'"
            model.warn(f"{error}; sensor {name} is left out", "sensors are left out", name)


def _warn_broken(element: Element, error: Exception, noun: str, cause: str) -> None:
    """Warn of an element with numbers that nothing can be computed of."""
    name = f"'{element.get('name')}'"
    text = f"{noun} {name} cannot be read ({type(error).__name__}: {error}); it is left out"
    cast(Node, element).warn(text, cause, name)


def _add(specs: Any, model: ModelDescription) -> None:
    if specs is not None:
        model.sensors += specs if isinstance(specs, list) else [specs]


def _find(registry: Registry[Any], name: str) -> Any:
    """The reader of a library; None: the library is unknown."""
    try:
        return registry.find(name)
    except KeyError:
        return None


def _nearest(name: str) -> str:
    """A question after the plugin that a library's misspelled name may mean, or ""."""
    if _find(SENSOR_PLUGINS, name):  # it is spelled well, but belongs into a <sensor>
        return ""
    # reversed: of gazebo_ros_imu and hector_gazebo_ros_imu the first remains
    own = {known.rpartition("gazebo_ros_")[2]: known for known in reversed(PLUGINS.names())}
    matches = get_close_matches(name.rpartition("gazebo_ros_")[2], own, 1, SIMILAR)
    return f"; did you mean 'lib{own[matches[0]]}.so'?" if matches else ""


def _sensor_reader(name: str, sensor_type: str | None) -> SensorReader | None:
    """The reader of a library that supports a type of <sensor>, or None."""
    reader = _find(SENSOR_PLUGINS, name)
    return reader if sensor_type in (getattr(reader, "types", None) or (sensor_type,)) else None


def _is_for_a_plugin(sensor: Element) -> bool:
    """Whether a sensor without a plugin may be one that a plugin of its model reads."""
    holders = [node for node in document_root(sensor).iter() if node.tag in ("model", "gazebo")]
    plugins = [plugin for holder in holders for plugin in holder.findall("plugin")]
    readers = [_find(PLUGINS, library(plugin)) for plugin in plugins]
    return any(getattr(reader, "reads_sensors", True) for reader in readers)

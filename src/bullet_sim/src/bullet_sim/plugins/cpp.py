"""Plugins in C++, of users' packages: their specifications, for Gazebo's own libraries."""

from __future__ import annotations

import functools
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any
from xml.etree.ElementTree import Element

from bullet_sim.errors import ModelError
from bullet_sim.plugins.registry import PLUGINS, SENSOR_PLUGINS
from bullet_sim.plugins.spec import PluginSpec
from bullet_sim.plugins.xml import PluginXml, SensorXml, library


@dataclass(frozen=True)
class CppSpec(PluginSpec):
    """A plugin whose library is there.

    Attributes:
        folder: of the library.
        text: the plugin's element; its filename is the library's without a folder.
        sensor: the <sensor> that has it; None: a model or the world.
    """

    folder: str
    text: str = field(repr=False)
    topic: str = ""
    sensor: Element | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True)
class Libraries:
    """Where plugins in C++ are found.

    Attributes:
        folder_of: function of a library's name without 'lib' and '.so': its folder; '': unknown.
        problem: why they cannot be loaded here, with the remedy; '': they can.
    """

    folder_of: Callable[[str], str]
    problem: str = ""


_found: list[Libraries] = []


def use(libraries: Libraries) -> Callable[[], None]:
    """Have C++ plugins that are not built in looked up; returns the function that ends it."""
    removals = [
        PLUGINS.add_source(_reader, tuple),
        SENSOR_PLUGINS.add_source(_reader, tuple),
    ]
    _found.append(libraries)

    def end() -> None:
        for remove in removals:
            remove()
        _found.remove(libraries)

    return end


def cpp_spec(element: Element, link: str = "", sensor: Element | None = None) -> CppSpec | None:
    """Specification of a <plugin>; None: no library has its name.

    Args:
        link, sensor: in which it is.

    Raises:
        ModelError: the library is there, and cannot be loaded here.
    """
    name = library(element)
    for libraries in _found:
        folder = libraries.folder_of(name)
        if not folder:
            continue
        if libraries.problem:
            raise ModelError(f"plugin 'lib{name}.so' is in C++, and {libraries.problem}")
        copied = ElementTree.fromstring(ElementTree.tostring(element))
        copied.set("filename", f"lib{name}.so")
        copied.set("name", element.get("name") or name)
        text = ElementTree.tostring(copied, encoding="unicode")
        return CppSpec(copied.get("name", name), link, folder, text, sensor=sensor)
    return None


def _reader(name: str) -> Any:
    """What reads a plugin of a library; a new object each time, to which facts may be added."""
    has = any(libraries.folder_of(name) for libraries in _found)
    return functools.partial(_read) if has else None


def _read(xml: PluginXml) -> CppSpec | None:
    if isinstance(xml, SensorXml):
        return cpp_spec(xml.element, xml.parent, xml.sensor)
    return cpp_spec(xml.element, xml.model.root)

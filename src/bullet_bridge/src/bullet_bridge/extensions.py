"""Controllers, plugins and sensors of users' packages, declared by <export> in their package.xml.

    <export>
      <bullet_bridge controller="my_robot/BangBang" class="my_robot.controllers:BangBang"/>
      <bullet_bridge plugin="libconveyor.so" class="my_robot.simulation:Conveyor"/>
      <bullet_bridge sensor="libgas.so" class="my_robot.simulation:GasSensor" type="gas"/>
    </export>

catkin writes no metadata of Python packages into the devel space, so that entry points would be
missing where users work; devel and install spaces both have manifests. They are read only
when a type or a library is not built in.
"""

from __future__ import annotations

import functools
import importlib
import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import rospkg
import rospy
from bullet_sim.controllers import CONTROLLERS, Controller
from bullet_sim.errors import ControllerError, ModelError, SimError
from bullet_sim.plugins.custom import CustomSpec, custom_plugin, custom_sensor
from bullet_sim.plugins.registry import PLUGINS, SENSOR_PLUGINS
from bullet_sim.plugins.xml import SensorXml

from bullet_bridge.plugins.base import ModelPlugin, Sensor
from bullet_bridge.resolve import manifest_with

TAG = "bullet_bridge"
BASES = {"controller": Controller, "plugin": ModelPlugin, "sensor": Sensor}


@dataclass(frozen=True)
class Extension:
    """One line of a package.xml.

    Attributes:
        kind: controller, plugin or sensor.
        name: of the controller type, or of the library without folder, 'lib' and '.so'.
        target: MODULE:CLASS.
        package, manifest: name of the package, path of its package.xml.
        sensor_type: type="..." of the <sensor>s that it reads; empty: any that SDF knows.
    """

    kind: str
    name: str
    target: str
    package: str
    manifest: str
    sensor_type: str = ""

    def __str__(self) -> str:
        return f"{self.kind} '{self.name}' is {self.target} of package {self.package}"

    def load(self) -> type:
        """The class.

        Raises:
            SimError: names package.xml, class and reason.
        """
        module, _, name = self.target.partition(":")
        label = f"{self.manifest} names class '{self.target}' for {self.kind} '{self.name}'"
        try:
            loaded = getattr(importlib.import_module(module), name)
        except Exception as error:  # any error of a user's module
            raise SimError(f"{label}, which cannot be imported: {_formatted(error)}") from error
        base = BASES[self.kind]
        if not (isinstance(loaded, type) and issubclass(loaded, base)):
            raise SimError(f"{label}, which is no subclass of {base.__module__}.{base.__name__}")
        return loaded


def _formatted(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


class Extensions:
    """The extensions of all packages on ROS_PACKAGE_PATH.

    Args:
        packages: rospkg.RosPack; None: a new one when it is needed.
    """

    def __init__(self, packages: rospkg.RosPack | None = None) -> None:
        self._packages = packages
        self._entries: dict[tuple[str, str], Extension] | None = None

    def enter(self) -> None:
        """Make them available to the simulator, after what is built in."""
        CONTROLLERS.add_source(self.controller, lambda: self.names("controller"))
        PLUGINS.add_source(
            lambda name: custom_plugin if self.get("plugin", name) else None,
            lambda: self.names("plugin"),
        )
        SENSOR_PLUGINS.add_source(self._sensor_reader, lambda: self.names("sensor"))

    def all(self) -> dict[tuple[str, str], Extension]:
        """All Extensions by (kind, name); errors of a line are logged, once."""
        if self._entries is None:
            entries: dict[tuple[str, str], Extension] = {}
            self._entries = entries
            for extension in self._read():
                self._add(entries, extension)
        return self._entries

    def names(self, kind: str) -> tuple[str, ...]:
        """Names of the extensions of a kind."""
        return tuple(name for of_kind, name in self.all() if of_kind == kind)

    def get(self, kind: str, name: str) -> Extension | None:
        """The Extension, or None."""
        return self.all().get((kind, name))

    def controller(self, name: str) -> type[Controller] | None:
        """Class of a controller type, or None.

        Raises:
            ControllerError: its class cannot be loaded.
        """
        extension = self.get("controller", name)
        if extension is None:
            return None
        try:
            return extension.load()
        except SimError as error:
            raise ControllerError(str(error)) from error

    def plugin(self, spec: CustomSpec) -> type[ModelPlugin]:
        """Class of a CustomSpec.

        Raises:
            SimError: it cannot be loaded.
        """
        return self.of(spec).load()

    def of(self, spec: CustomSpec) -> Any:
        """The Extension of a CustomSpec."""
        kind = "sensor" if isinstance(spec.xml, SensorXml) else "plugin"
        return self.get(kind, spec.library)

    def _sensor_reader(self, name: str) -> Callable[[SensorXml], CustomSpec] | None:
        extension = self.get("sensor", name)
        if extension is None:
            return None
        reader: Any = functools.partial(custom_sensor)
        if extension.sensor_type:
            reader.types = (extension.sensor_type,)
        return reader

    @staticmethod
    def _add(entries: dict[tuple[str, str], Extension], extension: Extension) -> None:
        key = extension.kind, extension.name
        other = entries.get(key)
        if other is not None:
            rospy.logerr(
                "%s '%s' is exported by the packages %s and %s, must be by one; that of %s is used",
                *key,
                other.package,
                extension.package,
                other.package,
            )
            return
        entries[key] = extension

    def _read(self) -> Iterator[Extension]:
        packages = self._packages or rospkg.RosPack()
        for package in sorted(packages.list()):
            manifest = manifest_with(TAG, packages, package)
            path = os.path.join(packages.get_path(package), "package.xml")
            for export in () if manifest is None else manifest.exports:
                if export.tag == TAG:
                    try:
                        yield _extension(export.attrs, package, path)
                    except ModelError as error:
                        rospy.logerr("%s", error)


def _extension(attributes: Mapping[str, str], package: str, manifest: str) -> Extension:
    """Extension of an <export>'s line.

    Raises:
        ModelError: names the error.
    """
    kinds = [kind for kind in BASES if kind in attributes]
    target = attributes.get("class", "")
    if len(kinds) != 1:
        raise ModelError(
            f"{manifest} has <{TAG}> with {', '.join(attributes) or 'no attributes'}, must have "
            f"one of {', '.join(BASES)}, and class"
        )
    (kind,) = kinds
    module, colon, name = target.partition(":")
    if not (module and colon and name):
        raise ModelError(
            f"{manifest} has {kind} '{attributes[kind]}' with class '{target}', must be "
            "MODULE:CLASS"
        )
    name = attributes[kind]
    if kind != "controller":
        name = re.sub(r"^lib|\.so$", "", os.path.basename(name))
    return Extension(kind, name, target, package, manifest, attributes.get("type", ""))

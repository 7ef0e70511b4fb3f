"""A fluid that everything is in."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from bullet_sim.meshes.triangles import mesh_box
from bullet_sim.parts.base import Acting, part_of
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import (
    PluginSpec,
    number,
    reading,
)
from bullet_sim.plugins.xml import PluginXml, Values
from bullet_sim.pose import Pose, Vec3


@dataclass(frozen=True)
class Floating:
    """A link that displaces a volume [m^3], whose center (3,) [m] is in its frame."""

    link: str
    volume: float
    center: Vec3


def _floating(xml: PluginXml) -> tuple[Floating, ...]:
    """The usable <link>s; one without a link, a center or a volume is left out with a warning."""
    given = []
    for element in xml.element.findall("link"):
        values = Values(element, f"{xml.label} <link>")
        link, volume = xml.scope + (element.get("name") or ""), values.number("volume")
        center = element.find("center_of_volume")
        if link in xml.model.links and center is not None and volume > 0.0:
            given.append(Floating(link, volume, values.vector("center_of_volume")))
        else:
            xml.warn(
                f"{values.label} '{link}' has volume {volume:g}, must be a link of "
                f"'{xml.model.name}' with a center_of_volume and a volume above 0; it is left out"
            )
    return tuple(given)


@model_plugin("BuoyancyPlugin")
@dataclass(frozen=True)
class BuoyancySpec(PluginSpec):
    """Gazebo's BuoyancyPlugin: everything is in a fluid of a density [kg/m^3].

    Attributes:
        given: links whose volume the file gives.
    """

    NAME = "buoyancy"
    given: tuple[Floating, ...] = reading(_floating, ())
    density: float = number("fluid_density", 999.1026)  # of water
    topic: str = ""


@part_of(BuoyancySpec)
class BuoyancyPlugin(Acting):
    """Lifts each link by the weight of the fluid that it displaces, wherever it is, as Gazebo's."""

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        given = {part.link: part for part in self.spec.given}
        parts = self.model.rigid_parts.items()
        self._parts = [given.get(name) or self._displaced(name, link) for name, link in parts]

    def _displaced(self, name: str, link: Any) -> Floating:
        """The volume of a link's collisions, of a mesh that of the box around it."""
        volumes, places = [0.0], [np.zeros(3)]
        for shape in link.collisions:
            kind, size = shape.geometry.kind, shape.geometry.size
            if kind == "box":
                volume = float(np.prod(size))
            elif kind == "sphere":
                volume = 4.0 / 3.0 * math.pi * size[0] ** 3
            elif kind == "cylinder":
                volume = math.pi * size[0] ** 2 * size[1]
            elif kind == "mesh":
                low, high = mesh_box(shape.geometry.path)
                volume = float(np.prod((high - low) * np.abs(shape.geometry.scale)))
            else:
                continue
            volumes.append(volume)
            places.append(np.array(shape.pose.position))
        total = sum(volumes)
        middle = np.average(places, axis=0, weights=volumes) if total else np.zeros(3)
        x, y, z = middle.tolist()
        return Floating(name, total, (x, y, z))

    def update(self, time: float, period: float) -> None:
        if self.model.is_static:
            return
        for part in self._parts:
            link, offset = self.model.link_in_body(part.link)
            frame = Pose(*self.model.body.link_motion(link)[:2]) * offset
            point = (frame * Pose(part.center)).position
            force = [-self.spec.density * part.volume * axis for axis in self.world.gravity]
            self.model.body.apply_force(link, force, point)

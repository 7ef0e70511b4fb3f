"""What moves actors instead of their scripts: specifications, read from plugins."""

from __future__ import annotations

from dataclasses import dataclass

from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.xml import PluginXml
from bullet_sim.pose import Vec3
from bullet_sim.xml_reader import floats

FACTOR = 4.5  # animation_factor where none is given, at which steps are as long as the way
HIPS = 1.2138  # [m] height at which the plugins hold an actor


@dataclass(frozen=True)
class WalkerSpec:
    """Gazebo's ActorPlugin: walks to a target, then to one by chance, around models.

    Attributes:
        target: the first one (3,) [m], in the world.
        weight, obstacle_weight: of the way to the target and away from models.
        ignored: models that it does not go around.
        steps: how fast its limbs move for the way that it walks; 1: as far.
    """

    name: str
    link: str
    target: Vec3
    weight: float = 1.15
    obstacle_weight: float = 1.5
    ignored: tuple[str, ...] = ()
    steps: float = 1.0
    topic: str = ""


@model_plugin("ActorPlugin")
def walker(xml: PluginXml) -> WalkerSpec:
    return WalkerSpec(
        name=xml.name or "actor",
        link=xml.model.root,
        target=xml.vector("target", 3, (0.0, -5.0, HIPS)),
        weight=xml.number("target_weight", 1.15),
        obstacle_weight=xml.number("obstacle_weight", 1.5),
        ignored=_models(xml, "ignore_obstacles"),
        steps=_steps(xml),
    )


@dataclass(frozen=True)
class PedestrianSpec:
    """libPedestrianSFMPlugin: walks from goal to goal, by social forces (lightsfm).

    Attributes:
        goals: (x, y) [m] in the world; cyclic: from the last one it goes to the first.
        speed: at most [m/s].
        radius: of a person [m].
        desired, obstacle, social, gaze, coherence, repulsion: factors of the forces.
        distance: within which other actors count [m].
        group: names of the actors that it walks with; None: it has no group.
        ignored: models that are no obstacles.
        steps: see WalkerSpec.
    """

    name: str
    link: str
    goals: tuple[tuple[float, float], ...] = ()
    cyclic: bool = False
    speed: float = 0.8
    radius: float = 0.35
    desired: float = 2.0
    obstacle: float = 10.0
    social: float = 2.1
    gaze: float = 3.0
    coherence: float = 2.0
    repulsion: float = 1.0
    distance: float = 5.0
    group: tuple[str, ...] | None = None
    ignored: tuple[str, ...] = ()
    steps: float = 1.0
    topic: str = ""


@model_plugin("PedestrianSFMPlugin")
def pedestrian(xml: PluginXml) -> PedestrianSpec:
    label = f"{xml.label} <waypoint>"
    points = [
        floats(each.text or "", None, label) for each in xml.element.findall("trajectory/waypoint")
    ]
    return PedestrianSpec(
        name=xml.name or "pedestrian",
        link=xml.model.root,
        goals=tuple((point[0], point[1]) for point in points if len(point) > 1),
        cyclic=xml.flag("trajectory/cyclic"),
        speed=xml.number("velocity", 0.8),
        radius=xml.number("radius", 0.35),
        desired=xml.number("goal_weight", 2.0),
        obstacle=xml.number("obstacle_weight", 10.0),
        social=xml.number("social_weight", 2.1),
        gaze=xml.number("group_gaze_weight", 3.0),
        coherence=xml.number("group_coh_weight", 2.0),
        repulsion=xml.number("group_rep_weight", 1.0),
        distance=xml.number("people_distance", 5.0),
        group=None if xml.element.find("group") is None else _models(xml, "group"),
        ignored=_models(xml, "ignore_obstacles"),
        steps=_steps(xml),
    )


def _steps(xml: PluginXml) -> float:
    """See WalkerSpec."""
    return xml.number("animation_factor", FACTOR) / FACTOR


def _models(xml: PluginXml, tag: str) -> tuple[str, ...]:
    """Names in the <model>s of an element."""
    return tuple((model.text or "").strip() for model in xml.element.findall(f"{tag}/model"))

"""What moves actors instead of their scripts: specifications, read from plugins."""

from __future__ import annotations

from dataclasses import dataclass

from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import PluginSpec, number, reading, vector
from bullet_sim.plugins.xml import PluginXml
from bullet_sim.pose import Vec3
from bullet_sim.xml_reader import floats

FACTOR = 4.5  # animation_factor where none is given, at which steps are as long as the way
HIPS = 1.2138  # [m] height at which the plugins hold an actor


def _models(xml: PluginXml, tag: str) -> tuple[str, ...]:
    """Names in the <model>s of an element."""
    return tuple((model.text or "").strip() for model in xml.element.findall(f"{tag}/model"))


def _ignored(xml: PluginXml) -> tuple[str, ...]:
    return _models(xml, "ignore_obstacles")


def _group(xml: PluginXml) -> tuple[str, ...] | None:
    return None if xml.element.find("group") is None else _models(xml, "group")


def _goals(xml: PluginXml) -> tuple[tuple[float, float], ...]:
    """The first two numbers of each <waypoint> that has them."""
    texts = [element.text or "" for element in xml.element.findall("trajectory/waypoint")]
    points = [floats(text, None, f"{xml.label} <waypoint>") for text in texts]
    return tuple((point[0], point[1]) for point in points if len(point) > 1)


@model_plugin("ActorPlugin")
@dataclass(frozen=True)
class WalkerSpec(PluginSpec):
    """Gazebo's ActorPlugin: walks to a target, then to one by chance, around models.

    Attributes:
        target: the first one (3,) [m], in the world.
        weight, obstacle_weight: of the way to the target and away from models.
        ignored: models that it does not go around.
        steps: how fast its limbs move for the way that it walks; 1: as far.
    """

    NAME = "actor"
    target: Vec3 = vector("target", (0.0, -5.0, HIPS))
    weight: float = number("target_weight", 1.15)
    obstacle_weight: float = number("obstacle_weight", 1.5)
    ignored: tuple[str, ...] = reading(_ignored, ())
    steps: float = number("animation_factor", FACTOR, lambda factor: factor / FACTOR)
    topic: str = ""


@model_plugin("PedestrianSFMPlugin")
@dataclass(frozen=True)
class PedestrianSpec(PluginSpec):
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

    NAME = "pedestrian"
    goals: tuple[tuple[float, float], ...] = reading(_goals, ())
    cyclic: bool = reading(lambda xml: xml.flag("trajectory/cyclic"), False)
    speed: float = number("velocity", 0.8)
    radius: float = number("radius", 0.35)
    desired: float = number("goal_weight", 2.0)
    obstacle: float = number("obstacle_weight", 10.0)
    social: float = number("social_weight", 2.1)
    gaze: float = number("group_gaze_weight", 3.0)
    coherence: float = number("group_coh_weight", 2.0)
    repulsion: float = number("group_rep_weight", 1.0)
    distance: float = number("people_distance", 5.0)
    group: tuple[str, ...] | None = reading(_group, None)
    ignored: tuple[str, ...] = reading(_ignored, ())
    steps: float = number("animation_factor", FACTOR, lambda factor: factor / FACTOR)
    topic: str = ""

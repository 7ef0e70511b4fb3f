"""Grippers that hold what they press: their specifications, read from plugins and <gripper>."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from bullet_sim.description.model import ModelDescription
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import PluginSpec, number, read, reading, switch
from bullet_sim.plugins.xml import MissingPart, PluginXml, Values


@dataclass(frozen=True)
class GraspingArm:
    """A gripper: its name, the link that holds, and those that touch."""

    name: str
    palm: str
    fingers: tuple[str, ...]


def _threshold(xml: PluginXml) -> int:
    """By default half of the highest count."""
    most = int(xml.number("max_grip_count", 10.0))
    return int(xml.number("grip_count_threshold", float(most // 2)))


@dataclass(frozen=True)
class GraspFixSpec(PluginSpec):
    """libgazebo_grasp_fix: attaches what a gripper's links press from opposite sides.

    Attributes:
        link: the palm of the first arm.
        angle: between two forces that are opposite, at least [rad].
        decisions: a second [Hz].
        most: highest count of decisions for which an object was gripped.
        threshold: count above which it is attached.
        tolerance: by which a finger may leave a held object [m].
        passes: a held object collides with nothing.
    """

    NAME = "grasp_fix"
    arms: tuple[GraspingArm, ...]
    angle: float = number("forces_angle_tolerance", 120.0, math.radians)
    decisions: float = number("update_rate", 5.0, lambda rate: max(0.0, float(int(rate))))
    most: int = number("max_grip_count", 10.0, int)
    threshold: int = reading(_threshold, 5)
    tolerance: float = number("release_tolerance", 0.005)
    passes: bool = switch("disable_collisions_on_attach")
    topic: str = ""


@dataclass(frozen=True)
class GripperSpec(PluginSpec):
    """SDF's <gripper>: attaches what its links touch while it rests relative to the palm.

    Attributes:
        link, fingers: the palm, and the links that touch.
        least: contacts between two decisions with which one counts as touching.
        attach, detach: decisions in a row, more of which attach an object, or let it go.
    """

    fingers: tuple[str, ...]
    least: int = 2
    attach: int = 20
    detach: int = 40
    topic: str = ""


@model_plugin("gazebo_grasp_fix")
def grasp_fix(xml: PluginXml) -> GraspFixSpec:
    """GraspFixSpec; an <arm> that cannot be used is left out with a warning.

    Raises:
        MissingPart: no arm is left.
    """
    usable = [_arm(xml, element) for element in xml.element.findall("arm")]
    arms = {arm.name: arm for arm in usable if arm is not None}
    if not arms:
        raise MissingPart(f"{xml.label} has no <arm> that it can use; it is left out")
    return read(GraspFixSpec, xml, link=next(iter(arms.values())).palm, arms=tuple(arms.values()))


def _arm(xml: PluginXml, element: Element) -> GraspingArm | None:
    """An <arm>, or None, with a warning, without a palm or a link that touches."""
    values = Values(element, f"{xml.label} <arm>")
    name, links = values.text("arm_name"), xml.model.links
    palm = xml.scope + values.text("palm_link")
    wanted = [xml.scope + (node.text or "").strip() for node in element.findall("gripper_link")]
    fingers = tuple(link for link in wanted if link in links)
    if name and palm in links and fingers:
        return GraspingArm(name, palm, fingers)
    xml.warn(
        f"{values.label} '{name}' has palm_link '{palm}' and the gripper_links "
        f"{', '.join(wanted) or '(none)'}, must be links of '{xml.model.name}'; it is left out"
    )
    return None


def parse_gripper(element: Element, model: ModelDescription, scope: str) -> None:
    """Read a <gripper> of a model into its description; an unusable one is a warning.

    Args:
        scope: prefix of the names of its model's links.
    """
    values = Values(element, f"gripper '{element.get('name')}' of '{model.name}'")
    palm = scope + values.text("palm_link")
    named = [scope + (node.text or "").strip() for node in element.findall("gripper_link")]
    fingers = tuple(name for name in named if name in model.links)
    if palm not in model.links or not fingers:
        model.warn(
            f"{values.label} has palm_link '{palm}' and the gripper_links {', '.join(named)}, must "
            "be links of the model; it is left out",
            "grippers name links that do not exist and are left out",
            values.label,
        )
        return
    least, attach, detach = (
        int(values.number(f"grasp_check/{tag}", default))
        for tag, default in (("min_contact_count", 2), ("attach_steps", 20), ("detach_steps", 40))
    )
    name = element.get("name") or "gripper"
    model.sensors.append(GripperSpec(name, palm, fingers, least, attach, detach))

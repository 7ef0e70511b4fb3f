"""Grippers that hold what they press from opposite sides, of plugins and of <gripper>."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any, ClassVar, Dict, NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from bullet_sim.description.model import EVERYTHING, ModelDescription
from bullet_sim.engine import BodyLink
from bullet_sim.parts.base import Acting, part_of
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import PluginSpec, number, read, reading, switch
from bullet_sim.plugins.xml import MissingPart, PluginXml, Values
from bullet_sim.pose import Array, Pose


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


WEAKEST = 1e-4  # [N] of a force that counts
RATIO = 0.3  # of the weaker of two opposite forces to the other


class Touch(NamedTuple):
    """Sums over the steps in which a gripper's link touched an object.

    Attributes:
        force: on the object (3,) [N], world axes.
        point, center: of the contact and of the object, in the link's frame (3,) [m].
        steps: their number.
    """

    force: Array
    point: Array
    center: Array
    steps: int


Touches = Dict[BodyLink, Dict[BodyLink, Touch]]  # object -> link of a gripper -> sums


class Grasping(Acting):
    """Attaches objects, by decisions in simulated time."""

    STATE: ClassVar[tuple[str, ...]] = ("_next",)

    def reset(self, time: float) -> None:
        """With nothing held."""
        self._next = time
        super().reset(time)

    def restart(self, time: float) -> None:
        """Decisions go on from this time."""
        self._next = time
        super().restart(time)

    def _is_due(self, time: float, period: float) -> bool:
        """Whether a decision is to be made now; the next one is a period [s] later."""
        is_due = time >= self._next - 1e-9
        if is_due:
            self._next = time + period
        return is_due

    def _frame(self, part: BodyLink) -> Pose:
        return Pose(*self.world.engine.bodies[part[0]].link_motion(part[1])[:2])


@part_of(GraspFixSpec)
class GraspFixPlugin(Grasping):
    """Counts for each object how often it is pressed from opposite sides, attaches it to the palm,
    and lets it go when it is not pressed any more and a finger has left it: as GazeboGraspFix.

    Objects are links, upstream collisions; decisions are made in simulated time, upstream in that
    of the clock on the wall. Its grasp events are topics of Gazebo's own transport.
    """

    STATE = ("_touches", "_counts", "_held", "_first")

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._held: dict[str, BodyLink] = {}  # by the arm's name
        self._fingers = {
            (self.model.body.number, self.model.link_in_body(name)[0]): arm
            for arm in self.spec.arms
            for name in arm.fingers
        }

    def reset(self, time: float) -> None:
        """With nothing held."""
        for arm in list(self._held):
            self.world.engine.detach(self._key(arm))
        self._touches: Touches = {}
        self._counts: dict[BodyLink, int] = {}
        self._held = {}
        self._first: dict[str, dict[BodyLink, Touch]] = {}  # of what each arm holds
        super().reset(time)

    def _key(self, arm: str) -> tuple[str, str, str]:
        return "grasp_fix", self.model.name, arm

    def _parts(self) -> Iterator[tuple[BodyLink, GraspingArm]]:
        """Links of the grippers, also after a reload."""
        for (_, link), arm in self._fingers.items():
            yield (self.model.body.number, link), arm

    def update(self, time: float, period: float) -> None:
        for part, _ in self._parts():
            self._note(part)
        rate = self.spec.decisions
        if not self._is_due(time, 1.0 / rate if rate else 0.0):
            return
        touches, self._touches = self._touches, {}
        gripped = {item for item, of_links in touches.items() if self._is_pressed(of_links)}
        for item in sorted(gripped):
            self._grip(item, touches[item])
        self._loosen(gripped)

    def _note(self, part: BodyLink) -> None:
        """Add what a link touches."""
        bodies = self.world.engine.bodies
        touched: dict[BodyLink, list[Any]] = {}
        for contact in self.model.body.contacts(part[1]):
            if contact.body != part[0] and bodies[contact.body].moves:
                touched.setdefault((contact.body, contact.link), []).append(contact)
        for item, contacts in touched.items():
            inward = self._frame(part).inverse()
            force = -np.mean([contact.force for contact in contacts], axis=0)
            place = np.mean([contact.position for contact in contacts], axis=0)
            point = np.array((inward * Pose(tuple(place))).position)
            center = np.array((inward * self._frame(item)).position)
            old = self._touches.setdefault(item, {}).get(part)
            if old is not None:
                force, point, center = force + old.force, point + old.point, center + old.center
            count = 1 if old is None else old.steps + 1
            self._touches[item][part] = Touch(force, point, center, count)

    def _is_pressed(self, of_links: dict[BodyLink, Touch]) -> bool:
        """Whether two of the mean forces on an object are opposite, and about as strong."""
        forces = [touch.force / touch.steps for touch in of_links.values()]
        for one, two in combinations(forces, 2):
            lengths = float(np.linalg.norm(one)), float(np.linalg.norm(two))
            if min(lengths) < WEAKEST or min(lengths) < RATIO * max(lengths):
                continue
            cosine = float(one @ two) / (lengths[0] * lengths[1])
            if math.acos(max(-1.0, min(1.0, cosine))) > self.spec.angle:
                return True
        return False

    def _grip(self, item: BodyLink, of_links: dict[BodyLink, Touch]) -> None:
        """Count a pressed object, and attach it above the threshold."""
        self._counts[item] = min(self._counts.get(item, 0) + 1, self.spec.most)
        if self._counts[item] <= self.spec.threshold or item in self._held.values():
            return
        arms = dict(self._parts())
        touching = [arms[part].name for part in of_links]
        name = max(sorted(set(touching)), key=touching.count)
        if name in self._held:
            text = f"grasp_fix: gripper '{name}' holds another object already"
            self.log_error(text, every=5.0)
            return
        palm = next(arm.palm for arm in self.spec.arms if arm.name == name)
        own = self.model.body.number, self.model.link_in_body(palm)[0]
        self.world.engine.attach(self._key(name), own, item)
        if self.spec.passes:
            self.world.engine.bodies[item[0]].set_bitmask(item[1], 0)
        self._held[name] = item
        self._first[name] = {
            part: touch for part, touch in of_links.items() if arms[part].name == name
        }
        self.log_info(f"grasp_fix: {self._label(item)} is attached to gripper '{name}'")

    def _loosen(self, gripped: set[BodyLink]) -> None:
        """Count objects that are not pressed down, and let go those that a finger has left."""
        for item in [item for item in self._counts if item not in gripped]:
            self._counts[item] = max(0, self._counts[item] - 1)
            if self._counts[item] > self.spec.threshold:
                continue
            for name in [name for name, held in self._held.items() if held == item]:
                first = self._first[name].items()
                if any(self._has_left(part, item, touch) for part, touch in first):
                    self._let_go(name, item)

    def _has_left(self, part: BodyLink, item: BodyLink, touch: Touch) -> bool:
        """Whether the distance between a link's contact point and the object has changed."""
        point, center = touch.point / touch.steps, touch.center / touch.steps
        now = np.array((self._frame(part) * Pose(tuple(point))).position)
        away = np.linalg.norm(now - np.array(self._frame(item).position))
        return bool(abs(np.linalg.norm(point - center) - away) > self.spec.tolerance)

    def _let_go(self, name: str, item: BodyLink) -> None:
        self.world.engine.detach(self._key(name))
        if self.spec.passes:
            self.world.engine.bodies[item[0]].set_bitmask(item[1], EVERYTHING)
        del self._held[name], self._first[name]
        self._counts[item] = 0
        self.log_info(f"grasp_fix: {self._label(item)} is let go by gripper '{name}'")

    def _label(self, part: BodyLink) -> str:
        names = [model.name for model in self.world.models.values() if model.body.number == part[0]]
        return f"'{names[0]}'" if names else "an object"


GRIPPER_PERIOD = 0.75  # [s] between two decisions
SAMPLES = 10  # decisions over which an object has to rest
RESTS = 1e-5  # [m^2] of a square of a distance, and of its variance


@part_of(GripperSpec)
class GripperPlugin(Grasping):
    """Attaches an object to the palm that its links touch for long enough and that rests relative
    to it, until they touch nothing for long enough: as Gazebo's physics::Gripper.

    Decisions are made in simulated time, Gazebo's in that of the clock on the wall.
    """

    STATE = ("_contacts", "_touching", "_away", "_held", "_last", "_moves")

    def reset(self, time: float) -> None:
        """With nothing held."""
        self.world.engine.detach(self._key())
        self._contacts: list[BodyLink] = []  # what was touched, once for each step and link
        self._touching = self._away = 0
        self._held = False
        self._last: tuple[float, ...] = (0.0, 0.0, 0.0)
        self._moves: tuple[float, ...] = (math.inf,) * SAMPLES
        super().reset(time)

    def _key(self) -> tuple[str, str, str]:
        return "gripper", self.model.name, self.spec.name

    def update(self, time: float, period: float) -> None:
        bodies, body = self.world.engine.bodies, self.model.body
        for name in self.spec.fingers:
            touched = body.contacts(self.model.link_in_body(name)[0])
            parts = {(contact.body, contact.link) for contact in touched}
            self._contacts += sorted(
                part for part in parts if part[0] != body.number and bodies[part[0]].moves
            )
        if not self._is_due(time, GRIPPER_PERIOD):
            return
        if len(self._contacts) >= self.spec.least:
            self._touching, self._away = self._touching + 1, 0
        else:
            self._touching, self._away = max(0, self._touching - 1), self._away + 1
        if self._touching > self.spec.attach and not self._held:
            self._attach()
        elif self._away > self.spec.detach and self._held:
            self.world.engine.detach(self._key())
            self._held = False
        self._contacts = []

    def _attach(self) -> None:
        """Attach what rests relative to the palm."""
        engine = self.world.engine
        palm = self.model.body.number, self.model.link_in_body(self.spec.link)[0]
        for part in sorted(set(self._contacts)):
            if self._contacts.count(part) < 2 or self._held:
                continue
            place = (self._frame(palm).inverse() * self._frame(part)).position
            moved = sum((a - b) ** 2 for a, b in zip(place, self._last))
            self._last, self._moves = place, (*self._moves[1:], moved)
            if max(self._moves) < RESTS and float(np.var(self._moves)) < RESTS:
                engine.attach(self._key(), palm, part)
                self._held = True

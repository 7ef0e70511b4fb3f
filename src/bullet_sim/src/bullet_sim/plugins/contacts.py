"""Bumpers: the contacts of collision shapes."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Tuple

import numpy as np

from bullet_sim.parts.base import Sensor, part_of
from bullet_sim.parts.outputs import ContactsOutput
from bullet_sim.parts.schedule import Schedule
from bullet_sim.plugins.registry import sensor_plugin
from bullet_sim.plugins.rules import PLAIN
from bullet_sim.plugins.spec import PluginSpec, frame_of, rate_of, reading, topic_of
from bullet_sim.plugins.xml import SensorXml
from bullet_sim.pose import UNTURNED, Array, Pose, Quat, Vec3, matrix_from_quaternion
from bullet_sim.sensors.contact import nearest, watched

if TYPE_CHECKING:
    from bullet_sim.engine.api import BodyLink, ContactRows
    from bullet_sim.models.model import Model


def _collisions(xml: SensorXml) -> tuple[str, ...]:
    """As sdformat: the name that it gives where there is none is that of no collision."""
    named = [(element.text or "").strip() for element in xml.sensor.findall("contact/collision")]
    return tuple(filter(None, named or ["__default__"]))


@sensor_plugin("gazebo_ros_bumper", types=("contact",), rule=PLAIN)
@dataclass(frozen=True)
class ContactSpec(PluginSpec):
    """A bumper: contacts of some collision shapes.

    Attributes:
        collisions: names of the monitored collisions in Gazebo, of the link that the sensor is in
            there; empty: all of `link` in the file.
        rate: messages per simulated second [Hz]; 0: every physics step.
    """

    collisions: tuple[str, ...] = reading(_collisions, ())
    rate: float = rate_of(None)
    topic: str = topic_of("bumperTopicName", "bumper_states")
    frame_id: str = frame_of("frameName", "world")


MOST_STEPS = 100  # whose contacts Gazebo keeps for a message


class ContactPair(NamedTuple):
    """Contacts of a pair of shapes in a step.

    Attributes:
        time: [s].
        first, second: model::link::collision of the shapes.
        wrenches: (n, 6) force [N] and torque [N m] of each contact.
        total: (6,) their sum.
        positions, normals: (n, 3) of each contact in the world [m].
        depths: (n,) of each contact [m].
        back: (n, 6) wrenches on the second shape's link about its center of mass, in its axes;
            None: one of the two never moves, or the reader does not tell them.
    """

    time: float
    first: str
    second: str
    wrenches: Array
    total: Array
    positions: Array
    normals: Array
    depths: Array
    back: Array | None = None


Frame = Tuple[Quat, Vec3]  # orientation of a link, the center of mass [m] of the same or another


class ContactRecord(NamedTuple):
    """What is needed of a pair of shapes in a step for its ContactPair.

    Attributes:
        time, first, second: see ContactPair.
        numbers: of the contacts, seen from the reader's link: see engine.api.ContactRows.
        is_first, pushes: whether the reader's link is the first one, and whether the wrenches are
            those on it.
        frame: the axes of the wrenches and what they are about.
        back: likewise of ContactPair.back; None: it is not told.
    """

    time: float
    first: str
    second: str
    numbers: Array
    is_first: bool
    pushes: bool
    frame: Frame
    back: Frame | None


class ContactReader:
    """Contacts of some collision shapes of a link, by the pairs of shapes that touch.

    Args:
        model, link: whose.
        monitored: names of the shapes, model::link::collision.
        tells_back: also the wrenches on the second shapes, which a bumper does not have.
    """

    def __init__(
        self,
        world: Any,
        model: Model,
        link: str,
        monitored: set[str],
        tells_back: bool = False,
    ) -> None:
        self._world, self._model, self._monitored = world, model, monitored
        self._tells_back = tells_back
        self._part = model.link_in_body(link)[0]
        self._names: dict[tuple[Model, str], str] = {}  # of links with one shape
        self._models: dict[int, Model] = {}  # by the numbers of their bodies

    def pairs(self, time: float) -> list[ContactPair]:
        """Those of the last step."""
        return contact_pairs(self.record(time))

    def record(self, time: float) -> list[ContactRecord]:
        """Those of the last step, for contact_pairs()."""
        if not self._monitored:
            return []
        rows = self._model.body.contact_rows(self._part)
        groups: dict[tuple[str, str], list[int]] = {}
        for place, (other, is_first) in enumerate(zip(rows.others, rows.firsts)):
            mine = self._names.get((self._model, self._part)) or self._named(
                self._model, self._part, rows.numbers[place, :3]
            )
            if mine in self._monitored:
                names = mine, self._other(other, rows.numbers[place, :3])
                groups.setdefault(names if is_first else names[::-1], []).append(place)
        return [self._record(time, names, rows, chosen) for names, chosen in groups.items()]

    def _named(self, model: Model, part: str, position: Array) -> str:
        """model::link::collision of the shape that a point in the world is on."""
        if (model, part) in self._names:
            return self._names[model, part]
        shapes = model.rigid_parts[part].collisions
        if not shapes:
            return f"{model.name}::{part}::collision"
        shape = shapes[0]
        if len(shapes) > 1:
            pose = Pose(*model.body.link_motion(part)[:2])
            local = pose.matrix.T @ (position - np.asarray(pose.position))
            shape = nearest(shapes, local) or shape
        plain = f"{shape.link or part}::{shape.name or 'collision'}"
        name = f"{model.name}::{model.collision_names.get((shape.link, shape.number), plain)}"
        if len(shapes) == 1:
            self._names[model, part] = name
        return name

    def _model_of(self, body: int) -> Model | None:
        model = self._models.get(body)
        if model is None or model.body.number != body or model not in self._known():
            self._models = {each.body.number: each for each in self._known()}
            model = self._models.get(body)
        return model

    def _known(self) -> Any:
        return self._world.models.values()

    def _other(self, other: BodyLink, position: Array) -> str:
        model = self._model_of(other[0])
        return "world" if model is None else self._named(model, other[1], position)

    def _record(
        self, time: float, names: tuple[str, str], rows: ContactRows, chosen: list[int]
    ) -> ContactRecord:
        """Of the contacts of a pair of shapes."""
        is_first, (number, link) = rows.firsts[chosen[0]], rows.others[chosen[0]]
        own, other = (self._model, self._part), (self._model_of(number), link)
        first, second = (own, other) if is_first else (other, own)
        pushed = second if first[0] is None or first[0].is_static else first
        axes = UNTURNED if first[0] is None else first[0].body.link_motion(first[1])[1]
        about = pushed[0] or self._model
        center = about.body.link_center(self._part if pushed[0] is None else pushed[1])
        back, model = None, second[0]
        if self._tells_back and pushed is first and model is not None and not model.is_static:
            back = model.body.link_motion(second[1])[1], model.body.link_center(second[1])
        return ContactRecord(
            time,
            *names,
            rows.numbers if len(chosen) == len(rows.others) else rows.numbers[chosen],
            is_first,
            pushed is own,
            (axes, center),
            back,
        )


def contact_pairs(records: Sequence[ContactRecord]) -> list[ContactPair]:
    """The ContactPair of each record."""
    if not records:
        return []
    counts = [len(record.numbers) for record in records]
    starts = [0, *itertools.accumulate(counts)]
    numbers = np.concatenate([record.numbers for record in records])
    is_first, pushes = (
        np.repeat(np.where(flags, 1.0, -1.0), counts)[:, None]
        for flags in ([each.is_first for each in records], [each.pushes for each in records])
    )
    positions, normals = numbers[:, :3], is_first * numbers[:, 3:6]
    forces = pushes * numbers[:, 7:]
    wrenches = _wrenches([record.frame for record in records], counts, positions, forces)
    if len(set(counts)) == 1:
        totals = np.add.reduce(wrenches.reshape(len(counts), -1, 6), 1, initial=0.0)
    else:
        parts = (wrenches[begin:end] for begin, end in zip(starts, starts[1:]))
        totals = np.array([np.add.reduce(part, 0, initial=0.0) for part in parts])
    pairs = []
    for record, total, begin, end in zip(records, totals, starts, starts[1:]):
        own, back = slice(begin, end), None
        if record.back is not None:
            back = _wrenches([record.back], [end - begin], positions[own], -forces[own])
        places = wrenches[own], total, positions[own], normals[own], numbers[own, 6]
        pairs.append(ContactPair(*record[:3], *places, back))
    return pairs


def _wrenches(
    frames: Sequence[Frame], counts: Sequence[int], positions: Array, forces: Array
) -> Array:
    """Wrenches (n, 6) of forces (n, 3) [N] at positions (n, 3) [m] of the world in frames, each of
    which is that of as many as `counts` says."""
    turned = matrix_from_quaternion(np.array([orientation for orientation, _ in frames]).T)
    rotations = np.repeat(turned.transpose(2, 0, 1), counts, axis=0).transpose(0, 2, 1)
    centers = np.repeat(np.array([center for _, center in frames]), counts, axis=0)
    (x, y, z), (u, v, w) = (positions - centers).T, forces.T
    vectors = np.stack((forces, np.stack((y * w - z * v, z * u - x * w, x * v - y * u), 1)), 1)
    return (rotations[:, None] @ vectors[..., None]).reshape(-1, 6)


@part_of(ContactSpec)
class ContactSensor(Sensor):
    """Contacts of the monitored shapes in all steps since the last message, oldest first.

    A state is of a pair of shapes in a step. As in Gazebo: which shape is the first depends on
    their models' sizes and ages, not on the sensor; positions and normals are in the world,
    wrenches in the axes of the first shape's link: those on this link about its center of mass,
    or, if it never moves, those on the other link about that one's.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_steps", "_messages")
    CACHE: ClassVar[tuple[str, ...]] = ("_reader",)
    every_step = whole_periods = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        model, spec, world = self.model, self.spec, self.world
        names, missing = watched(spec, model.description)
        monitored = {f"{model.name}::{name}" for name in names}
        self._reader = ContactReader(world, model, spec.link, monitored)
        if missing:
            self.log_warning(
                f"contact sensor '{spec.name}' of '{model.name}' tells nothing of "
                f"{', '.join(missing)}, as in Gazebo: collisions are "
                f"{', '.join(model.collision_names.values()) or '(none)'}"
            )
        self._steps: deque[list[ContactRecord]] = deque(maxlen=MOST_STEPS)
        self._messages = Schedule(self.nominal_rate, world.time_step, world.step_count)

    def make_output(self) -> ContactsOutput:
        return ContactsOutput(self.spec.topic, self.spec.frame_id)

    def start(self, time: float) -> None:
        """Collect from now on."""
        self._steps.clear()
        self._messages.restart(self.world.step_count)

    def on_time_step(self) -> None:
        """Continue after a change of the physics step."""
        super().on_time_step()
        step = self.world.time_step
        self._messages.set_step(step, self.nominal_rate, self.world.step_count)

    def update(self, time: float, period: float) -> None:
        self._steps.append(self._reader.record(time))
        if self._messages.due(self.world.step_count):
            self._sender.send(time, contact_pairs([each for step in self._steps for each in step]))
            self._steps.clear()

    def is_message(self, step: int) -> bool:
        """At its rate."""
        return step >= self._messages.next

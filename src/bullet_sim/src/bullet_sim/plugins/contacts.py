"""Bumpers: the contacts of collision shapes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from bullet_sim.parts.base import Sensor, part_of
from bullet_sim.parts.outputs import ContactsOutput
from bullet_sim.parts.schedule import Schedule
from bullet_sim.plugins.registry import sensor_plugin
from bullet_sim.plugins.rules import PLAIN
from bullet_sim.plugins.spec import PluginSpec, frame_of, rate_of, reading, topic_of
from bullet_sim.plugins.xml import SensorXml
from bullet_sim.pose import Array, Pose
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
        # called before poses of bodies are read; contacts alone may be those of an earlier step
        self.before_poses: Callable[[], None] = lambda: None

    def are_recorded(self) -> bool:
        """Whether contacts are recorded with steps."""
        return self._model.body.records_contacts(self._part)

    def pairs(self, time: float) -> list[ContactPair]:
        """Those of the last step."""
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
        return [self._pair(time, names, rows, chosen) for names, chosen in groups.items()]

    def _named(self, model: Model, part: str, position: Array) -> str:
        """model::link::collision of the shape that a point in the world is on."""
        if (model, part) in self._names:
            return self._names[model, part]
        shapes = model.rigid_parts[part].collisions
        if not shapes:
            return f"{model.name}::{part}::collision"
        shape = shapes[0]
        if len(shapes) > 1:
            self.before_poses()
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
        known = self._world.models
        if model is None or model.body.number != body or known.get(model.name) is not model:
            self._models = {each.body.number: each for each in known.values()}
            model = self._models.get(body)
        return model

    def _other(self, other: BodyLink, position: Array) -> str:
        model = self._model_of(other[0])
        return "world" if model is None else self._named(model, other[1], position)

    def _pair(
        self, time: float, names: tuple[str, str], rows: ContactRows, chosen: list[int]
    ) -> ContactPair:
        """Of the contacts of a pair of shapes."""
        is_first, (number, link) = rows.firsts[chosen[0]], rows.others[chosen[0]]
        own, other = (self._model, self._part), (self._model_of(number), link)
        first, second = (own, other) if is_first else (other, own)
        pushed = second if first[0] is None or first[0].is_static else first
        numbers, wrenches = rows.numbers, rows.wrenches
        if len(chosen) < len(numbers):
            numbers = numbers[chosen]
            wrenches = None if wrenches is None else wrenches[chosen]
        forces = numbers[:, 7:10] if pushed is own else -numbers[:, 7:10]
        if wrenches is None or first is not own or pushed is not own:
            wrenches = self._wrenches(first, pushed, numbers[:, :3], forces)
        back, model = None, second[0]
        if self._tells_back and pushed is first and model is not None and not model.is_static:
            back = self._wrenches(second, second, numbers[:, :3], -forces)
        return ContactPair(
            time,
            *names,
            wrenches,
            np.add.reduce(wrenches, 0, initial=0.0),
            numbers[:, :3],
            numbers[:, 3:6] if is_first else -numbers[:, 3:6],
            numbers[:, 6],
            back,
        )

    def _wrenches(self, axes: Any, about: Any, positions: Array, forces: Array) -> Array:
        """Wrenches (n, 6) of forces (n, 3) [N] at positions (n, 3) [m] of the world, in the axes of
        one link about the center of mass of another."""
        self.before_poses()
        rotation = np.eye(3)
        if axes[0] is not None:
            rotation = Pose(*axes[0].body.link_motion(axes[1])[:2]).matrix.T
        center = (about[0] or self._model).body.link_center(about[1])
        (x, y, z), (u, v, w) = (positions - center).T, forces.T
        vectors = np.stack((forces, np.stack((y * w - z * v, z * u - x * w, x * v - y * u), 1)), 1)
        return (rotation @ vectors[..., None]).reshape(-1, 6)


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
    tells_velocities = False

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
        self._steps: deque[list[ContactPair]] = deque(maxlen=MOST_STEPS)
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

    @property
    def watches(self) -> bool:  # type: ignore[override]
        """Where contacts are recorded with steps."""
        return self._reader.are_recorded()

    def update(self, time: float, period: float) -> None:
        self._collect(time, self.world.step_count)

    def _collect(self, time: float, step: int) -> bool:
        """Add the contacts of a step; whether there was a message."""
        self._steps.append(self._reader.pairs(time))
        if not self._messages.due(step):
            return False
        self._sender.send(time, [pair for step in self._steps for pair in step])
        self._steps.clear()
        return True

    def recorded(self) -> Any:
        return True

    def update_recorded(self, recorded: Any, steps: Sequence[int]) -> int:
        world, reader, sent = self.world, self._reader, 0
        try:
            for step, time in zip(steps, world.times(steps)):
                world.show_contacts(step)
                reader.before_poses = partial(world.show, step)
                sent += self._collect(time, step)
        finally:
            reader.before_poses = lambda: None
            world.show_end()
        return sent

    def is_message(self, step: int) -> bool:
        """At its rate."""
        return step >= self._messages.next

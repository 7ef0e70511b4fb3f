"""Topics about the full world: states of models and links, and performance."""

from __future__ import annotations

import itertools
import time as wall
from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, Any

from bullet_sim.models.model import Model
from bullet_sim.parts.schedule import NEVER, SubscribedSchedule
from bullet_sim.pose import Motion
from gazebo_msgs.msg import LinkStates, ModelStates, PerformanceMetrics, SensorPerformanceMetric

from bullet_bridge.transport.conversions import header
from bullet_bridge.transport.packed import PackedStates
from bullet_bridge.transport.publishing import publisher

if TYPE_CHECKING:
    from bullet_sim.world import World

AT_REST = (0.0, 0.0, 0.0)
METRICS_PERIOD = 0.2  # [s] wall time


def _outermost(model: Model, of_bodies: Sequence[Any]) -> Sequence[Any]:
    """Of what there is of each body what is of no model inside a model."""
    if not model.description.nested:
        return of_bodies
    scope = model.description.scope_of
    return [of_body for body, of_body in zip(model.bodies, of_bodies) if not scope(body)]


def link_names(model: Model) -> list[str]:
    """Names in link_states: of the links that Gazebo has, but for those of models inside it."""
    return [f"{model.name}::{link}" for link in _outermost(model, model.bodies)]


class StateTopic:
    """One of the topics about all models.

    Args:
        message_type: ModelStates or LinkStates.
    """

    def __init__(self, topic: str, message_type: type) -> None:
        self.publisher = publisher(topic, message_type)
        self._of_links = message_type is LinkStates
        self._models: list[Model] = []
        self._sender = PackedStates(self.publisher, [])

    def _motions(self, model: Model) -> Sequence[Motion]:
        if self._of_links:
            return _outermost(model, model.body_motions())
        if model.is_static:
            return [(*model.body.pose(), AT_REST, AT_REST)]
        return [model.motion()]

    def publish(self, world: World) -> None:
        models = self._present(world)
        self._sender.send([motion for model in models for motion in self._motions(model)])

    def _present(self, world: World) -> list[Model]:
        """The world's models, whose names are in the messages."""
        models = list(world.models.values())
        if models != self._models:
            self._models = models
            names = [link_names(model) if self._of_links else [model.name] for model in models]
            self._sender = PackedStates(self.publisher, [*itertools.chain(*names)])
        return models

    def publish_recorded(self, world: World, motions: Sequence[Any], steps: Sequence[int]) -> None:
        """Publish after recorded steps.

        Args:
            motions: of each model, of it and of its bodies, see Model.recorded_motions().
        """
        chosen: list[Any] = []
        for model, (of_model, *of_bodies) in zip(self._present(world), motions):
            chosen += _outermost(model, of_bodies) if self._of_links else [of_model]
        self._sender.send_states(chosen, len(steps), world.recorded(steps))


class StateTopics:
    """The topics model_states and link_states.

    Args:
        prefix: of the topic names.
        rate: [Hz] of simulated time, limited to one message per step; 0: one per step.
    """

    watches = True

    def __init__(self, prefix: str, world: World, rate: float) -> None:
        self._world, self._rate = world, rate
        self._topics = [
            StateTopic(f"{prefix}/model_states", ModelStates),
            StateTopic(f"{prefix}/link_states", LinkStates),
        ]
        self.restart()

    @property
    def period(self) -> float:
        """Of the schedule [steps]."""
        return self._schedule.period

    def restart(self) -> None:
        """Restart the schedule, after a reset or a change of the physics step."""
        step = self._world.time_step
        fastest = 1.0 / step
        self._schedule = SubscribedSchedule(
            min(self._rate or fastest, fastest), step, self._world.step_count, self._subscribed
        )

    def _subscribed(self) -> list[StateTopic]:
        return [topic for topic in self._topics if topic.publisher.get_num_connections() > 0]

    def next_due(self) -> int:
        """Physics step after which a message is due; infinity without subscribers."""
        return self._schedule.next_due_subscribed(self._world.step_count)

    def publish_recorded(self, end: int) -> None:
        """See loop.server.Reporter."""
        topics = self._subscribed()
        if not topics or self._schedule.next >= end:
            return
        motions = [model.recorded_motions() for model in self._world.models.values()]
        if None in motions:
            return
        steps = self._schedule.due_before(end)
        for topic in topics:
            topic.publish_recorded(self._world, motions, steps)

    def publish(self, step: int, _time: float) -> None:
        """Publish what is due and has subscribers."""
        if self._schedule.due(step):
            for topic in self._subscribed():
                topic.publish(self._world)


class PerformanceTopic:
    """performance_metrics: real time factor and sensor rates, about 5 times a wall second.

    Args:
        prefix: of the topic's name.
        counts: function -> {sensor name: messages so far}.
        clock: function -> wall time [s].
        cameras: function -> names of the cameras among them; the fps of others is -1, as upstream.
    """

    watches, period = False, NEVER

    def __init__(
        self,
        prefix: str,
        world: World,
        counts: Callable[[], dict[str, int]],
        clock: Callable[[], float] = wall.monotonic,
        cameras: Callable[[], Collection[str]] = tuple,
    ) -> None:
        self._world, self._counts, self._clock = world, counts, clock
        self._cameras = cameras
        self._topic = publisher(f"{prefix}/performance_metrics", PerformanceMetrics)
        self.restart()

    def restart(self) -> None:
        self._since = (self._clock(), self._world.time, dict(self._counts()))

    def next_due(self) -> int:
        """Infinity: it never ends a batch of steps."""
        return NEVER

    def publish_recorded(self, end: int) -> None:
        """Nothing."""

    def publish(self, _step: int, time: float) -> None:
        """Publish after METRICS_PERIOD of wall time if there are subscribers."""
        now = self._clock()
        start, sim_start, before = self._since
        if now - start < METRICS_PERIOD:
            return
        counts = dict(self._counts())
        self._since = (now, time, counts)
        if self._topic.get_num_connections() == 0 or time <= sim_start:
            return
        factor = (time - sim_start) / (now - start)
        message = PerformanceMetrics(header=header(time), real_time_factor=factor)
        cameras = self._cameras()
        for name, count in counts.items():
            count -= before.get(name, 0)
            message.sensors.append(
                SensorPerformanceMetric(
                    name=name,
                    sim_update_rate=count / (time - sim_start),
                    real_update_rate=count / (now - start),
                    fps=count / (now - start) if name in cameras else -1.0,
                )
            )
        self._topic.publish(message)

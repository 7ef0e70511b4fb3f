"""Topics about the full world: states of models and links, and performance."""

import time as wall
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import rospy
from gazebo_msgs.msg import LinkStates, ModelStates, PerformanceMetrics, SensorPerformanceMetric

from bullet_bridge.loop.clock import NEVER, SubscribedSchedule
from bullet_bridge.transport.conversions import header, pose_to_msg, twist_to_msg
from bullet_bridge.transport.publishing import publisher

if TYPE_CHECKING:
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

METRICS_PERIOD = 0.2  # [s] wall time


def model_states(world: "World") -> ModelStates:
    """gazebo_msgs/ModelStates of all models, by their root links."""
    message = ModelStates()
    for model in world.models.values():
        _add(message, model.name, model, model.description.root)
    return message


def link_states(world: "World") -> LinkStates:
    """gazebo_msgs/LinkStates of all links but those that fixed joints merge into others."""
    message = LinkStates()
    for model in world.models.values():
        for link in model.rigid_parts:
            _add(message, f"{model.name}::{link}", model, link)
    return message


def _add(message: Any, name: str, model: "Model", link: str) -> None:
    pose, linear, angular = model.link_state(link)
    if model.is_static:
        linear = angular = np.zeros(3)
    message.name.append(name)
    message.pose.append(pose_to_msg(pose))
    message.twist.append(twist_to_msg(linear, angular))


class StateTopics:
    """The topics model_states and link_states.

    Args:
        prefix: of the topic names.
        rate: [Hz] of simulated time, limited to one message per step.
    """

    def __init__(self, prefix: str, world: "World", rate: float) -> None:
        self._world, self._rate = world, rate
        self._topics = [
            (publisher(f"{prefix}/{name}", message_type), read)
            for name, message_type, read in (
                ("model_states", ModelStates, model_states),
                ("link_states", LinkStates, link_states),
            )
        ]
        self.restart()

    def restart(self) -> None:
        """Restart the schedule, after a reset or a change of the physics step."""
        step = self._world.time_step
        self._schedule = SubscribedSchedule(
            min(self._rate, 1.0 / step), step, self._world.step_count, self._subscribed
        )

    def _subscribed(self) -> "list[tuple[rospy.Publisher, Callable[[World], Any]]]":
        return [(topic, read) for topic, read in self._topics if topic.get_num_connections() > 0]

    def next_due(self) -> int:
        """Physics step after which a message is due; infinity without subscribers."""
        return self._schedule.next_due_subscribed(self._world.step_count)

    def publish(self, step: int, _time: float) -> None:
        """Publish what is due and has subscribers."""
        if self._schedule.due(step):
            for topic, read in self._subscribed():
                topic.publish(read(self._world))


class PerformanceTopic:
    """performance_metrics: real time factor and sensor rates, about 5 times a wall second.

    Args:
        prefix: of the topic's name.
        counts: function -> {sensor name: messages so far}.
        clock: function -> wall time [s].
    """

    def __init__(
        self,
        prefix: str,
        world: "World",
        counts: Callable[[], dict[str, int]],
        clock: Callable[[], float] = wall.monotonic,
    ) -> None:
        self._world, self._counts, self._clock = world, counts, clock
        self._topic = publisher(f"{prefix}/performance_metrics", PerformanceMetrics)
        self.restart()

    def restart(self) -> None:
        self._since = (self._clock(), self._world.time, dict(self._counts()))

    def next_due(self) -> int:
        """Infinity: it never ends a batch of steps."""
        return NEVER

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
        for name, count in counts.items():
            count -= before.get(name, 0)
            message.sensors.append(
                SensorPerformanceMetric(
                    name=name,
                    sim_update_rate=count / (time - sim_start),
                    real_update_rate=count / (now - start),
                    fps=count / (now - start),
                )
            )
        self._topic.publish(message)

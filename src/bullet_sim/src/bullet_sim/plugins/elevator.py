"""A lift that goes to floors, and its door."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

from bullet_sim.parts.base import Part, part_of
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import (
    PluginSpec,
    number,
    read,
    topic_of,
)
from bullet_sim.plugins.xml import PluginXml


@dataclass(frozen=True)
class ElevatorSpec(PluginSpec):
    """libgazebo_ros_elevator: a lift that goes to floors, and its door.

    Attributes:
        lift, door: joints.
        height: of a floor [m].
        wait: for which the door is open [s].
        topic: of std_msgs/String, the number of a floor.
    """

    NAME = "elevator"
    lift: str
    door: str
    height: float = number("floor_height", 3.0)
    wait: float = number("door_wait_time", 5.0)
    topic: str = topic_of("topic", "elevator")


@model_plugin("gazebo_ros_elevator")
def elevator(xml: PluginXml) -> ElevatorSpec:
    lift, door = xml.joint("lift_joint"), xml.joint("door_joint")
    return read(ElevatorSpec, xml, link=xml.model.joints[lift].child, lift=lift, door=door)


CLOSED, OPEN = 0.0, 1.0  # positions of a lift's door


LIFT_GAINS, DOOR_GAINS = (1e5, 1e5), (2.0, 1.0)  # P, D


LIFT_NEAR, DOOR_NEAR = 0.15, 0.05  # errors at which they count as there


@part_of(ElevatorSpec)
class ElevatorPlugin(Part):
    """Closes the door, goes to a floor, opens, waits and closes; meanwhile it takes no other floor.

    As upstream the derivative of the door's error is over the time since the start. It waits in
    simulated time.
    """

    STATE = ("_floor", "_door", "_steps", "_began", "_errors", "_there", "_until")
    COMMANDS = {"topic": ("std_msgs/String", "_on_floor")}
    every_step = True

    def reset(self, time: float) -> None:
        """As it was loaded, but for where it goes and whether its door is to be open."""
        self._floor: int = getattr(self, "_floor", 0)
        self._door: float = getattr(self, "_door", CLOSED)
        self._steps: tuple[tuple[str, int], ...] = ()  # that are to be made, each with a floor
        self._began = self._until = math.nan
        self._errors, self._there = (0.0, 0.0), (True, True)  # of the lift and the door
        super().reset(time)

    def _on_floor(self, message: Any) -> None:
        number = re.match(r"\s*([+-]?0*\d{1,10})(?!\d)", message.data)  # as C++ reads one
        floor = int(number[1]) if number else 1 << 31
        if not -(1 << 31) <= floor < 1 << 31:
            self.log_error(f"{self.spec.topic}: '{message.data:.80}' is no number of a floor")
            return
        if not self._steps:
            steps = ("close", "move", "open", "wait", "close")
            self._steps = tuple((step, floor) for step in steps)
            self._until = math.nan

    def update(self, time: float, period: float) -> None:
        if self._steps and self._is_done(time, *self._steps[0]):
            self._steps, self._until = self._steps[1:], math.nan
        if math.isnan(self._began):
            self._began = time
            return
        positions = self.model.joints.state()[0]
        lift = positions[self.spec.lift] - self._floor * self.spec.height
        door = positions[self.spec.door] - self._door
        step = self.world.time_step
        for joint, error, old, gains, elapsed in (
            (self.spec.lift, lift, self._errors[0], LIFT_GAINS, step),
            (self.spec.door, door, self._errors[1], DOOR_GAINS, time - self._began),
        ):
            effort = -gains[0] * error - gains[1] * (error - old) / elapsed
            self.model.joints.add_effort(joint, effort)
        self._errors = lift, door
        self._there = abs(lift) < LIFT_NEAR, abs(door) < DOOR_NEAR

    def _is_done(self, time: float, step: str, floor: int) -> bool:
        """Begin a step, or tell whether it is made."""
        if math.isnan(self._until):
            self._until = time + (self.spec.wait if step == "wait" else 0.0)
            if step == "move":
                self._floor = floor
            elif step != "wait":
                self._door = OPEN if step == "open" else CLOSED
            return False
        if step == "wait":
            return time >= self._until
        return self._there[0 if step == "move" else 1]

"""Opens and closes a gripper, as gripper_action_controller does."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from bullet_sim.controllers.base import register_variant
from bullet_sim.controllers.hardware import Hardware
from bullet_sim.controllers.pid import Pid, PidConfig
from bullet_sim.controllers.settings import Settings
from bullet_sim.controllers.trajectory import ActionControl
from bullet_sim.description.model import ModelDescription


@dataclass(frozen=True)
class GripperConfig(PidConfig):
    """Configuration of a gripper's controller.

    Attributes:
        tolerance: of the position at which a goal is reached [rad, m].
        max_effort: of the command that holds the start [N m, N].
        stall_speed: below which it does not move [rad/s, m/s].
        stall_timeout: without movement after which a goal is given up [s].
    """

    tolerance: float = 0.01
    max_effort: float = 0.0
    stall_speed: float = 0.001
    stall_timeout: float = 1.0


@dataclass(eq=False)
class GripperGoal:
    """A goal of the action.

    Attributes:
        position: [rad, m].
        max_effort: [N m, N].
        finished: called once with (outcome, Grip): "succeeded", "aborted" or "canceled".
    """

    position: float
    max_effort: float
    finished: Callable[[str, Grip], object]


@dataclass(frozen=True)
class Grip:
    """What the gripper does: position [rad, m], effort [N m, N], whether it stalled or arrived."""

    position: float = 0.0
    effort: float = 0.0
    stalled: bool = False
    reached_goal: bool = False


class GripperControl(ActionControl):
    """Moves one joint to a goal's position; a goal ends when it is there or does not move on."""

    STATE = ("_position", "_max_effort", "_effort", "_moved", "pids")
    no_result = (Grip(),)

    @classmethod
    def configure(
        cls, settings: Settings, joints: tuple[str, ...], description: ModelDescription | None
    ) -> GripperConfig:
        names = (settings.joint("joint", joints),)
        warnings: list[str] = []
        rate = settings.number("action_monitor_rate", 20.0, above=0.0)
        return GripperConfig(
            name=settings.name,
            joints=names,
            claims=((cls.interface, names),),
            publish_rate=rate,
            **cls.pid_settings(settings, names, warnings),
            tolerance=abs(settings.number("goal_tolerance", 0.01)),
            max_effort=abs(settings.number("max_effort", 0.0)),
            stall_speed=settings.number("stall_velocity_threshold", 0.001),
            stall_timeout=settings.number("stall_timeout", 1.0),
            warnings=tuple(warnings),
        )

    def __init__(self, config: GripperConfig, hardware: Hardware) -> None:
        super().__init__(config, hardware)
        self.pids = tuple(Pid(gains) for gains in config.gains)
        self._position = self._max_effort = self._effort = 0.0
        self._moved: float | None = 0.0

    def start(self, time: float) -> None:
        """Hold the joint where it is, with the configured effort."""
        self._finish("canceled")
        for pid in self.pids:
            pid.reset()
        self._moved, self._effort = time, 0.0
        self._hold()

    def _hold(self) -> None:
        self.hardware.read()
        self._position, self._max_effort = self.joints[0].position, self.config.max_effort

    def go_back(self, by: float, since: float) -> None:
        """As Controller's: it has moved as much later."""
        if self._moved is not None:
            self._moved += by + since

    def execute(self, goal: GripperGoal) -> None:
        """Execute a goal; the one before is cancelled."""
        self._finish("canceled")
        self.goal, self._position, self._max_effort = goal, goal.position, goal.max_effort
        self._moved = None  # from the next update on

    def cancel(self, goal: GripperGoal) -> None:
        """Give a goal up: hold the joint where it is."""
        if goal is self.goal:
            self._hold()
            self._finish("canceled")

    def update(self, time: float, period: float) -> None:
        """Evaluate the goal, command the joint."""
        (joint,) = self.joints
        error = self._position - joint.position
        if self.goal is not None:
            self._evaluate(error, joint.position, joint.velocity, time)
        if self.interface == "position":
            joint.set_position(self._position)
            self._effort = self._max_effort
            return
        max_effort = abs(self._max_effort)
        effort = self.pids[0].update(error, period, 0.0 - joint.velocity)
        self._effort = min(max(effort, -max_effort), max_effort)
        joint.set_effort(self._effort)

    def _evaluate(self, error: float, position: float, velocity: float, time: float) -> None:
        config = self.config
        if self._moved is None or abs(velocity) > config.stall_speed:
            self._moved = time
        if abs(error) < config.tolerance:
            self._finish("succeeded", Grip(position, self._effort, reached_goal=True))
        elif time - self._moved > config.stall_timeout:
            self._finish("aborted", Grip(position, self._effort, stalled=True))


for _interface in ("position", "effort"):
    register_variant(
        f"{_interface}_controllers/GripperActionController", GripperControl, interface=_interface
    )


def check_goal(position: float, max_effort: float) -> str:
    """Why a goal cannot be executed, or ''."""
    if not (math.isfinite(position) and math.isfinite(max_effort)):
        return f"gripper goal is {position} with {max_effort}, must be finite numbers"
    return ""

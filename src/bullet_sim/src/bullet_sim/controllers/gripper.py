"""Opens and closes a gripper, as gripper_action_controller does."""

import math
from dataclasses import dataclass

from bullet_sim.controllers.joint import Controller
from bullet_sim.controllers.pid import Pid
from bullet_sim.controllers.trajectory import parse_gains


@dataclass(frozen=True)
class GripperConfig:
    """Configuration of a gripper's controller.

    Attributes:
        tolerance: of the position at which a goal is reached [rad, m].
        max_effort: of the command that holds the start [N m, N].
        stall_speed: below which it does not move [rad/s, m/s].
        stall_timeout: without movement after which a goal is given up [s].
        monitor_rate: of the action's result [Hz].
    """

    tolerance: float = 0.01
    max_effort: float = 0.0
    stall_speed: float = 0.001
    stall_timeout: float = 1.0
    monitor_rate: float = 20.0


def parse_gripper(settings, joints, regulated, warnings):
    """GripperConfig, and the joint's PidGains where its interface needs them.

    Raises:
        ControllerError: names the key, the value and what is valid.
    """
    config = GripperConfig(
        abs(settings.number("goal_tolerance", 0.01)),
        abs(settings.number("max_effort", 0.0)),
        settings.number("stall_velocity_threshold", 0.001),
        settings.number("stall_timeout", 1.0),
        settings.number("action_monitor_rate", 20.0, above=0.0),
    )
    settings.ignore("gains")
    return config, parse_gains(settings, joints, warnings) if regulated else ()


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
    finished: object


@dataclass(frozen=True)
class Grip:
    """What the gripper does: position [rad, m], effort [N m, N], whether it stalled or arrived."""

    position: float = 0.0
    effort: float = 0.0
    stalled: bool = False
    reached_goal: bool = False


class GripperControl(Controller):
    """Moves one joint to a goal's position; a goal ends when it is there or does not move on.

    Attributes:
        goal: the GripperGoal that is pursued, or None.
        pids: the Pid of a joint with efforts.
    """

    periodic = True

    def __init__(self, spec, hardware):
        super().__init__(spec, hardware)
        self.pids = tuple(Pid(gains) for gains in spec.gains)
        self.goal, self._position, self._max_effort = None, 0.0, 0.0
        self._effort, self._moved = 0.0, 0.0

    def start(self, time):
        """Hold the joint where it is, with the configured effort."""
        self._finish("canceled")
        for pid in self.pids:
            pid.reset()
        self._moved, self._effort = time, 0.0
        self._hold()

    def stop(self):
        """Cancel the goal and stop controlling."""
        self._finish("canceled")
        super().stop()

    def _hold(self):
        (self._position,) = self.hardware.positions_of(self.spec.joints)
        self._max_effort = self.spec.action.max_effort

    def pursue(self, goal):
        """Pursue a goal; the one before is cancelled."""
        self._finish("canceled")
        self.goal, self._position, self._max_effort = goal, goal.position, goal.max_effort
        self._moved = None  # from the next update on

    def cancel(self, goal):
        """Give a goal up: hold the joint where it is."""
        if goal is self.goal:
            self._hold()
            self._finish("canceled")

    def _finish(self, outcome, grip=Grip()):
        goal, self.goal = self.goal, None
        if goal is not None:
            goal.finished(outcome, grip)

    def update(self, state, time, period):
        """Judge the goal, command the joint."""
        (name,) = self.spec.joints
        position, velocity = (values[name] for values in state)
        error = self._position - position
        if self.goal is not None:
            self._judge(error, position, velocity, time)
        if self.spec.kind.interface == "position":
            self.hardware.positions(self.spec.joints, (self._position,))
            self._effort = self._max_effort
            return
        most = abs(self._max_effort)
        effort = self.hardware.regulate(
            name, self.pids[0], "position", error, velocity, period, 0.0, limit=most
        )
        self._effort = min(max(effort, -most), most)

    def _judge(self, error, position, velocity, time):
        config = self.spec.action
        if self._moved is None or abs(velocity) > config.stall_speed:
            self._moved = time
        if abs(error) < config.tolerance:
            self._finish("succeeded", Grip(position, self._effort, reached_goal=True))
        elif time - self._moved > config.stall_timeout:
            self._finish("aborted", Grip(position, self._effort, stalled=True))


def check_goal(position, max_effort):
    """Why a goal cannot be pursued, or ''."""
    if not (math.isfinite(position) and math.isfinite(max_effort)):
        return f"gripper goal is {position} with {max_effort}, must be finite numbers"
    return ""

"""A joint as the controllers of a robot see it: its state, and what they command."""

from __future__ import annotations

from math import inf, nan
from typing import Protocol

from bullet_sim.component import Stateful
from bullet_sim.controllers.limits import CommandLimits, JointLimits, Limiter, command_limits
from bullet_sim.controllers.pid import Pid, limits_of
from bullet_sim.description.model import Joint
from bullet_sim.engine.api import Motor
from bullet_sim.engine.efforts import EffortRow
from bullet_sim.engine.quickstep import law


class Robot(Protocol):
    """What a joint needs of its robot, see hardware.Hardware."""

    is_stopped: bool
    limited: dict[str, JointHandle]  # whose commands limits hold step by step

    def list_acting(self) -> None: ...
    def release(self, names: tuple[str, ...]) -> None: ...


class JointHandle(Stateful):
    """A joint: its state, as of the last Hardware.read(), and its command.

    A command lasts until the next one, also when its controller has stopped; limits hold it. An
    emergency stop suspends it.

    Attributes:
        motor: of the joint in the engine.
        limits: its Joint of the description: type, limits of position, velocity and effort.
        bounds: CommandLimits.
        position, velocity: [rad, m], [rad/s, m/s].
        goal, command: of the last command: velocity, position or effort, or "": none; its value
            [rad/s, m/s, rad, m, N m, N].
        effort: that acts over each step [N m, N]; None: none is commanded.
        pid: that computes the effort before each step; None: it stays as it is.
        gains_pid: that follows commands of velocities and positions by efforts, see
            Hardware.set_gains(); None: the joint's motor follows them.
    """

    STATE = ("effort", "pid", "gains_pid", "goal", "command", "_limiter")
    CACHE = ("motor",)

    def __init__(
        self,
        name: str,
        limits: Joint,
        motor: Motor,
        robot: Robot,
        bounds: CommandLimits | None = None,
    ) -> None:
        self.name, self.limits, self.motor, self._robot = name, limits, motor, robot
        self.bounds = command_limits(limits) if bounds is None else bounds
        self._of_force = JointLimits(limits)
        self._limiter = Limiter(self.bounds)
        self._max_effort, self._max_speed = self.bounds.max_effort, self.bounds.max_speed
        self.position = self.velocity = 0.0
        self.effort: float | None = None
        self.pid: Pid | None = None
        self.gains_pid: Pid | None = None
        self.goal, self.command = "", 0.0

    def set_velocity(self, value: float) -> None:
        """Command a velocity [rad/s, m/s]."""
        if self._robot.is_stopped:
            return
        limiter = self._limiter
        if self.gains_pid is not None or limiter.gradual["velocity", False]:
            self.begin("velocity", value)
            return
        self.goal, self.command = "velocity", value
        low, high = limiter.bounds["velocity"]  # as begin(), with fewer calls
        value = low if value < low else high if value > high else value
        self.motor.track_velocity(value, self._max_effort)

    def set_position(self, value: float) -> None:
        """Command a position [rad, m]."""
        if not self._robot.is_stopped:
            self.begin("position", value)

    def set_effort(self, value: float, pid: Pid | None = None) -> None:
        """Command an effort [N m, N].

        Args:
            pid: whose output it is; an engine that makes several steps in one call computes it
                anew before each.
        """
        if self._robot.is_stopped:
            return
        if self.effort is None:
            self._start_effort()
        self.goal, self.effort, self.pid = "effort", value, pid

    def release(self) -> None:
        """Drop the command: the joint moves freely, with its friction."""
        self._robot.release((self.name,))

    def keep(self) -> None:
        """Let the last command stay, as limits have held it: no controller computes another."""
        if self.pid is not self.gains_pid:
            self.pid = None
        if self.is_limited:
            self.command = self._limiter.held(self.command)

    def drop(self, interface: str = "") -> None:
        """Drop the command, as release(): a joint with a velocity interface is told to stop, one
        with a position interface keeps its last position, at first 0."""
        self.effort = self.pid = None
        self.motor.release()
        last = self.command if self.goal == "position" else 0.0
        self.goal, self.command = "", 0.0
        if interface in ("velocity", "position"):
            self.begin(interface, last if interface == "position" else 0.0)

    def forget(self, motor: Motor) -> None:
        """Forget all commands and follow with a motor: the body was loaded, or loaded again."""
        self.motor, self.goal, self.command = motor, "", 0.0
        self._limiter.reset()

    @property
    def is_limited(self) -> bool:
        """Whether limits may hold the command step by step."""
        return self._limiter.gradual.get((self.goal, self.gains_pid is not None), False)

    def suspend(self, interface: str) -> None:
        """As an emergency stop has it: a joint with a velocity interface brakes, one with a
        position interface stays where it is, no effort acts on the others."""
        if self.goal == "effort":
            self.command = self.effort or 0.0
        self.effort = self.pid = None
        self.motor.release()
        if interface == "velocity":
            self._apply("velocity", 0.0)
        elif interface == "position":
            self.goal, self.command = "position", self.position
            self._apply("position", self.position)

    def resume(self) -> None:
        """Follow the last command again."""
        if self.goal == "effort":
            self.set_effort(self.command)
        elif self.goal:
            self.begin(self.goal, self.command)

    def begin(self, goal: str, value: float) -> None:
        """Follow a velocity or a position, within the limits, also while an emergency stop acts."""
        self.goal, self.command = goal, value
        if self._limiter.gradual[goal, self.gains_pid is not None]:
            self._robot.limited[self.name] = self
        else:
            low, high = self._limiter.bounds[goal]
            self._apply(goal, low if value < low else high if value > high else value)

    def limit(self, period: float) -> bool:
        """Before a step [s]: hold the command within limits that it meets step by step.

        Returns:
            Whether what it is now stays in the next steps.
        """
        value, stays = self._limiter.step(
            self.goal, self.command, self.position, self.velocity, period
        )
        self._apply(self.goal, value)
        return stays

    def _apply(self, goal: str, value: float) -> None:
        """Have the joint's motor, or gains_pid, follow a value that is within the limits."""
        pid = self.gains_pid
        if pid is not None:
            if self.pid is not pid:
                self._start_effort()
                pid.reset()
                self.pid = pid
            pid.goal, pid.target = goal, value
        elif goal == "velocity":
            self.motor.track_velocity(value, self._max_effort)
        else:
            self.motor.track_position(value, self._max_effort, self._max_speed)

    def _start_effort(self) -> None:
        """Have efforts act in place of the motor."""
        self.motor.release()
        self.effort = 0.0
        self._robot.list_acting()

    @property
    def is_regulated(self) -> bool:
        """Whether the effort follows a velocity or a position by gains_pid."""
        return self.pid is not None and self.pid is self.gains_pid

    def regulate(self, period: float) -> None:
        """Compute the effort by gains_pid for the time [s] since the last update."""
        pid = self.gains_pid
        assert pid is not None
        if pid.goal == "velocity":
            error = pid.target - self.velocity
        else:
            error = law.position_error(self.position, pid.target, *self._regulated_limits())
        self.effort = pid.update(error, period)

    def _regulated_limits(self) -> tuple[float, float, float]:
        """Lower and upper limit and way of law.position_error() of gains_pid: that of
        DefaultRobotHWSim::writeSim."""
        bounds, kind = self.bounds, self.limits.kind
        if kind == "revolute" and bounds.lower > -inf and bounds.upper < inf:
            return bounds.lower, bounds.upper, law.WAY_WITHIN
        return nan, nan, law.WAY_SHORT if kind in ("revolute", "continuous") else law.WAY_LINEAR

    def effort_row(self, computes: bool) -> EffortRow:
        """What acts on the joint in each of several steps of an engine.

        Args:
            computes: the effort's PID, if it has one, is computed anew before each.
        """
        regulated, of_force = self.is_regulated, self._of_force.of_force()
        bounds = self.bounds.effort_bounds()
        if regulated:  # gazebo_ros_control bounds it by the joint's effort alone
            effort = self.bounds.effort
            bounds = (inf if effort is None else effort, -inf, inf, inf, nan, nan, nan, nan)
        if computes and self.pid is not None:
            limits = self._regulated_limits() if regulated else limits_of(self.limits)
            return self.pid.row(self.motor, limits, of_force, bounds)
        return EffortRow(self.motor, of_force, bounds, 0.0 if self.effort is None else self.effort)

    def take_effort(self, row: EffortRow) -> None:
        """An engine has computed the effort for several steps."""
        if self.pid is not None:
            self.pid.take_state(row)
            self.effort = row.output

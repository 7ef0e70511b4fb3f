"""A joint as the controllers of a robot see it: its state, and what they command."""

from __future__ import annotations

from typing import Protocol

from bullet_sim.component import Stateful
from bullet_sim.controllers.limits import JointLimits
from bullet_sim.controllers.pid import Pid, position_error
from bullet_sim.description.model import Joint
from bullet_sim.engine.api import Motor
from bullet_sim.engine.efforts import EffortRow


class Robot(Protocol):
    """What a joint needs of its robot, see hardware.Hardware."""

    is_stopped: bool

    def list_acting(self) -> None: ...
    def release(self, names: tuple[str, ...]) -> None: ...


class JointHandle(Stateful):
    """A joint: its state, as of the last Hardware.read(), and its command.

    A command lasts until the next one; the URDF limits it. An emergency stop drops it.

    Attributes:
        motor: of the joint in the engine.
        limits: its Joint of the description: type, limits of position, velocity and effort.
        position, velocity: [rad, m], [rad/s, m/s].
        effort: that acts over each step [N m, N]; None: none is commanded.
        pid: that computes the effort before each step; None: it stays as it is.
        gains_pid: that follows commands of velocities and positions by efforts, see
            Hardware.set_gains(); None: the joint's motor follows them.
        last_position: the last command of a position [rad, m].
    """

    STATE = ("effort", "pid", "gains_pid", "last_position")

    def __init__(self, name: str, limits: Joint, motor: Motor, robot: Robot) -> None:
        self.name, self.limits, self.motor, self._robot = name, limits, motor, robot
        self.position = self.velocity = 0.0
        self.effort: float | None = None
        self.pid: Pid | None = None
        self.gains_pid: Pid | None = None
        self.last_position = 0.0
        self._bounds = JointLimits(limits)

    def set_velocity(self, value: float, is_release: bool = False) -> None:
        """Command a velocity [rad/s, m/s].

        Args:
            is_release: no controller commands it any more; an emergency stop does not hold it.
        """
        if self._robot.is_stopped and not is_release:
            return
        if self.gains_pid is not None:
            self._follow("velocity", value)
        else:
            self.motor.track_velocity(self._bounds.velocity(value), self._bounds.max_effort)

    def set_position(self, value: float, is_release: bool = False) -> None:
        """Command a position [rad, m], as set_velocity()."""
        if self._robot.is_stopped and not is_release:
            return
        self.last_position = value
        if self.gains_pid is not None:
            self._follow("position", value)
        else:
            self.motor.track_position(*self._bounds.position_command(value))

    def set_effort(self, value: float, pid: Pid | None = None) -> None:
        """Command an effort [N m, N], as set_velocity().

        Args:
            pid: whose output it is; an engine that makes several steps in one call computes it
                anew before each.
        """
        if self._robot.is_stopped:
            return
        if self.effort is None:
            self._start_effort()
        self.effort, self.pid = value, pid

    def release(self) -> None:
        """Drop the command: the joint moves freely, with its friction."""
        self._robot.release((self.name,))

    def _start_effort(self) -> None:
        """Have efforts act in place of the motor."""
        self.motor.release()
        self.effort = 0.0
        self._robot.list_acting()

    @property
    def is_regulated(self) -> bool:
        """Whether the effort follows a velocity or a position by gains_pid."""
        return self.pid is not None and self.pid is self.gains_pid

    def _follow(self, goal: str, value: float) -> None:
        """Follow a velocity or a position by gains_pid."""
        pid = self.gains_pid
        assert pid is not None
        if self.pid is not pid:
            self._start_effort()
            pid.reset()
            self.pid = pid
        pid.goal, pid.target = goal, self._bounds.set_point(goal, value)

    def regulate(self, period: float) -> None:
        """Compute the effort by gains_pid for the time [s] since the last update."""
        pid = self.gains_pid
        assert pid is not None
        if pid.goal == "velocity":
            error = pid.target - self.velocity
        else:
            error = position_error(self.limits, self.position, pid.target)
        self.effort = pid.update(error, period)

    def effort_row(self, computes: bool) -> EffortRow:
        """What acts on the joint in each of several steps of an engine.

        Args:
            computes: the effort's PID, if it has one, is computed anew before each.
        """
        bounds, of_force = self._bounds.effort_bounds(self.is_regulated), self._bounds.of_force()
        if computes and self.pid is not None:
            return self.pid.row(self.motor, self.limits, of_force, bounds)
        return EffortRow(self.motor, of_force, bounds, 0.0 if self.effort is None else self.effort)

    def take_effort(self, row: EffortRow) -> None:
        """An engine has computed the effort for several steps."""
        if self.pid is not None:
            self.pid.take_state(row)
            self.effort = row.output

"""Commands to joints: on the engine's motors, or by an effort from a PID.

Hardware interface of the controllers: joint velocities, positions and efforts, as in
gazebo_ros_control. A velocity or position command is set on the engine's motor, which tracks it. An
effort is applied before every step. A joint with gains (gazebo_ros_control/pid_gains)
follows velocity and position commands by an effort from a PID. What is commanded is in the handles
of the joints; their limits hold where it is applied (limits.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Protocol

from bullet_sim.component import Stateful
from bullet_sim.controllers.handle import JointHandle
from bullet_sim.controllers.interfaces import Registered
from bullet_sim.controllers.pid import Pid, PidGains
from bullet_sim.description.model import Joint
from bullet_sim.engine.api import Motor
from bullet_sim.engine.efforts import EffortRow
from bullet_sim.errors import ControllerError
from bullet_sim.pose import Array


class RobotJoints(Protocol):
    """Movable joints of one robot, see models.joints.Joints; SteerBotJoints are others."""

    names: tuple[str, ...]
    limits: dict[str, Joint]

    def read(self, handles: Sequence[JointHandle]) -> None: ...
    def columns(self, indices: Sequence[int]) -> Sequence[list[float]]: ...
    def motor(self, name: str) -> Motor: ...
    def apply_efforts(
        self, handles: Sequence[JointHandle], computes: bool = False
    ) -> list[EffortRow] | None: ...


class Hardware(Stateful):
    """Commands of one robot's joints.

    Args:
        registered: their interfaces and limits; None: every joint has all interfaces.

    Attributes:
        is_stopped: by an emergency stop, see set_emergency_stop().
        acting: handles of the joints on which an effort acts.
        limited: handles whose commands limits hold step by step, by name.
    """

    STATE = ("is_stopped", "_all")
    CACHE = ("joints", "registered", "_handles", "acting", "limited")

    def __init__(self, joints: RobotJoints, registered: Registered | None = None) -> None:
        self.is_stopped = False
        self._use(joints, registered or Registered(interfaces=None))

    def put_before(self, joints: RobotJoints, registered: Registered) -> None:
        """Use other joints than the robot's, e.g. SteerBotJoints before them."""
        for joint in self._all:
            joint.motor.release()
        self._use(joints, registered)
        self.restart()

    def set_registered(self, registered: Registered) -> None:
        """Offer other interfaces of the same joints, before a controller has handles of them."""
        self._use(self.joints, registered)

    def _use(self, joints: RobotJoints, registered: Registered) -> None:
        self.joints, self.registered = joints, registered
        bounds = registered.limits
        self._handles = {
            name: JointHandle(name, joints.limits[name], joints.motor(name), self, bounds.get(name))
            for name in joints.names
        }
        self._all = tuple(self._handles.values())
        self.acting: tuple[JointHandle, ...] = ()
        self.limited: dict[str, JointHandle] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the movable joints."""
        return tuple(self._handles)

    @property
    def published_names(self) -> tuple[str, ...]:
        """Joints of the JointStateInterface, in alphabetical order as in its std::map: those that
        are registered."""
        interfaces = self.registered.interfaces
        names = self._handles if interfaces is None else interfaces.keys() & self._handles.keys()
        return tuple(sorted(names))

    def handles(self, names: Iterable[str]) -> tuple[JointHandle, ...]:
        """The handles of joints.

        Raises:
            ControllerError: a joint does not exist.
        """
        names = tuple(names)
        for name in names:
            if name not in self._handles:
                raise ControllerError(
                    f"joint '{name}' does not exist; joints are {', '.join(self.names) or '(none)'}"
                )
        return tuple(self._handles[name] for name in names)

    def read(self) -> None:
        """Read the joints' states into their handles."""
        self.joints.read(self._all)

    # interfaces -------------------------------------------------------------------------------
    def check_interface(self, label: str, interface: str, names: Iterable[str]) -> None:
        """Check that joints have a hardware interface.

        Args:
            interface: velocity, position or effort.

        Raises:
            ControllerError: a joint has not.
        """
        for name in names:
            lacks = self.registered.lacks(name, interface)
            if lacks:
                raise ControllerError(f"{label}: {lacks}")

    def set_gains(self, joint: str, gains: PidGains) -> None:
        """Drive a joint's velocity and position commands by a PID from the next restart() on.

        Raises:
            ControllerError: no such joint.
        """
        if joint not in self._handles:
            raise ControllerError(
                f"pid_gains name joint '{joint}', which does not exist; joints "
                f"are {', '.join(self.names) or '(none)'}"
            )
        handle = self._handles[joint]
        if handle.gains_pid is None:
            handle.gains_pid = Pid(gains)
        else:
            handle.gains_pid.gains = gains

    # commands ---------------------------------------------------------------------------------
    def list_acting(self) -> None:
        """List anew the joints on which an effort acts."""
        self.acting = tuple(joint for joint in self._all if joint.effort is not None)

    def release(self, names: Iterable[str]) -> None:
        """No controller commands these joints any more, see JointHandle.drop().

        As gazebo_ros_control, which writes its commands in every step whether or not a controller
        runs.
        """
        joints = [self._handles[name] for name in names]
        for joint in joints:
            self.limited.pop(joint.name, None)
            joint.drop(self._interface(joint))
        self.list_acting()

    def keep(self, names: Iterable[str]) -> None:
        """Let the last commands of joints stay: their controller has stopped."""
        for name in names:
            self._handles[name].keep()

    def _interface(self, joint: JointHandle) -> str:
        """The first interface of a joint, or ""."""
        return next(iter((self.registered.interfaces or {}).get(joint.name, ())), "")

    def set_emergency_stop(self, active: bool) -> None:
        """Stop the joints, whatever controllers command, until it is no longer active.

        As in gazebo_ros_control, see JointHandle.suspend(); then the last commands count again.
        """
        was_stopped, self.is_stopped = self.is_stopped, active
        if active == was_stopped:
            return
        self.limited.clear()
        for joint in self._all:
            if active:
                joint.suspend(self._interface(joint))
            else:
                joint.resume()
        self.list_acting()

    def restart(self) -> None:
        """Forget all commands: the body was loaded, or loaded again."""
        for joint in self._all:
            joint.forget(self.joints.motor(joint.name))
        self.release(self.names)

    # every step -------------------------------------------------------------------------------
    @property
    def periodic(self) -> bool:
        """Whether something has to be written before every step."""
        return bool(self.acting or self.limited)

    def limit(self, period: float) -> None:
        """Before a step [s]: hold commands within limits that they meet step by step."""
        for name, joint in tuple(self.limited.items()):
            if joint.limit(period):
                del self.limited[name]

    def efforts(self, period: float, computes: bool = False) -> list[EffortRow]:
        """Rows of the efforts that act in the next steps; one that is not finite counts as 0.

        Args:
            period: since PIDs of gains were computed last [s].
            computes: the engine computes PIDs anew before each step.
        """
        if not self.acting:
            return []
        for joint in () if computes else self.acting:
            if joint.is_regulated:
                joint.regulate(period)
        return self.joints.apply_efforts(self.acting, computes) or []

    def take_steps(self, recorded: Array, rows: Iterable[EffortRow]) -> None:
        """An engine has made steps with such rows, and computed PIDs.

        Args:
            recorded: positions and velocities (count, 2, n) of the joints before each step.
        """
        for joint, position, velocity in zip(self._all, *recorded[-1].tolist()):
            joint.position, joint.velocity = position, velocity
        for joint, row in zip(self.acting, rows):
            joint.take_effort(row)

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore a result of get_state()."""
        super().set_state(state)
        self.list_acting()
        self.limited = {joint.name: joint for joint in self._all if joint.is_limited}

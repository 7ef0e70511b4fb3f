"""Commands to joints: on the engine's motors, or by an effort from a PID.

Hardware interface of the controllers: joint velocities, positions and efforts, as in
gazebo_ros_control. A velocity or position command is set on the engine's motor, which tracks it. An
effort is applied before every step. A joint with gains (gazebo_ros_control/pid_gains)
follows velocity and position commands by an effort from a PID. What is commanded is in the handles
of the joints; their limits hold where it is applied (limits.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

from bullet_sim.component import Stateful
from bullet_sim.controllers.handle import JointHandle
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
        interfaces: mapping joint name -> offered interfaces, from <transmission>s.

    Attributes:
        is_stopped: by an emergency stop, see set_emergency_stop().
        acting: handles of the joints on which an effort acts.
    """

    STATE = ("is_stopped", "_all")
    CACHE = ("joints", "_interfaces", "_handles", "acting")

    def __init__(
        self, joints: RobotJoints, interfaces: Mapping[str, Sequence[str]] | None = None
    ) -> None:
        self.is_stopped = False
        self._use(joints, interfaces or {})

    def put_before(self, joints: RobotJoints, interfaces: Mapping[str, Sequence[str]]) -> None:
        """Use other joints than the robot's, e.g. SteerBotJoints before them, with interfaces."""
        for joint in self._all:
            joint.motor.release()
        self._use(joints, interfaces)
        self.restart()

    def set_interfaces(self, interfaces: Mapping[str, Sequence[str]]) -> None:
        """Offer other interfaces of the same joints, before a controller has handles of them."""
        self._use(self.joints, interfaces)

    def _use(self, joints: RobotJoints, interfaces: Mapping[str, Sequence[str]]) -> None:
        self.joints, self._interfaces = joints, interfaces
        self._handles = {
            name: JointHandle(name, joints.limits[name], joints.motor(name), self)
            for name in joints.names
        }
        self._all = tuple(self._handles.values())
        self.acting: tuple[JointHandle, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the movable joints."""
        return tuple(self._handles)

    @property
    def published_names(self) -> tuple[str, ...]:
        """Joints of the JointStateInterface, in alphabetical order as in its std::map.

        As in gazebo_ros_control they are those with a <transmission>; without any <transmission>,
        where it has none, they are all.
        """
        return tuple(sorted(self._interfaces.keys() & self._handles.keys())) or tuple(
            sorted(self._handles)
        )

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
    def check_interface(self, label: str, interface: str, names: Iterable[str]) -> list[str]:
        """Check that joints have a hardware interface.

        Args:
            interface: velocity, position or effort.

        Returns:
            Messages about joints without <transmission>, which have all interfaces here.

        Raises:
            ControllerError: a joint's transmissions have other interfaces only.
        """
        without = []
        for name in names:
            offered = self._interfaces.get(name)
            if offered is None:
                without.append(name)
            elif offered and interface not in offered:
                raise ControllerError(
                    f"{label} needs the {interface} interface of joint '{name}', whose "
                    f"<transmission> offers {' and '.join(offered)}"
                )
        if not without:
            return []
        return [
            f"{label}: no <transmission> names {', '.join(without)}; gazebo_ros_control would "
            "refuse the controller, here such joints take any"
        ]

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

    def pid(self, joint: str) -> Pid | None:
        """The Pid of a joint with gains, or None."""
        return self._handles[joint].gains_pid if joint in self._handles else None

    # commands ---------------------------------------------------------------------------------
    def list_acting(self) -> None:
        """List anew the joints on which an effort acts."""
        self.acting = tuple(joint for joint in self._all if joint.effort is not None)

    def release(self, names: Iterable[str]) -> None:
        """No controller commands these joints any more.

        As gazebo_ros_control, which writes its commands in every step whether or not a controller
        runs: a joint with a velocity interface is commanded to stop, one with a position interface
        keeps its last position, at first 0. All others move freely, with their friction.
        """
        joints = [self._handles[name] for name in names]
        for joint in joints:
            joint.effort = joint.pid = None
            joint.motor.release()
        self.list_acting()
        for joint in joints:
            first = next(iter(self._interfaces.get(joint.name, ())), None)
            if first == "velocity":
                joint.set_velocity(0.0, is_release=True)
            elif first == "position":
                joint.set_position(joint.last_position, is_release=True)

    def set_emergency_stop(self, active: bool) -> None:
        """Stop the joints, whatever controllers command, until it is no longer active.

        As in gazebo_ros_control: joints with a position interface stay where they are, those with
        a velocity interface are braked, no effort acts on the others.
        """
        if active and not self.is_stopped:
            for joint in self._all:
                joint.last_position = joint.position
            self.release(self.names)
        self.is_stopped = active

    def restart(self) -> None:
        """Forget all commands: the body was loaded, or loaded again."""
        for joint in self._all:
            joint.last_position, joint.motor = 0.0, self.joints.motor(joint.name)
        self.release(self.names)

    # every step -------------------------------------------------------------------------------
    @property
    def periodic(self) -> bool:
        """Whether something has to be written before every step."""
        return bool(self.acting)

    def efforts(self, period: float, computes: bool = False) -> list[EffortRow]:
        """Rows of the efforts that act in the next steps; one that is not finite counts as 0.

        Args:
            period: since the controllers' last update [s]; 0: they were not updated, the PIDs'
                outputs stay.
            computes: the engine computes PIDs anew before each step.
        """
        if not self.acting:
            return []
        if period > 0 and not computes:
            for joint in self.acting:
                if joint.is_regulated:
                    joint.regulate(period)
        if computes:
            return self.joints.apply_efforts(self.acting, True) or []
        return self.joints.apply_efforts(self.acting) or []

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

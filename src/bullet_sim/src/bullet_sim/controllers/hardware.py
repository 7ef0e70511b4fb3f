"""Commands to joints: on the engine's motors, or by an effort from a PID.

Hardware interface of the controllers: joint velocities, positions and efforts, as in
gazebo_ros_control. A velocity or position command is set on the engine's motor, which tracks it. An
effort is applied before every step. A joint with gains (gazebo_ros_control/pid_gains)
follows velocity and position commands by an effort from a PID.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

from bullet_sim.component import Stateful
from bullet_sim.controllers import law
from bullet_sim.controllers.pid import Pid, PidGains, position_error
from bullet_sim.description.model import Joint
from bullet_sim.errors import ControllerError


class RobotJoints(Protocol):
    """Movable joints of one robot, see models.joints.Joints; SteerBotJoints are others."""

    names: tuple[str, ...]
    limits: dict[str, Joint]

    def read(self, handles: "Sequence[JointHandle]") -> None: ...
    def columns(self, indices: Sequence[int]) -> Sequence[list[float]]: ...
    def drive_velocities(self, names: Iterable[str], values: Iterable[float]) -> None: ...
    def drive_positions(self, names: Iterable[str], values: Iterable[float]) -> None: ...
    def effort_bounds(self, name: str, position: float, velocity: float) -> tuple[float, float]: ...
    def apply_efforts(self, efforts: Mapping[str, float]) -> None: ...
    def track(
        self, targets: Mapping[str, tuple[float, float]], handles: "Mapping[str, JointHandle]"
    ) -> None: ...
    def release(self, names: Iterable[str]) -> None: ...


class JointHandle:
    """A joint as the controllers of a robot see it.

    Attributes:
        limits: its Joint of the description: type, limits of position, velocity and effort.
        inertia: that its effort moves [kg m^2, kg]; None: unknown.
        position, velocity: [rad, m], [rad/s, m/s], of the last Hardware.read().
    """

    __slots__ = ("name", "limits", "inertia", "position", "velocity", "hardware")

    def __init__(
        self, name: str, limits: Joint, inertia: float | None, hardware: "Hardware"
    ) -> None:
        self.name, self.limits, self.inertia, self.hardware = name, limits, inertia, hardware
        self.position = self.velocity = 0.0

    def set_velocity(self, value: float) -> None:
        """Command a velocity [rad/s, m/s], until the next command; the URDF limits it."""
        self.hardware.command("velocity", (self,), (value,))

    def set_position(self, value: float) -> None:
        """Command a position [rad, m], as set_velocity()."""
        self.hardware.command("position", (self,), (value,))

    def set_effort(self, value: float) -> None:
        """Command an effort [N m, N], as set_velocity()."""
        self.hardware.command("effort", (self,), (value,))

    def release(self) -> None:
        """Drop the command: the joint moves freely, with its friction."""
        self.hardware.release((self.name,))

    def push(self, effort: float) -> None:
        """Apply an effort [N m, N] of a PID to the joint, whose motor is released."""
        hardware, name = self.hardware, self.name
        if name in hardware.tracked:
            del hardware.tracked[name]
            hardware.joints.release((name,))
        hardware.efforts[name] = effort


class Hardware(Stateful):
    """Commands of one robot's joints.

    Args:
        interfaces: mapping joint name -> offered interfaces, from <transmission>s.
        inertias: mapping joint name -> inertia that its effort moves, see description.inertias;
            joints that are not in it get their PIDs' efforts as they are.

    Attributes:
        is_stopped: by an emergency stop, see set_emergency_stop().
        efforts: joint name -> effort [N m, N] over each step.
        tracked: joint name -> (velocity [rad/s, m/s], effort [N m, N]) to track.
    """

    STATE = ("is_stopped", "efforts", "tracked", "_targets", "_pids", "_positions")
    CACHE = ("joints", "_interfaces", "_handles", "_all")

    def __init__(
        self,
        joints: RobotJoints,
        interfaces: Mapping[str, Sequence[str]] | None = None,
        inertias: Mapping[str, float] | None = None,
    ) -> None:
        self._inertias = inertias or {}
        self.is_stopped = False
        self.efforts: dict[str, float] = {}
        self.tracked: dict[str, tuple[float, float]] = {}
        self._pids: dict[str, Pid] = {}  # of the joints with gains ...
        self._targets: dict[str, tuple[str, float]] = {}  # ... and what they follow
        self._positions: dict[str, float] = {}  # the last commands of positions
        self._use(joints, interfaces or {})

    def put_before(self, joints: RobotJoints, interfaces: Mapping[str, Sequence[str]]) -> None:
        """Use other joints than the robot's, e.g. SteerBotJoints before them, with interfaces."""
        self.joints.release(self.names)
        self._use(joints, interfaces)
        self.restart()

    def _use(self, joints: RobotJoints, interfaces: Mapping[str, Sequence[str]]) -> None:
        self.joints, self._interfaces = joints, interfaces
        self._handles = {
            name: JointHandle(name, joints.limits[name], self._inertias.get(name), self)
            for name in joints.names
        }
        self._all = tuple(self._handles.values())

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
        if joint in self._pids:
            self._pids[joint].gains = gains
        else:
            self._pids[joint] = Pid(gains, self._handles[joint])

    def pid(self, joint: str) -> Pid | None:
        """The Pid of a joint with gains, or None."""
        return self._pids.get(joint)

    # commands ---------------------------------------------------------------------------------
    def command(
        self, interface: str, joints: Sequence[JointHandle], values: Sequence[float]
    ) -> None:
        """Command joints until the next command, within the URDF's limits.

        Args:
            interface: velocity [rad/s, m/s], position [rad, m] or effort [N m, N].
        """
        if not self.is_stopped:
            self._command(interface, joints, values)

    def _command(
        self, interface: str, joints: Sequence[JointHandle], values: Sequence[float]
    ) -> None:
        if interface == "effort":
            for joint, value in zip(joints, values):
                if joint.name not in self.efforts:
                    self.joints.release((joint.name,))
                self.efforts[joint.name] = value
            return
        if interface == "position":
            self._positions.update((joint.name, value) for joint, value in zip(joints, values))
        drive = {"velocity": self.joints.drive_velocities, "position": self.joints.drive_positions}
        direct = [(j.name, value) for j, value in zip(joints, values) if j.name not in self._pids]
        if direct:
            drive[interface](*zip(*direct))
        for joint, value in zip(joints, values):
            name = joint.name
            if name in self._pids:
                if name not in self._targets:
                    self.joints.release((name,))
                    self._pids[name].reset()
                self._pids[name].follow(interface)
                self._targets[name] = (interface, value)

    def release(self, names: Iterable[str]) -> None:
        """No controller commands these joints any more.

        As gazebo_ros_control, which writes its commands in every step whether or not a controller
        runs: a joint with a velocity interface is commanded to stop, one with a position interface
        keeps its last position, at first 0. All others move freely, with their friction.
        """
        names = tuple(names)
        for name in names:
            self._targets.pop(name, None)
            self.efforts.pop(name, None)
            self.tracked.pop(name, None)
        self.joints.release(names)
        for name in names:
            first = next(iter(self._interfaces.get(name, ())), None)
            if first in ("velocity", "position"):
                value = self._positions.get(name, 0.0) if first == "position" else 0.0
                self._command(first, (self._handles[name],), (value,))

    def set_emergency_stop(self, active: bool) -> None:
        """Stop the joints, whatever controllers command, until it is no longer active.

        As in gazebo_ros_control: joints with a position interface stay where they are, those with
        a velocity interface are braked, no effort acts on the others.
        """
        if active and not self.is_stopped:
            for name, joint in self._handles.items():
                self._positions[name] = joint.position
            self.release(self.names)
        self.is_stopped = active

    def restart(self) -> None:
        """Forget all commands: the body was loaded, or loaded again."""
        self._positions.clear()
        self.release(self.names)

    def followed(self) -> list[tuple[Pid, float]]:
        """PIDs of the joints with gains that follow a command, and what each follows."""
        found = []
        for name, (goal, target) in self._targets.items():
            if goal == "velocity":
                limit = self._handles[name].limits.velocity or abs(target)
                target = min(max(target, -limit), limit)
            found.append((self._pids[name], target))
        return found

    # every step -------------------------------------------------------------------------------
    @property
    def periodic(self) -> bool:
        """Whether something has to be written before every step."""
        return bool(self.efforts or self._targets or self.tracked)

    def write(self, period: float) -> None:
        """Write the efforts for the next step; one that is not finite counts as 0.

        Args:
            period: since the controllers' last update [s]; 0: they were not updated, the PIDs'
                outputs stay.
        """
        handles, joints = self._handles, self.joints
        if period > 0:
            for pid, target in self.followed():
                joint = pid.joint
                if pid.goal == "velocity":
                    error = target - joint.velocity
                else:
                    error = position_error(joint.limits, joint.position, target)
                pid.update(error, joint.velocity, period)
        if self.is_stopped:  # then only PIDs that hold a joint act
            self.efforts = {
                name: self.efforts[name] for name in self.efforts if name in self._targets
            }
            self.tracked = {
                name: self.tracked[name] for name in self.tracked if name in self._targets
            }
        if self.efforts:
            efforts = {}
            for name, effort in self.efforts.items():
                joint = handles[name]
                if name in self._targets:  # as there, only commands of efforts have the others
                    high = joint.limits.effort or math.inf
                    low = -high
                else:
                    low, high = joints.effort_bounds(name, joint.position, joint.velocity)
                efforts[name] = law.within(effort, low, high)
            joints.apply_efforts(efforts)
        if self.tracked:
            joints.track(self.tracked, handles)

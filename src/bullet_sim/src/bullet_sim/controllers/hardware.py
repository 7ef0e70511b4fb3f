"""What controllers command: joint velocities, positions and efforts, as gazebo_ros_control does.

A velocity or position command goes straight to the engine's motor, which keeps it. An effort has
to be given anew before every step. A joint with gains of its own (gazebo_ros_control/pid_gains)
follows velocity and position commands by an effort that a PID computes.
"""

import math

from bullet_sim.controllers.angles import position_error
from bullet_sim.controllers.pid import Pid
from bullet_sim.controllers.stiffness import bearable
from bullet_sim.errors import ControllerError


class Hardware:
    """Commands of one robot's joints.

    Args:
        joints: bullet_sim.models.joints.Joints.
        interfaces: mapping joint name -> offered interfaces, from <transmission>s.
        inertias: mapping joint name -> inertia that its effort moves, see stiffness.py; None:
            any gain will do.
    """

    def __init__(self, joints, interfaces=None, inertias=None):
        self._joints = joints
        self._inertias, self._bearable = inertias or {}, {}
        self._interfaces = interfaces or {}
        self._pids, self._targets, self._efforts = {}, {}, {}
        self._by_pid = {}

    @property
    def names(self):
        """Names of the movable joints."""
        return self._joints.names

    @property
    def limits(self):
        """Mapping joint name -> bullet_sim.description.parts.Joint."""
        return self._joints.limits

    def positions_of(self, names):
        """Positions [rad, m] of some joints, a tuple."""
        return self._joints.positions_of(names)

    def state(self):
        """Positions and velocities, two mappings from the joints' names."""
        return self._joints.state()

    # interfaces -------------------------------------------------------------------------------
    def check_interface(self, what, interface, names):
        """Check that joints offer an interface.

        Args:
            what: who asks, for messages.
            interface: velocity, position or effort.
            names: joint names.

        Returns:
            Sentences about joints without <transmission>, which offer everything here.

        Raises:
            ControllerError: a joint's transmissions offer other interfaces only.
        """
        without = [name for name in names if name not in self._interfaces]
        for name in names:
            offered = self._interfaces.get(name, ())
            if offered and interface not in offered:
                raise ControllerError(
                    f"{what} needs the {interface} interface of joint '{name}', whose "
                    f"<transmission> offers {' and '.join(offered)}"
                )
        return (
            [
                f"{what}: no <transmission> names {', '.join(without)}; gazebo_ros_control would "
                "refuse the controller, here such joints take any"
            ]
            if without
            else []
        )

    def set_gains(self, joint, gains):
        """Drive a joint's velocity and position commands by a PID from now on.

        Args:
            joint: its name.
            gains: PidGains.

        Raises:
            ControllerError: no such joint.
        """
        if joint not in self.names:
            raise ControllerError(
                f"pid_gains name joint '{joint}', which does not exist; joints "
                f"are {', '.join(self.names) or '(none)'}"
            )
        if joint in self._pids:
            self._pids[joint].gains = gains
        else:
            self._pids[joint] = Pid(gains)

    def bearable(self, joint, gains, goal, period):
        """Gains of a PID that gives an effort, cut to what a step can bear; see stiffness.py."""
        key = (joint, gains, goal, period)
        if key not in self._bearable:
            if len(self._bearable) > 1000:
                self._bearable.clear()
            self._bearable[key] = (
                gains
                if joint not in self._inertias
                else bearable(gains, goal, self._inertias[joint], period)
            )
        return self._bearable[key]

    def pid(self, joint):
        """The Pid of a joint, or None."""
        return self._pids.get(joint)

    # commands ---------------------------------------------------------------------------------
    def velocities(self, names, values):
        """Let joints turn at velocities [rad/s, m/s], within the URDF's limits."""
        self._command("velocity", names, values, self._joints.drive_velocities)

    def positions(self, names, values):
        """Let joints go to positions [rad, m], within the URDF's limits."""
        self._command("position", names, values, self._joints.drive_positions)

    def _command(self, kind, names, values, drive):
        direct = [(n, v) for n, v in zip(names, values) if n not in self._pids]
        if direct:
            drive(*zip(*direct))
        for name, value in zip(names, values):
            if name in self._pids:
                if name not in self._targets:
                    self._joints.release([name])
                    self._pids[name].reset()
                self._targets[name] = (kind, value)

    def efforts(self, names, values):
        """Push joints with efforts [N m, N], within the URDF's limits, until told otherwise."""
        for name, value in zip(names, values):
            if name not in self._efforts:
                self._joints.release([name])
            self._efforts[name] = value

    def release(self, names):
        """Take commands back: joints are left to their own friction."""
        for name in names:
            for commands in (self._targets, self._efforts, self._by_pid):
                commands.pop(name, None)
        self._joints.release(names)

    def restart(self):
        """Forget all commands: the body was loaded anew."""
        for commands in (self._targets, self._efforts, self._by_pid):
            commands.clear()

    # every step -------------------------------------------------------------------------------
    @property
    def periodic(self):
        """Whether something has to be written before every step."""
        return bool(self._efforts or self._targets)

    def write(self, state, period):
        """Give the efforts for the next step; one that is no finite number counts as 0.

        Args:
            state: what state() gave.
            period: since the controllers' last update [s]; 0: they were not updated, the PIDs'
                outputs stay.
        """
        positions, velocities = state
        if period > 0:
            for name, (kind, target) in self._targets.items():
                error = (
                    self._speed_error(name, target, velocities[name])
                    if kind == "velocity"
                    else position_error(self.limits[name], positions[name], target)
                )
                pid = self._pids[name]
                self._by_pid[name] = pid.compute(
                    error, period, gains=self.bearable(name, pid.gains, kind, period)
                )
        efforts = {}
        for wanted in (self._efforts, self._by_pid):
            for name, effort in wanted.items():
                low, high = self._joints.effort_bounds(name, positions[name], velocities[name])
                efforts[name] = min(max(effort, low), high) if math.isfinite(effort) else 0.0
        self._joints.apply_efforts(efforts)

    def _speed_error(self, name, target, velocity):
        limit = self.limits[name].velocity or abs(target)
        return min(max(target, -limit), limit) - velocity

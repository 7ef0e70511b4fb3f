"""Commands to joints: on the engine's motors, or by an effort from a PID.

Hardware interface of the controllers: joint velocities, positions and efforts. As in
gazebo_ros_control. A velocity or position command is set on the engine's motor, which holds it. An
effort is applied before every step. A joint with gains of its own (gazebo_ros_control/pid_gains)
follows velocity and position commands by an effort from a PID.
"""

import math

from bullet_sim.controllers.pid import SERVOS, Pid, is_stiff, position_error
from bullet_sim.errors import ControllerError


class Regulator:
    """Regulates joints of one robot.

    Args:
        joints: bullet_sim.models.joints.Joints.
        inertias: mapping joint name -> inertia that its effort moves, see description.inertias;
            joints that are not in it get their PIDs' efforts as they are.

    Attributes:
        joints: as above; may be replaced.
        tracked: joints with stiff gains -> (velocity [rad/s, m/s], effort [N m, N]) to track.
        servos: of stiff joints.
    """

    def __init__(self, joints, inertias):
        self.joints, self._inertias = joints, inertias
        self.tracked, self.servos = {}, {}
        self._stiff = {}  # joint -> (gains, goal, period, whether they are stiff)

    def regulate(
        self,
        efforts,
        name,
        pid,
        goal,
        error,
        velocity,
        period,
        moving=None,
        extra=0.0,
        limit=math.inf,
    ):
        """As Hardware.regulate; efforts: mapping that takes the effort of gains that are not stiff.

        Only gains that are stiff for the joint's inertia are left to a servo, whose target goes
        into `tracked`.
        """
        gains, known = pid.gains, self._stiff.get(name)
        if known is None or known[0] is not gains or known[1] != goal or known[2] != period:
            inertia = self._inertias.get(name)
            stiff = inertia is not None and is_stiff(gains, goal, inertia, period)
            known = self._stiff[name] = gains, goal, period, stiff
        if not known[3]:
            if name in self.tracked:
                del self.tracked[name]
                self.joints.release([name])
            rate = None if moving is None else moving - velocity
            efforts[name] = min(max(pid.compute(error, period, rate) + extra, -limit), limit)
            return
        servo = self.servos.get(name)
        if servo is None or servo.goal != goal or name not in self.tracked:
            servo = self.servos[name] = SERVOS[goal](self._inertias[name])
        own = velocity if moving is None else velocity - moving  # as seen from the goal
        pid.compute(error, period, -own if goal == "position" else 0.0)
        if name in efforts:
            del efforts[name]
        speed, effort = servo.target(gains, error, own, pid.terms[1] + extra, period)
        if moving is not None:
            speed += moving
        self.tracked[name] = speed, effort if effort < limit else limit


class Hardware:
    """Commands of one robot's joints.

    Args:
        joints: bullet_sim.models.joints.Joints.
        interfaces: mapping joint name -> offered interfaces, from <transmission>s.
        inertias: mapping joint name -> inertia that its effort moves, see description.inertias;
            joints that are not in it get their PIDs' efforts as they are.

    Attributes:
        constant: joints -> effort [N m, N] over each step.
        tracked: joints with stiff gains -> (velocity [rad/s, m/s], effort [N m, N]) to track.
    """

    def __init__(self, joints, interfaces=None, inertias=None):
        self._joints = joints
        self._interfaces = interfaces or {}
        self._pids, self._targets, self.constant, self._by_pid = {}, {}, {}, {}
        self._regulator = Regulator(joints, inertias or {})
        self.tracked = self._regulator.tracked

    def put_before(self, joints, interfaces):
        """Use other joints than the robot's own, e.g. SteerBotJoints before them.

        Args:
            joints: with the methods of bullet_sim.models.joints.Joints.
            interfaces: as for the constructor.
        """
        self._joints, self._interfaces = joints, interfaces
        self._regulator.joints = joints

    @property
    def joints(self):
        """The joints that controllers see."""
        return self._joints

    @property
    def names(self):
        """Names of the movable joints."""
        return self._joints.names

    @property
    def limits(self):
        """Mapping joint name -> bullet_sim.description.model.Joint."""
        return self._joints.limits

    def positions_of(self, names):
        """Positions [rad, m] of some joints, a tuple."""
        return self._joints.positions_of(names)

    def state(self):
        """Positions and velocities, two mappings from the joints' names."""
        return self._joints.state()

    # interfaces -------------------------------------------------------------------------------
    def check_interface(self, what, interface, names):
        """Check that joints have a hardware interface.

        Args:
            what: the controller, for messages.
            interface: velocity, position or effort.
            names: joint names.

        Returns:
            Sentences about joints without <transmission>, which have all interfaces here.

        Raises:
            ControllerError: a joint's transmissions have other interfaces only.
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

    def servo(self, joint):
        """The servo of a joint with stiff gains that is regulated, or None."""
        return self._regulator.servos.get(joint) if joint in self.tracked else None

    def pid(self, joint):
        """The Pid of a joint, or None."""
        return self._pids.get(joint)

    # commands ---------------------------------------------------------------------------------
    def velocities(self, names, values):
        """Command joint velocities [rad/s, m/s], within the URDF's limits."""
        self._command("velocity", names, values, self._joints.drive_velocities)

    def positions(self, names, values):
        """Command joint positions [rad, m], within the URDF's limits."""
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
        """Command joint efforts [N m, N], within the URDF's limits, until the next command."""
        for name, value in zip(names, values):
            if name not in self.constant:
                self._joints.release([name])
            self.constant[name] = value

    def regulate(
        self, name, pid, goal, error, velocity, period, moving=None, extra=0.0, limit=math.inf
    ):
        """Command a joint's effort by a PID, until the next command.

        Args:
            name: the joint.
            pid: its Pid.
            goal: "velocity" or "position".
            error: of the goal.
            velocity: the joint's [rad/s, m/s].
            period: since the last time, and to the next [s].
            moving: velocity of a position goal [rad/s, m/s]; None: unknown, the derivative is that
                of the error.
            extra: effort beside the PID's [N m, N].
            limit: most effort either way [N m, N].

        Returns:
            The effort that the PID gives [N m, N].
        """
        self._regulator.regulate(
            self.constant, name, pid, goal, error, velocity, period, moving, extra, limit
        )
        return pid.output

    def release(self, names):
        """Drop the commands: the joints move freely, with their friction."""
        for name in names:
            for commands in self._commands():
                commands.pop(name, None)
        self._joints.release(names)

    def _commands(self):
        return self._targets, self.constant, self._by_pid, self.tracked, self._regulator.servos

    def restart(self):
        """Forget all commands: the body was loaded anew."""
        for commands in self._commands():
            commands.clear()

    # every step -------------------------------------------------------------------------------
    @property
    def periodic(self):
        """Whether something has to be written before every step."""
        return bool(self.constant or self._targets or self.tracked)

    def write(self, state, period):
        """Write the efforts for the next step; one that is not finite counts as 0.

        Args:
            state: result of state().
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
                self._regulator.regulate(
                    self._by_pid, name, self._pids[name], kind, error, velocities[name], period
                )
        joints = self._joints
        if self.constant or self._by_pid:
            efforts = {}
            for wanted in (self.constant, self._by_pid):
                for name, effort in wanted.items():
                    low, high = joints.effort_bounds(name, positions[name], velocities[name])
                    if not low <= effort <= high:
                        effort = min(max(effort, low), high) if math.isfinite(effort) else 0.0
                    efforts[name] = effort
            joints.apply_efforts(efforts)
        if self.tracked:
            joints.track(self.tracked, state)

    def _speed_error(self, name, target, velocity):
        limit = self.limits[name].velocity or abs(target)
        return min(max(target, -limit), limit) - velocity

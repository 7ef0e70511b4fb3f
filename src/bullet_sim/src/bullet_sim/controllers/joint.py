"""Controllers of joints: the command forwarded, or through a PID."""

from dataclasses import dataclass
from itertools import repeat

from bullet_sim.controllers.base import check_command
from bullet_sim.controllers.pid import LOOPS, Pid, position_error


class Controller:
    """A loaded controller. The base class does nothing, as a joint state controller.

    Args:
        spec: ControllerSpec.
        hardware: Hardware of the robot.
    """

    periodic = False  # whether update() is to be called before physics steps
    pids = ()
    sample = None
    goal = None  # of an action that is pursued

    def __init__(self, spec, hardware):
        self.spec = spec
        self.hardware = hardware

    def start(self, time):
        """Start controlling the joints; `time` [s] of the manager's clock."""

    def stop(self):
        """Stop controlling the joints."""
        for _, joints in self.spec.claims:
            self.hardware.release(joints)

    def restart(self, time):
        """Restart after a reset of the world."""
        self.start(time)

    def resume(self, goal):
        """Go on from a restored state.

        Args:
            goal: that was pursued before it was restored, or None.

        That goal is cancelled unless it is the restored one. A restored one that has ended since
        has nobody to report to: the motion goes on without it.
        """
        if goal is not self.goal:
            self.goal = goal
            self._finish("canceled")

    def _finish(self, outcome):
        """End the goal, if there is one."""

    def check(self, values):
        """Check a command: a sequence of numbers; returns it as a tuple of floats.

        Raises:
            CommandError: wrong count, NaN or out of bounds.
        """
        return check_command(self.spec.name, values, self.spec.command_sizes)

    def command(self, values):
        """Set a checked command (a tuple of floats)."""

    def update(self, state, time, period):
        """Compute and write commands.

        Args:
            state: Hardware.state().
            time: now [s].
            period: since the last update [s].
        """

    @property
    def updates(self):
        """What a periodic controller has called in an update: functions as update()."""
        return (self.update,)

    def observe(self, state, time):
        """Update published values to a state; nothing is commanded."""


class Forward(Controller):
    """Forwards its command to the joints: velocities, positions or efforts."""

    def __init__(self, spec, hardware):
        super().__init__(spec, hardware)
        self._command = ()
        self._write = {
            "velocity": hardware.velocities,
            "position": hardware.positions,
            "effort": hardware.efforts,
        }[spec.kind.interface]

    def start(self, time):
        """Position commands start at the present positions, velocities and efforts at 0."""
        if self.spec.kind.interface == "position":
            self._command = self.hardware.positions_of(self.spec.joints)
        else:
            self._command = (0.0,) * len(self.spec.joints)
        self._write(self.spec.joints, self._command)

    def command(self, values):
        """Write a command that differs from the last."""
        if values != self._command:
            self._command = values
            self._write(self.spec.joints, values)


@dataclass
class Sample:
    """The last update of a PID controller, for its state topic.

    Attributes:
        time: of the manager's clock [s].
        period: [s].
        set_point, process_value, error: of the goal, a position [rad, m] or velocity.
        process_value_dot: rate of the process value, where it is measured.
        command: of the joint.
    """

    time: float
    period: float
    set_point: float
    process_value: float
    process_value_dot: float
    error: float
    command: float


class PidControl(Controller):
    """Regulates positions or velocities by efforts or velocities, as ros_control does.

    Attributes:
        pids: one Pid a joint.
    """

    periodic = True

    def __init__(self, spec, hardware):
        super().__init__(spec, hardware)
        self.pids = tuple(Pid(gains) for gains in spec.gains)

    def start(self, time):
        """Hold the joints where they are, or at rest."""
        for pid in self.pids:
            pid.reset()
        joints = self.spec.joints
        self.command(
            self.hardware.positions_of(joints)
            if self.spec.kind.goal == "position"
            else (0.0,) * len(joints)
        )

    def _last(self):
        """Fields of the first joint's last Sample, or None."""

    @property
    def sample(self):
        """Sample of the first joint; None before the first update."""
        last = self._last()
        return None if last is None else Sample(*last)


class PidByEffort(PidControl):
    """Regulates by efforts."""

    def __init__(self, spec, hardware):
        super().__init__(spec, hardware)
        loop = LOOPS[spec.kind.goal]
        self._loops = tuple(map(loop, repeat(hardware), spec.joints, self.pids))

    @property
    def updates(self):
        """One function a joint."""
        return tuple(loop.update for loop in self._loops)

    def start(self, time):
        """Hold the joints where they are, or at rest."""
        for loop in self._loops:
            loop.reset()
        super().start(time)
        self.hardware.efforts(self.spec.joints, (0.0,) * len(self._loops))

    def stop(self):
        """Stop regulating the joints."""
        super().stop()
        for loop in self._loops:
            loop.forget()

    def command(self, values):
        """Set new set points."""
        for loop, value in zip(self._loops, values):
            loop.target = value

    def update(self, state, time, period):
        """One computation of each PID."""
        for update in self.updates:
            update(state, time, period)

    def _last(self):
        return self._loops[0].last


class PidByVelocity(PidControl):
    """Regulates positions by velocities."""

    def __init__(self, spec, hardware):
        super().__init__(spec, hardware)
        self._command, self._fields = (), None

    def start(self, time):
        """Hold the joints where they are."""
        self._fields = None
        super().start(time)
        self.hardware.velocities(self.spec.joints, (0.0,) * len(self.pids))

    def command(self, values):
        """Set new set points."""
        self._command = values

    def update(self, state, time, period):
        """One computation of each PID."""
        positions, velocities = state
        limits, joints = self.hardware.limits, self.spec.joints
        outputs, fields = [], []
        for joint, pid, target in zip(joints, self.pids, self._command):
            if limits[joint].lower is not None:
                target = min(max(target, limits[joint].lower), limits[joint].upper)
            error = position_error(limits[joint], positions[joint], target)
            outputs.append(pid.compute(error, period))
            fields.append((target, positions[joint], velocities[joint], error))
        self.hardware.velocities(joints, outputs)
        self._fields = time, period, *fields[0], outputs[0]

    def _last(self):
        return self._fields

"""Life cycles of a robot's controllers: load, start, stop, switch, unload, list."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from bullet_sim.component import Stateful
from bullet_sim.controllers import Controller, configure
from bullet_sim.controllers.base import MAX_STEPS
from bullet_sim.controllers.hardware import Hardware, RobotJoints
from bullet_sim.controllers.interfaces import register
from bullet_sim.description.model import ModelDescription
from bullet_sim.description.transmissions import Transmissions
from bullet_sim.engine.efforts import EffortRow
from bullet_sim.errors import ControllerError, SimError
from bullet_sim.pose import Array

INITIALIZED, RUNNING, STOPPED = "initialized", "running", "stopped"


class Manager(Stateful):
    """Controllers of one robot.

    Args:
        joints: of the robot: limits, positions, motors.
        description: sizes of wheels, <transmission>s, control period; None, or without a
            <transmission>: every joint offers every interface.

    Attributes:
        efforts, computes: see prepare_steps().
        time: clock of the controllers [s]: simulated time during which periodic ones ran.
        on_failure: function of a controller's name and the exception that it has raised while it
            started, ran or took a command: it is stopped then. None: the exception is raised.
    """

    STATE = ("hardware", "_loaded", "_states", "time", "_since", "_due")
    CACHE = ("_periodic", "_updates", "efforts", "computes")

    def __init__(
        self,
        joints: RobotJoints,
        description: ModelDescription | None = None,
    ) -> None:
        self._description, self._joints = description, joints
        self.efforts: list[EffortRow] = []
        self.computes = False
        registered = None
        if description is not None and description.transmissions != Transmissions():
            registered = register(description.transmissions, description, joints.limits)
        self.hardware = Hardware(joints, registered)
        self._period: float = getattr(description, "control_period", 0.0)
        self._loaded: dict[str, Controller] = {}
        self._states: dict[str, str] = {}
        # the running controllers to be updated, in order of loading, and their functions
        self._periodic: list[Controller] = []
        self._updates: list[Callable[[float, float], None]] = []
        self.time = self._since = 0.0
        self._due = True
        self.on_failure: Callable[[str, Exception], None] | None = None

    def load(self, name: str, values: Any) -> Any:
        """Check and add a controller, stopped.

        Returns:
            Its configuration.

        Raises:
            ControllerError: the name is taken, the configuration is wrong, or a joint does not
                offer the interface that it needs.
        """
        if name in self._loaded:
            raise ControllerError(
                f"A controller named '{name}' was already loaded inside the controller manager"
            )
        hardware = self.hardware
        if hardware.registered.refusal:
            raise ControllerError(hardware.registered.refusal)
        controller_type, config = configure(name, values, hardware.names, self._description)
        for interface, joints in config.claims:
            hardware.check_interface(f"controller '{name}'", interface, joints)
        self._loaded[name] = controller_type(config, hardware)
        self._states[name] = INITIALIZED
        return config

    def unload(self, name: str) -> None:
        """Remove a stopped controller.

        Raises:
            ControllerError: not loaded, or running.
        """
        self._named(name, "unload")
        if self._states[name] == RUNNING:
            raise ControllerError(
                f"Could not unload controller with name '{name}' because it is still running"
            )
        del self._loaded[name], self._states[name]

    def get(self, name: str) -> Any:
        """The Controller of that name.

        Raises:
            ControllerError: not loaded.
        """
        return self._named(name, "find")

    def _named(self, name: str, action: str) -> Controller:
        """The Controller of that name; raises as ros_control says what it cannot do with it."""
        if name not in self._loaded:
            raise ControllerError(
                f"Could not {action} controller with name '{name}' because no controller with this "
                f"name exists; loaded are {', '.join(self._loaded) or '(none)'}"
            )
        return self._loaded[name]

    def control_period(self, time_step: float) -> float:
        """Time [s] between two updates of a controller, with a physics step [s]."""
        return max(1, math.ceil(self._period / time_step - 1e-6)) * time_step

    def is_running(self, name: str) -> bool:
        """Whether a controller is loaded and running."""
        return self._states.get(name) == RUNNING

    def switch(self, start: Iterable[str], stop: Iterable[str], strict: bool = True) -> list[str]:
        """Stop and start controllers as one step, with ros_control's errors.

        Args:
            strict: True: an invalid name refuses the whole switch; False: it is skipped, and, as
                upstream, one that runs already starts anew.

        Returns:
            Reasons why names were skipped (best effort).

        Raises:
            ControllerError: strict and a name is invalid, or, as upstream in any case, a joint is
                claimed twice or a running controller is to start and to stop; nothing has changed
                then.
        """
        skipped: list[str] = []
        start = list(start)
        stopping = self._select("stop", stop, strict, skipped)
        starting = self._select("start", start, strict, skipped, stopping)
        for name in stopping:
            if name in start:
                raise ControllerError(
                    f"Could no start or stop controller '{name}' because of conflicting switching "
                    "command"
                )
        self._check_conflict(starting, stopping)
        for name in stopping:
            self._states[name] = STOPPED
            self._loaded[name].stop()
        self.hardware.read()
        for name in starting:
            self._states[name] = RUNNING
            try:
                self._loaded[name].start(self.time)
            except Exception as error:
                self._fail(self._loaded[name], error)
        self._sort()
        return skipped

    def _sort(self) -> None:
        """Note which of the running controllers are updated."""
        self._periodic = [
            controller
            for name, controller in self._loaded.items()
            if controller.periodic and self.is_running(name)
        ]
        self._updates = [each.update for each in self._periodic]

    def _check_conflict(self, starting: list[str], stopping: list[str]) -> None:
        """Raise ControllerError if two of the controllers that are to run claim a joint."""
        claims: dict[str, list[str]] = {}
        for name in self._loaded:
            if name in starting or (self.is_running(name) and name not in stopping):
                for joint in self._claims(name):
                    claims.setdefault(joint, []).append(name)
        conflicts = [
            f"Resource conflict on [{joint}].  Controllers = [{', '.join(names)}, ]"
            for joint, names in sorted(claims.items())
            if len(names) > 1
        ]
        if conflicts:
            raise ControllerError(
                "Could not switch controllers, due to resource conflict: " + "; ".join(conflicts)
            )

    def _select(
        self,
        action: str,
        names: Iterable[str],
        strict: bool,
        skipped: list[str],
        stopping: Sequence[str] = (),
    ) -> list[str]:
        """Those of the names that an action, "start" or "stop", is possible for.

        Args:
            stopping: those that are to stop.

        Raises:
            ControllerError: strict, and it is not for one of them.
        """
        chosen: list[str] = []
        for name in names:
            try:
                self._named(name, action)
                running = self.is_running(name)
                if action == "stop" and not running:
                    raise ControllerError(
                        f"Could not stop controller '{name}' since it is not running"
                    )
                if action == "start" and running and strict and name not in stopping:
                    raise ControllerError(f"Controller '{name}' is already running")
                if name not in chosen:
                    chosen.append(name)
            except ControllerError as error:
                if strict:
                    raise
                skipped.append(str(error))
        return chosen

    def _claims(self, name: str) -> list[str]:
        return [joint for _, joints in self._loaded[name].config.claims for joint in joints]

    def command(self, name: str, values: Any) -> None:
        """Pass a command to a running controller; a stopped one ignores it.

        Args:
            values: what its check() takes: numbers, or a trajectory.

        Raises:
            ControllerError: not loaded.
            CommandError: wrong count, NaN or out of bounds; the last command stays.
        """
        controller = self.get(name)
        try:
            values = controller.check(values)
            if self.is_running(name):
                controller.command(values)
        except SimError:
            raise
        except Exception as error:
            self._fail(controller, error)

    def _fail(self, controller: Controller, error: Exception) -> None:
        """Stop a controller that has raised an exception."""
        if self.on_failure is None:
            raise error
        name = controller.config.name
        if self._states[name] == RUNNING:
            self._states[name] = STOPPED
            for _, joints in controller.config.claims:
                self.hardware.release(joints)
            self._sort()
        self.on_failure(name, error)

    @property
    def periodic(self) -> bool:
        """Whether update() has to be called before every physics step."""
        return bool(self._periodic) or self.hardware.periodic

    def update(self, period: float) -> list[EffortRow]:
        """Before a physics step: update controllers that are due, with the joints as they are then.

        As GazeboRosControlPlugin::Update, which has gains' PIDs and limits follow in each step, by
        the joints' states of the last update.

        Args:
            period: physics step [s].

        Returns:
            Rows of the efforts that act in it.
        """
        hardware, time = self.hardware, self.time
        since_write = period
        if self._due or self._since >= self._period - 1e-9:
            hardware.read()
            elapsed = self._since if self._since > period else period
            if self._due:
                since_write = elapsed
            self._due, self._since = False, 0.0
            for update in self._updates:
                try:
                    update(time, elapsed)
                except Exception as error:
                    self._fail(update.__self__, error)  # type: ignore[attr-defined]
        if hardware.limited and not hardware.is_stopped:
            hardware.limit(period)
        efforts = hardware.efforts(since_write)
        self._pass(period)
        return efforts

    def _pass(self, period: float) -> None:
        """Let a step's time pass."""
        self.time += period
        self._since += period

    def prepare_steps(self, period: float) -> int:
        """Before physics steps: update controllers that are due, unless the engine can compute all
        that they would command: `efforts` are those that act, `computes` says whether PIDs of them
        are computed before each step.

        Args:
            period: physics step [s].

        Returns:
            How many steps may be made with them, at least 1.
        """
        steps = self._steps_until_update(period)
        self.computes = steps > 0
        if self.computes:
            self.efforts = self.hardware.efforts(period, computes=True)
            return steps
        self.efforts = self.update(period)
        regulated = any(joint.is_regulated for joint in self.hardware.acting)
        if regulated or not self._has_own_joints() or self.hardware.limited:
            return 1
        since, steps = self._since, 1  # as many as until the next update is due
        while not self._due and since < self._period - 1e-9:
            since, steps = since + period, steps + 1
        return steps

    def finish_steps(self, count: int, period: float, recorded: Array | None) -> None:
        """After physics steps that prepare_steps() has prepared.

        Args:
            recorded: positions and velocities (count, 2, n) of the joints before each of them;
                None: the engine has not computed PIDs.
        """
        if not self.computes or recorded is None:
            for _ in range(count - 1):
                self._pass(period)
            return
        self.hardware.take_steps(recorded, self.efforts)
        times = []
        for _ in range(count):
            times.append(self.time)
            self.time += period
        self._since = period
        names = self.hardware.joints.names
        for controller in self._periodic:
            positions = []
            if not controller.pids:
                order = [names.index(name) for name in controller.config.joints]
                positions = recorded[:, 0, order].tolist()
            controller.steps_made(times, period, positions)

    def _steps_until_update(self, period: float) -> int:
        """How many steps may be made, with what is commanded and what PIDs compute, before update()
        has to be called; 0: it has to be now.

        Args:
            period: physics step [s].
        """
        if self._due or self._period - 1e-9 > min(self._since, period):
            return 0
        if self.hardware.is_stopped or self.hardware.limited or not self._has_own_joints():
            return 0
        return min((each.steps_until_update(period) for each in self._periodic), default=MAX_STEPS)

    def _has_own_joints(self) -> bool:
        """Whether its joints are those of the robot, not those of steer_bot."""
        return self.hardware.joints is self._joints

    def observe(self) -> None:
        """Update odometry to the present, for publishing it."""
        self.hardware.read()
        for controller in self._periodic:
            controller.observe(self.time)

    def set_emergency_stop(self, active: bool) -> None:
        """Stop the joints; the running controllers start anew when it is no longer active.

        They go on running meanwhile, without effect, as in gazebo_ros_control.
        """
        if active == self.hardware.is_stopped:
            return
        self.hardware.read()
        self.hardware.set_emergency_stop(active)
        if not active:
            self._reset_running(self.time)

    def restart(self) -> None:
        """Give every running controller the state that it has right after its start."""
        self.time = self._since = 0.0
        self._due = True
        self.hardware.restart()
        self.hardware.read()
        self._reset_running(0.0)

    def forget_updates(self, time: float, by: float = 0.0) -> None:
        """Have the next update at the next step, with the time [s] as its period.

        So GazeboRosControlPlugin::Reset has it after a reset of its model: the update before counts
        as one at zero. Controllers are not restarted: the stamps of commands stay, and so does the
        time of the odometry, while what counts periods, as trajectories, jumps ahead.

        Args:
            by: how far simulated time went back [s].
        """
        self._due, self._since = True, time
        self.time += time
        for controller in self._loaded.values():
            controller.go_back(by, time)

    def _reset_running(self, time: float) -> None:
        for name, controller in self._loaded.items():
            if self.is_running(name):
                controller.reset(time)

    def controllers(self) -> tuple[Controller, ...]:
        """The loaded Controllers, in order of loading."""
        return tuple(self._loaded.values())

    def list(self) -> list[tuple[type[Controller], Any, str]]:
        """(class, configuration, state) of every loaded controller, in order of loading."""
        return [(type(c), c.config, self._states[name]) for name, c in self._loaded.items()]

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore a result of get_state() with the same controllers loaded."""
        super().set_state(state)
        self._sort()

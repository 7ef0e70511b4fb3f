"""Life cycles of a robot's controllers: load, start, stop, switch, unload, list."""

import dataclasses
import math

from bullet_sim.controllers import KINDS, make_controller, parse_controller
from bullet_sim.controllers.hardware import Hardware
from bullet_sim.errors import ControllerError

INITIALIZED, RUNNING, STOPPED = "initialized", "running", "stopped"


class Manager:
    """Controllers of one robot.

    Args:
        joints: bullet_sim.models.joints.Joints of the robot: limits, positions, motors.
        description: ModelDescription: sizes of wheels, <transmission>s, control period; None:
            every joint offers every interface.
        inertias: mapping joint name -> inertia that its effort moves, see description.inertias.

    Attributes:
        time: clock of the controllers [s]: simulated time during which periodic ones ran.
    """

    def __init__(self, joints, description=None, inertias=None):
        self._description = description
        self.hardware = Hardware(joints, getattr(description, "transmissions", None), inertias)
        self._period = getattr(description, "control_period", 0.0)
        self._loaded, self._states = {}, {}
        self._periodic = []  # the running controllers to be updated, in order of loading ...
        self._updates = []  # ... and the functions that this takes
        self.time = self._since = 0.0
        self._due = True

    @staticmethod
    def types():
        """Names of all controller types."""
        return list(KINDS)

    def load(self, name, config):
        """Check and add a controller, stopped.

        Returns:
            Its ControllerSpec.

        Raises:
            ControllerError: the name is taken, the configuration is wrong, or a joint does not
                offer the interface that it needs.
        """
        if name in self._loaded:
            raise ControllerError(f"controller '{name}' is loaded already")
        hardware = self.hardware
        spec = parse_controller(name, config, hardware.names, self._description)
        warnings = [
            text
            for interface, joints in spec.claims
            for text in hardware.check_interface(f"controller '{name}'", interface, joints)
        ]
        spec = dataclasses.replace(spec, warnings=(*spec.warnings, *warnings))
        self._loaded[name] = make_controller(spec, hardware)
        self._states[name] = INITIALIZED
        return spec

    def unload(self, name):
        """Remove a stopped controller.

        Raises:
            ControllerError: not loaded, or running.
        """
        self.get(name)
        if self._states[name] == RUNNING:
            raise ControllerError(f"controller '{name}' is running, stop it before unloading")
        del self._loaded[name], self._states[name]

    def get(self, name):
        """The Controller of that name.

        Raises:
            ControllerError: not loaded.
        """
        if name not in self._loaded:
            raise ControllerError(
                f"controller '{name}' is not loaded; loaded are "
                f"{', '.join(self._loaded) or '(none)'}"
            )
        return self._loaded[name]

    def control_period(self, time_step):
        """Time [s] between two updates of a controller, with a physics step [s]."""
        return max(1, math.ceil(self._period / time_step - 1e-6)) * time_step

    def is_running(self, name):
        """Whether a controller is loaded and running."""
        return self._states.get(name) == RUNNING

    def switch(self, start, stop, strict=True):
        """Stop and start controllers as one step.

        Args:
            start, stop: controller names.
            strict: True: an invalid name refuses the whole switch; False: it is left out.

        Returns:
            Reasons why names were left out (best effort).

        Raises:
            ControllerError: strict and a name is invalid; nothing has changed then.
        """
        left_out = []
        stopping = self._fitting(stop, strict, left_out, self.is_running, "is not running")
        starting = self._startable(start, stopping, strict, left_out)
        for name in stopping:
            self._states[name] = STOPPED
            self._loaded[name].stop()
        for name in starting:
            self._states[name] = RUNNING
            self._loaded[name].start(self.time)
        self._periodic = [
            controller
            for name, controller in self._loaded.items()
            if controller.periodic and self.is_running(name)
        ]
        self._updates = [update for each in self._periodic for update in each.updates]
        return left_out

    def _startable(self, start, stopping, strict, left_out):
        """The controllers of `start` whose joints are free once those of `stopping` stop."""
        claimed = {
            joint: name
            for name in self._loaded
            if self.is_running(name) and name not in stopping
            for joint in self._claims(name)
        }
        starting = []
        for name in self._fitting(
            start,
            strict,
            left_out,
            lambda n: not self.is_running(n) or n in stopping,
            "is running already",
        ):
            taken = [joint for joint in self._claims(name) if joint in claimed]
            if not taken:
                starting.append(name)
                claimed.update({joint: name for joint in self._claims(name)})
                continue
            rival = f"joint '{taken[0]}' is claimed by '{claimed[taken[0]]}'"
            reason = f"controller '{name}' cannot start: {rival}"
            if strict:
                raise ControllerError(reason)
            left_out.append(reason)
        return starting

    def _fitting(self, names, strict, left_out, fits, otherwise):
        chosen = []
        for name in names:
            try:
                self.get(name)
                if not fits(name):
                    raise ControllerError(f"controller '{name}' {otherwise}")
                if name not in chosen:
                    chosen.append(name)
            except ControllerError as error:
                if strict:
                    raise
                left_out.append(str(error))
        return chosen

    def _claims(self, name):
        return [joint for _, joints in self._loaded[name].spec.claims for joint in joints]

    def command(self, name, values):
        """Pass a command to a running controller; a stopped one ignores it.

        Args:
            name: the controller.
            values: what its check() takes: numbers, or a trajectory.

        Raises:
            ControllerError: not loaded.
            CommandError: wrong count, NaN or out of bounds; the last command stays.
        """
        controller = self.get(name)
        values = controller.check(values)
        if self.is_running(name):
            controller.command(values)

    @property
    def periodic(self):
        """Whether update() has to be called before every physics step."""
        return bool(self._periodic) or self.hardware.periodic

    def update(self, period):
        """Before a physics step: update controllers that are due, then write the joints' efforts.

        Args:
            period: physics step [s].
        """
        state, time = self.hardware.state(), self.time
        elapsed = 0.0
        if self._due or self._since >= self._period - 1e-9:
            elapsed = self._since if self._since > period else period
            self._due, self._since = False, 0.0
            for update in self._updates:
                update(state, time, elapsed)
        self.hardware.write(state, elapsed)
        self.time = time + period
        self._since += period

    def observe(self):
        """Update odometry to the present, for publishing it."""
        state = self.hardware.state()
        for controller in self._periodic:
            controller.observe(state, self.time)

    def restart(self):
        """Give every running controller the state that it has right after its start."""
        self.time = self._since = 0.0
        self._due = True
        self.hardware.restart()
        for name, controller in self._loaded.items():
            if self.is_running(name):
                controller.restart(0.0)

    def controllers(self):
        """The loaded Controllers, in order of loading."""
        return tuple(self._loaded.values())

    def list(self):
        """(ControllerSpec, state) of every loaded controller, in order of loading."""
        return [(controller.spec, self._states[name]) for name, controller in self._loaded.items()]

    def running_state_controllers(self):
        """ControllerSpecs of the running joint state controllers."""
        return [
            controller.spec
            for name, controller in self._loaded.items()
            if self.is_running(name) and controller.spec.kind.interface == "state"
        ]

"""Life cycles of a robot's controllers: load, start, stop, switch, unload, list."""

from dataclasses import dataclass, field
from typing import Tuple

from bullet_sim.controllers import KINDS, ControllerSpec, check_command, parse_controller
from bullet_sim.errors import ControllerError

INITIALIZED, RUNNING, STOPPED = 'initialized', 'running', 'stopped'


@dataclass
class _Loaded:
    spec: ControllerSpec
    state: str = INITIALIZED
    command: Tuple[float, ...] = field(default_factory=tuple)


class Manager:
    """Controllers of one robot.

    Args:
        joints: bullet_sim.joints.Joints of the robot: limits, positions, motors.
    """

    def __init__(self, joints):
        self._joints = joints
        self._loaded = {}

    @staticmethod
    def types():
        """Names of all controller types."""
        return list(KINDS)

    def load(self, name, config):
        """Check and add a controller, stopped.

        Returns:
            Its ControllerSpec.

        Raises:
            ControllerError: the name is taken or the configuration is wrong.
        """
        if name in self._loaded:
            raise ControllerError(f"controller '{name}' is loaded already")
        spec = parse_controller(name, config, self._joints.names)
        self._loaded[name] = _Loaded(spec, command=(0.0,) * len(spec.joints))
        return spec

    def unload(self, name):
        """Forget a stopped controller.

        Raises:
            ControllerError: not loaded, or running.
        """
        if self._get(name).state == RUNNING:
            raise ControllerError(f"controller '{name}' is running, stop it before unloading")
        del self._loaded[name]

    def _get(self, name):
        if name not in self._loaded:
            raise ControllerError(f"controller '{name}' is not loaded; loaded are "
                                  f"{', '.join(self._loaded) or '(none)'}")
        return self._loaded[name]

    def switch(self, start, stop, strict=True):
        """Stop and start controllers as one step.

        Args:
            start, stop: controller names.
            strict: True: any name that does not fit refuses all; False: such names are left out.

        Returns:
            Reasons of what was left out (best effort).

        Raises:
            ControllerError: strict, and something does not fit; nothing has changed then.
        """
        left_out = []
        stopping = self._fitting(stop, strict, left_out, lambda c: c.state == RUNNING,
                                 'is not running')
        staying = {joint: name for name, c in self._loaded.items()
                   if c.state == RUNNING and name not in stopping for joint in self._claims(c)}
        starting = []
        for name in self._fitting(start, strict, left_out,
                                  lambda c: c.state != RUNNING or c.spec.name in stopping,
                                  'is running already'):
            rival = next((f"joint '{j}' is claimed by '{staying[j]}'"
                          for j in self._claims(self._loaded[name]) if j in staying), None)
            if rival is None:
                starting.append(name)
                staying.update({j: name for j in self._claims(self._loaded[name])})
                continue
            reason = f"controller '{name}' cannot start: {rival}"
            if strict:
                raise ControllerError(reason)
            left_out.append(reason)
        for name in stopping:
            self._stop(self._loaded[name])
        for name in starting:
            self._start(self._loaded[name])
        return left_out

    def _fitting(self, names, strict, left_out, fits, otherwise):
        chosen = []
        for name in names:
            try:
                loaded = self._get(name)
                if not fits(loaded):
                    raise ControllerError(f"controller '{name}' {otherwise}")
                chosen.append(name)
            except ControllerError as error:
                if strict:
                    raise
                left_out.append(str(error))
        return chosen

    @staticmethod
    def _claims(loaded):
        return () if loaded.spec.kind.interface == 'state' else loaded.spec.joints

    def _start(self, loaded):
        loaded.state = RUNNING
        if loaded.spec.kind.interface == 'position':
            loaded.command = self._joints.positions_of(loaded.spec.joints)
        else:
            loaded.command = (0.0,) * len(loaded.spec.joints)
        self._write(loaded)

    def _stop(self, loaded):
        loaded.state = STOPPED
        if loaded.spec.kind.interface != 'state':
            self._joints.release(loaded.spec.joints)

    def command(self, name, values):
        """Give a running controller its command; a stopped one ignores it.

        Raises:
            ControllerError: not loaded.
            CommandError: wrong count, NaN or infinite; the last command stays.
        """
        loaded = self._get(name)
        values = check_command(name, values, len(loaded.spec.joints))
        if loaded.state == RUNNING and values != loaded.command:
            loaded.command = values
            self._write(loaded)

    def _write(self, loaded):
        if loaded.spec.kind.interface == 'velocity':
            self._joints.drive_velocities(loaded.spec.joints, loaded.command)
        elif loaded.spec.kind.interface == 'position':
            self._joints.drive_positions(loaded.spec.joints, loaded.command)

    @property
    def periodic(self):
        """Whether a running controller has to be updated before every physics step."""
        return False

    def update(self, period):
        """Update the periodic controllers; `period` [s] since the last time."""

    def restart(self):
        """Give every running controller the state that it has right after its start."""
        for loaded in self._loaded.values():
            if loaded.state == RUNNING:
                self._start(loaded)

    def list(self):
        """(ControllerSpec, state) of every loaded controller, in order of loading."""
        return [(loaded.spec, loaded.state) for loaded in self._loaded.values()]

    def running_state_controllers(self):
        """ControllerSpecs of the running joint state controllers."""
        return [loaded.spec for loaded in self._loaded.values()
                if loaded.state == RUNNING and loaded.spec.kind.interface == 'state']

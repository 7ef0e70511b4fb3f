"""What all controllers share: life cycle, the check of their configuration, the registry."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, ClassVar

from bullet_sim.component import Component
from bullet_sim.controllers.hardware import Hardware
from bullet_sim.controllers.interfaces import INTERFACES
from bullet_sim.controllers.settings import ControllerConfig, Settings
from bullet_sim.description.model import ModelDescription
from bullet_sim.errors import CommandError, ControllerError, SimError
from bullet_sim.registry import Registry

MAX_STEPS = 2**31  # physics steps: more than are ever made at once
MAX_COMMAND = 1e9  # larger commands [rad/s, m/s, rad, m, N m, N] are refused


def check_command(name: str, values: Iterable[float], counts: Sequence[int]) -> tuple[float, ...]:
    """Check a command.

    Args:
        values: numbers [rad/s, m/s, rad, m, N m, N].
        counts: how many there may be.

    Raises:
        CommandError: wrong count, NaN or beyond MAX_COMMAND.
    """
    values = tuple(float(value) for value in values)
    if len(values) not in counts:
        expected = " or ".join(map(str, counts))
        raise CommandError(f"command of '{name}' has {len(values)} values, must have {expected}")
    for value in values:
        if not abs(value) <= MAX_COMMAND:
            raise CommandError(
                f"command of '{name}' is {value}, must be a finite number, at most "
                f"{MAX_COMMAND:g} either way; the last good command stays"
            )
    return values


class Controller(Component):
    """A loaded controller.

    A subclass defines in `configure` what its entry in the YAML file has to contain, and in
    `update` what it does. Joints' positions and velocities are those of the last update, or start.

    Attributes:
        interface: a key of INTERFACES: what it commands (velocity, position, effort) or reports.
        periodic: update() is called before physics steps.
        group: its command topic takes a list, also of one joint.
        joints: a JointHandle for each of config.joints.
        setters: functions that command the joints of config.claims, in their order.
        pids: its Pids, whose gains can be changed at run time.
    """

    interface: ClassVar[str]
    periodic: ClassVar[bool] = False
    group: ClassVar[bool] = False

    pids: tuple[Any, ...] = ()

    @classmethod
    def configure(
        cls,
        settings: Settings,
        joints: tuple[str, ...],
        description: ModelDescription | None,
    ) -> ControllerConfig:
        """Check an entry of the YAML file.

        Args:
            joints: names of the robot's movable joints.
            description: of the robot, for what the entry does not contain; None: it has to.

        Raises:
            ControllerError: names the key, the value and what is valid.
        """
        raise NotImplementedError

    def __init__(self, config: Any, hardware: Hardware) -> None:
        self.config, self.hardware = config, hardware
        self.joints = hardware.handles(config.joints)
        self.setters = [
            getattr(joint, f"set_{interface}")
            for interface, names in config.claims
            for joint in hardware.handles(names)
        ]

    def stop(self) -> None:
        """Leave its joints their last commands, as a controller of ros_control does whose
        stopping() does nothing."""
        for _, joints in self.config.claims:
            self.hardware.keep(joints)

    def check(self, values: Any) -> Any:
        """Check a command: by default a number for each joint; returns them as floats.

        Raises:
            CommandError: wrong count, NaN or out of bounds.
        """
        return check_command(self.config.name, values, (len(self.config.joints),))

    def command(self, values: Any) -> None:
        """Set a checked command."""

    def write(self, values: Iterable[float]) -> None:
        """Command the joints of config.claims, in their order."""
        for set_command, value in zip(self.setters, values):
            set_command(value)

    def go_back(self, by: float, since: float) -> None:
        """The simulated time, and with it that of its stamps, went back, or an update is forgotten.

        Args:
            by: how far [s].
            since: that the manager's time jumps ahead, which is the period of the next update [s].
        """

    def observe(self, time: float) -> None:
        """Update what is published to the joints' present state; nothing is commanded."""

    def steps_until_update(self, period: float) -> int:
        """How many physics steps may be made before update() has to be called, since it would
        command nothing new but what the joints' PIDs compute; 0: it has to be called before each.

        Args:
            period: physics step [s].
        """
        return 0

    def steps_made(
        self, times: Sequence[float], period: float, positions: Sequence[Sequence[float]]
    ) -> None:
        """Such steps were made: do what update() would have done before each, but for commands.

        Args:
            times: of the manager before each of them [s].
            positions: of the joints then [rad, m]; PIDs have theirs.
        """


CONTROLLERS: Registry[type[Controller]] = Registry("controller type")


def register_variant(name: str, base: type[Controller], **facts: Any) -> None:
    """Enter a subclass that differs by class attributes alone, `facts`, under a type's name."""
    CONTROLLERS.register(name)(type(name.rpartition("/")[2], (base,), facts))


def configure(
    name: str,
    values: Any,
    joints: Sequence[str],
    description: ModelDescription | None = None,
) -> tuple[type[Controller], Any]:
    """Check one controller's entry in the YAML file.

    Args:
        description: for the wheels' sizes; None: they must be configured.

    Returns:
        Class of the controller, its configuration.

    Raises:
        ControllerError: names the entry, the value and what would be valid.
    """
    label = f"controller '{name}'"
    if not isinstance(values, dict):
        raise ControllerError(
            f"{label} has configuration {values!r}, must be a mapping with type and joint"
        )
    settings = Settings(values, label, name)
    type_name = str(settings.get("type"))
    try:
        controller_type = CONTROLLERS.find(type_name)
    except KeyError:
        raise ControllerError(
            f"{label} has type '{values.get('type')}', must be one of "
            f"{', '.join(CONTROLLERS.names())}"
        ) from None
    try:
        config = controller_type.configure(settings, tuple(joints), description)
    except SimError:
        raise
    except Exception as error:  # of a class of another package
        raise ControllerError(
            f"{label} cannot be configured, its class raises {type(error).__name__}: {error}"
        ) from error
    interface = getattr(controller_type, "interface", None)
    if interface not in INTERFACES or not isinstance(config, ControllerConfig):
        raise ControllerError(
            f"{label} has a class with interface {interface!r} and configuration {config!r}, must "
            f"be one of {', '.join(INTERFACES)} and a ControllerConfig"
        )
    warnings = (*config.warnings, *settings.unknown())
    return controller_type, replace(config, type=type_name, warnings=warnings)

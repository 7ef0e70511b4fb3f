"""What all controllers share: configuration, life cycle, the registry of their types."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from bullet_sim.component import Component
from bullet_sim.description.model import ModelDescription
from bullet_sim.errors import CommandError, ControllerError, SimError
from bullet_sim.registry import Registry

if TYPE_CHECKING:
    from bullet_sim.controllers.hardware import Hardware

INTERFACES = {
    "velocity": "hardware_interface::VelocityJointInterface",
    "position": "hardware_interface::PositionJointInterface",
    "effort": "hardware_interface::EffortJointInterface",
    "state": "hardware_interface::JointStateInterface",
    "imu": "hardware_interface::ImuSensorInterface",
    "force_torque": "hardware_interface::ForceTorqueSensorInterface",
}
ENDLESS = 2**31  # steps
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


def as_number(value: Any) -> float | None:
    """The value as a finite float, or None.

    YAML 1.1 reads 1e6 and 1.0e6 as strings (it requires 1.0e+6), so a numeric string counts.
    """
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            return None
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    try:
        value = float(value)
    except OverflowError:  # an integer of 400 digits
        return None
    return value if math.isfinite(value) else None


class Settings:
    """One mapping of a YAML file.

    Args:
        label: name for messages, e.g. "controller 'drive'".

    Attributes:
        name: of the controller whose settings these are.

    Raises:
        ControllerError: it is no mapping.
    """

    def __init__(self, values: Any, label: str, name: str = "") -> None:
        if not isinstance(values, dict):
            raise ControllerError(f"{label} is {values!r}, must be a mapping")
        self.label, self.name = label, name
        self._values: dict[Any, Any] = values
        self._asked: set[str] = set()
        self._blocks: list[Settings] = []

    def get(self, key: str, default: Any = None) -> Any:
        """A value as it is."""
        self._asked.add(key)
        return self._values.get(key, default)

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def number(self, key: str, default: Any, above: float | None = None) -> Any:
        """A finite number; the default, unchecked, if it is missing.

        Args:
            above: exclusive minimum.
        """
        self._asked.add(key)
        if key not in self._values:
            return default
        value = as_number(self._values[key])
        if value is None or (above is not None and value <= above):
            expected = "a finite number" if above is None else f"a number above {above:g}"
            raise ControllerError(
                f"{self.label} has {key} {self._values[key]!r}, must be {expected}"
            )
        return value

    def flag(self, key: str, default: bool) -> bool:
        """True or false."""
        value = self.get(key, default)
        if not isinstance(value, bool):
            raise ControllerError(f"{self.label} has {key} {value!r}, must be true or false")
        return value

    def text(self, key: str, default: str | None) -> str:
        """A string that is not empty."""
        value = self.get(key, default)
        if not isinstance(value, str) or not value:
            raise ControllerError(f"{self.label} has {key} {value!r}, must be a name")
        return value

    def rate(self) -> float:
        """The publish_rate [Hz]."""
        value: float = self.number("publish_rate", 50.0, above=0.0)
        return value

    def joint(self, key: str, known: Sequence[str]) -> str:
        """The name of one of the robot's movable joints; `known` are all of them."""
        name: str = self.get(key)
        if name is None:
            raise ControllerError(f"{self.label} has {key} {name!r}, must be a joint name")
        check_joints([name], self.label, known)
        return name

    def joints(self, key: str, known: Sequence[str]) -> tuple[str, ...]:
        """As joint(), of a list of at least one."""
        names = self.get(key)
        if not isinstance(names, list) or not names:
            raise ControllerError(
                f"{self.label} has {key} {names!r}, must be a list of joint names"
            )
        check_joints(names, self.label, known)
        return tuple(names)

    def block(self, *keys: str) -> "Settings":
        """Settings of a mapping within this one; a missing one is empty."""
        inner = self
        for key in keys:
            block = Settings(inner.get(key, {}), f"{inner.label} {key}")
            inner._blocks.append(block)
            inner = block
        return inner

    def ignore(self, *keys: str) -> list[str]:
        """Mark keys as known; returns those that are present."""
        self._asked.update(keys)
        return [key for key in keys if key in self._values]

    def unknown(self) -> list[str]:
        """A message for each key that was not read, also in nested blocks."""
        unread = [
            f"{self.label} has key '{key}', which means nothing here and is ignored"
            for key in sorted(set(self._values) - self._asked, key=str)
        ]
        return unread + [text for block in self._blocks for text in block.unknown()]


def check_joints(joints: Sequence[Any], label: str, known: Sequence[str]) -> None:
    """Check joints' names.

    Raises:
        ControllerError: one does not exist or is there twice.
    """
    for number, joint in enumerate(joints):
        if joint not in known:
            raise ControllerError(
                f"{label} names joint '{joint}', which does not exist; joints "
                f"are {', '.join(known) or '(none)'}"
            )
        if joint in joints[:number]:
            raise ControllerError(f"{label} names joint '{joint}' twice, must be once")


@dataclass(frozen=True, kw_only=True)
class ControllerConfig:
    """One checked entry of the controllers' YAML; types of controllers add their own fields.

    Attributes:
        name: the entry's key.
        type: its ros_control name.
        joints: joint names; empty for a state controller that reports all.
        claims: (interface, joint names) pairs; empty for a controller that commands nothing.
        publish_rate: of what it reports [Hz].
        notes: messages about keys that are accepted without effect.
        warnings: messages about keys that are ignored.
    """

    name: str
    type: str = ""
    joints: tuple[str, ...] = ()
    claims: tuple[tuple[str, tuple[str, ...]], ...] = ()
    publish_rate: float = 50.0
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


class Controller(Component):
    """A loaded controller.

    A subclass defines in `configure` what its entry in the YAML file has to contain, and in
    `update` what it does. Joints' positions and velocities are those of the last update, or start.

    Attributes:
        interface: a key of INTERFACES: what it commands (velocity, position, effort) or reports.
        periodic: update() is called before physics steps.
        group: its command topic takes a list, also of one joint.
        limits_rate: a publish_rate above one message per physics step is refused.
        joints: a JointHandle for each of config.joints.
        pids: its Pids, whose gains can be changed at run time.
    """

    interface: ClassVar[str]
    periodic: ClassVar[bool] = False
    group: ClassVar[bool] = False
    limits_rate: ClassVar[bool] = False

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

    def __init__(self, config: Any, hardware: "Hardware") -> None:
        self.config, self.hardware = config, hardware
        self.joints = hardware.handles(config.joints)

    def stop(self) -> None:
        """Release the joints."""
        for _, joints in self.config.claims:
            self.hardware.release(joints)

    def check(self, values: Any) -> Any:
        """Check a command: by default a number for each joint; returns them as floats.

        Raises:
            CommandError: wrong count, NaN or out of bounds.
        """
        return check_command(self.config.name, values, (len(self.config.joints),))

    def command(self, values: Any) -> None:
        """Set a checked command."""

    def observe(self, time: float) -> None:
        """Update what is published to the joints' present state; nothing is commanded."""

    def steady_steps(self, period: float) -> int:
        """How many physics steps may be made until update() commands something else than its PIDs
        compute; 0: unknown, update() has to be called before each.

        Args:
            period: physics step [s].
        """
        return 0

    def catch_up(
        self, times: Sequence[float], period: float, positions: Sequence[Sequence[float]]
    ) -> None:
        """What update() would have done before each of several steps, but for commands.

        Args:
            times: of the manager before each of them [s].
            positions: of the joints then [rad, m]; PIDs have theirs.
        """


CONTROLLERS: Registry[type[Controller]] = Registry("controller type")


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

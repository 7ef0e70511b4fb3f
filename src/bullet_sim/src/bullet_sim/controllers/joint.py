"""Controllers of joints: states and sensors reported, commands forwarded, or through a PID."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from bullet_sim.controllers.base import CONTROLLERS, MAX_STEPS, Controller, register_variant
from bullet_sim.controllers.handle import JointHandle
from bullet_sim.controllers.hardware import Hardware
from bullet_sim.controllers.pid import Pid, PidConfig, parse_pid, position_error
from bullet_sim.controllers.settings import ControllerConfig, Settings, check_joints
from bullet_sim.description.model import ModelDescription
from bullet_sim.errors import ControllerError


@dataclass(frozen=True)
class JointStateConfig(ControllerConfig):
    """Configuration of a joint state controller.

    Attributes:
        extra_joints: (name, position, velocity, effort) added to joint states.
    """

    extra_joints: tuple[tuple[str, float, float, float], ...] = ()


@CONTROLLERS.register("joint_state_controller/JointStateController")
class JointState(Controller):
    """Reports joints' states; commands nothing."""

    interface = "state"

    @classmethod
    def configure(
        cls, settings: Settings, joints: tuple[str, ...], description: ModelDescription | None
    ) -> JointStateConfig:
        requested = settings.get("joints") or []
        if not isinstance(requested, list):
            raise ControllerError(
                f"{settings.label} has joints {requested!r}, must be a list of joint names"
            )
        check_joints(requested, settings.label, joints)
        settings.ignore("interface_name")
        extra_joints, warnings = _extra_joints(settings)
        return JointStateConfig(
            name=settings.name,
            joints=tuple(requested),
            publish_rate=_needed_rate(settings),
            extra_joints=extra_joints,
            warnings=warnings,
        )


def _needed_rate(settings: Settings) -> float:
    """The publish_rate [Hz], without which upstream refuses these controllers."""
    if "publish_rate" not in settings:
        raise ControllerError(
            f"Parameter 'publish_rate' not set: {settings.label} has no publish_rate, which "
            f"{settings.get('type')} needs [Hz]"
        )
    return settings.rate()


def _extra_joints(
    settings: Settings,
) -> tuple[tuple[tuple[str, float, float, float], ...], tuple[str, ...]]:
    """(name, position, velocity, effort) of each usable entry of extra_joints, and warnings.

    As upstream an entry without a name, with a name that is there already, or with a value that is
    no double (0 is none, 0.0 is one) is ignored, as is a value of another type than a list.
    """
    rows: dict[str, tuple[str, float, float, float]] = {}
    warnings: list[str] = []
    extra = settings.get("extra_joints", [])
    if not isinstance(extra, list):
        return (), (f"{settings.label} has extra_joints {extra!r}, must be a list; it is ignored",)
    for number, item in enumerate(extra):
        try:
            entry = Settings(item, f"{settings.label} extra_joints #{number}")
            name = entry.text("name", None)
            position, velocity, effort = (
                entry.number(key, 0.0) for key in ("position", "velocity", "effort")
            )
            for key in ("position", "velocity", "effort"):
                if key in entry and not isinstance(entry.get(key), float):
                    raise ControllerError(
                        f"Extra joint '{name}' does not specify a valid default {key}: "
                        f"{entry.get(key)!r} must be a number with a point"
                    )
        except ControllerError as error:
            warnings.append(f"{error}; it is ignored")
            continue
        warnings += entry.unknown()
        if name in rows:
            warnings.append(f"{entry.label} has name '{name}' a second time; it is ignored")
        rows.setdefault(name, (name, position, velocity, effort))
    return tuple(rows.values()), tuple(warnings)


class SensorController(Controller):
    """Reports all of a robot's sensors whose specifications have its `interface`.

    Attributes:
        sensor_names: for such sensors, in messages.
    """

    sensor_names: ClassVar[str]

    @classmethod
    def configure(
        cls, settings: Settings, joints: tuple[str, ...], description: ModelDescription | None
    ) -> ControllerConfig:
        sensors = () if description is None else description.sensors
        if not any(getattr(spec, "INTERFACE", "") == cls.interface for spec in sensors):
            raise ControllerError(
                f"{settings.label} publishes {cls.sensor_names}, of which the robot has none"
            )
        return ControllerConfig(name=settings.name, publish_rate=_needed_rate(settings))


@CONTROLLERS.register("imu_sensor_controller/ImuSensorController")
class ImuController(SensorController):
    """Reports IMUs."""

    interface, sensor_names = "imu", "IMUs"


@CONTROLLERS.register("force_torque_sensor_controller/ForceTorqueSensorController")
class ForceTorqueController(SensorController):
    """Reports forces and torques of joints."""

    interface = "force_torque"
    sensor_names = "force and torque of joints (libgazebo_ros_ft_sensor.so)"


class JointCommand(Controller):
    """Base of controllers with a command for each of their joints."""

    goal: ClassVar[str | None] = None  # what a PID regulates, position or velocity; None: no PID

    @classmethod
    def configure(
        cls, settings: Settings, joints: tuple[str, ...], description: ModelDescription | None
    ) -> PidConfig:
        label, type_name = settings.label, settings.get("type")
        warnings: list[str] = []
        names = (
            settings.joints("joints", joints) if cls.group else (settings.joint("joint", joints),)
        )
        settings.ignore("publish_rate")
        requested = settings.get("interface_name")
        if requested not in (None, cls.interface):
            raise ControllerError(
                f"{label} has interface_name '{requested}', must be '{cls.interface}' for "
                f"{type_name}"
            )
        config = PidConfig(name=settings.name, joints=names, claims=((cls.interface, names),))
        if cls.goal is None:
            if "pid" not in settings:
                return config
            parse_pid(settings.get("pid"), label, warnings)
            note = (
                f"{label}: pid is accepted and not used, as upstream: {type_name} passes its "
                "command to the joint within the limits of the URDF"
            )
            return replace(config, notes=(note,), warnings=tuple(warnings))
        gains, published = [], []
        for name in names:
            block = settings.block(name) if cls.group else settings
            if "pid" not in block:
                raise ControllerError(
                    f"{block.label} has no pid, which {type_name} needs: a mapping with p, i, d"
                )
            values = block.get("pid")
            gains.append(parse_pid(values, block.label, warnings))
            published.append(values.get("publish_state") is True)
        return replace(
            config,
            gains=tuple(gains),
            gain_names=tuple(f"{name}/pid" for name in names) if cls.group else ("pid",),
            publish_pid=tuple(published),
            warnings=tuple(warnings),
        )


class Forward(JointCommand):
    """Forwards its command to the joints: velocities, positions or efforts."""

    STATE = ("_command",)

    def __init__(self, config: PidConfig, hardware: Hardware) -> None:
        super().__init__(config, hardware)
        self._command: tuple[float, ...] = ()

    def start(self, time: float) -> None:
        """Position commands start at the present positions, velocities and efforts at 0."""
        if self.interface == "position":
            self._command = tuple(joint.position for joint in self.joints)
        else:
            self._command = (0.0,) * len(self.joints)
        self.write(self._command)

    def command(self, values: tuple[float, ...]) -> None:
        """Write a command that differs from the last."""
        if values != self._command:
            self._command = values
            self.write(values)


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


class PidControl(JointCommand):
    """Base of controllers that regulate each joint by a PID."""

    STATE = ("_last", "pids")
    periodic = True
    goal: ClassVar[str]

    def __init__(self, config: PidConfig, hardware: Hardware) -> None:
        super().__init__(config, hardware)
        self.pids = tuple(Pid(gains, self.goal) for gains in config.gains)
        self._last: tuple[float, ...] | None = None

    def start(self, time: float) -> None:
        """Hold the joints where they are, or at rest."""
        for pid, joint in zip(self.pids, self.joints):
            pid.reset()
            pid.target = joint.position if self.goal == "position" else 0.0
            if self.interface == "effort":
                joint.set_effort(0.0, pid)
            else:
                joint.set_velocity(0.0)
        self._last = None

    def command(self, values: tuple[float, ...]) -> None:
        """Set new set points."""
        for pid, value in zip(self.pids, values):
            pid.target = value

    def update(self, time: float, period: float) -> None:
        """One computation of each PID."""
        by_effort = self.interface == "effort"
        for pid, joint in zip(self.pids, self.joints):
            measured = self._measure(pid, joint)
            output = pid.update(measured[3], period)
            if by_effort:
                joint.set_effort(output, pid)
            else:
                joint.set_velocity(output)
            self._last = time, period, *measured, output

    def steps_until_update(self, period: float) -> int:
        """Any number: PIDs are all that it computes, if a subclass does no more."""
        is_one = type(self).update is PidControl.update
        return MAX_STEPS if is_one and self.interface == "effort" else 0

    def steps_made(
        self, times: Sequence[float], period: float, positions: Sequence[Sequence[float]]
    ) -> None:
        """As Controller's; the PIDs have been computed."""
        pid = self.pids[-1]
        self._last = times[-1], period, *self._measure(pid, self.joints[-1]), pid.output

    def _measure(self, pid: Pid, joint: JointHandle) -> tuple[float, float, float, float]:
        """Set point, process value, its rate and the error of a PID."""
        raise NotImplementedError

    @property
    def sample(self) -> Sample | None:
        """Sample of the last joint; None before the first update."""
        return None if self._last is None else Sample(*self._last)


class PositionPid(PidControl):
    """Regulates positions."""

    goal = "position"

    def _measure(self, pid: Pid, joint: JointHandle) -> tuple[float, float, float, float]:
        limits, target = joint.limits, pid.target
        lower, upper = limits.lower, limits.upper
        if lower is not None and upper is not None:
            target = lower if target < lower else upper if target > upper else target
        error = position_error(limits, joint.position, target)
        return target, joint.position, joint.velocity, error


class VelocityPid(PidControl):
    """Regulates velocities."""

    goal = "velocity"

    def _measure(self, pid: Pid, joint: JointHandle) -> tuple[float, float, float, float]:
        return pid.target, joint.velocity, 0.0, pid.target - joint.velocity


# types of ros_control: class, interface, whether they have several joints
for _type, _class, _interface, _group in (
    ("velocity_controllers/JointVelocityController", Forward, "velocity", False),
    ("velocity_controllers/JointGroupVelocityController", Forward, "velocity", True),
    ("velocity_controllers/JointPositionController", PositionPid, "velocity", False),
    ("position_controllers/JointPositionController", Forward, "position", False),
    ("position_controllers/JointGroupPositionController", Forward, "position", True),
    ("effort_controllers/JointEffortController", Forward, "effort", False),
    ("effort_controllers/JointGroupEffortController", Forward, "effort", True),
    ("effort_controllers/JointPositionController", PositionPid, "effort", False),
    ("effort_controllers/JointGroupPositionController", PositionPid, "effort", True),
    ("effort_controllers/JointVelocityController", VelocityPid, "effort", False),
):
    register_variant(_type, _class, interface=_interface, group=_group)

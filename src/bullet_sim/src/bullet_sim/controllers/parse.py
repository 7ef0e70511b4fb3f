"""Entries of the controllers' YAML -> ControllerSpecs."""

from bullet_sim.controllers.base import Settings
from bullet_sim.controllers.drive import parse_ackermann, parse_diff
from bullet_sim.controllers.four_wheel import parse_four_wheel
from bullet_sim.controllers.gripper import parse_gripper
from bullet_sim.controllers.kinds import KINDS, ControllerSpec
from bullet_sim.controllers.pid import parse_pid
from bullet_sim.controllers.trajectory import parse_trajectory
from bullet_sim.errors import ControllerError
from bullet_sim.plugins.forces import ForceTorqueSpec
from bullet_sim.plugins.inertial import ImuSpec

_SENSORS = {  # interface -> specification and words for it
    "imu": (ImuSpec, "IMUs"),
    "force_torque": (ForceTorqueSpec, "force and torque of joints (libgazebo_ros_ft_sensor.so)"),
}
_DRIVES = {"diff": parse_diff, "ackermann": parse_ackermann, "four_wheel": parse_four_wheel}


def parse_controller(name, config, joint_names, description=None):
    """Check one controller's configuration.

    Args:
        name: controller name.
        config: mapping from the YAML file.
        joint_names: movable joints of the robot.
        description: ModelDescription, for the wheels' sizes; None: they must be configured.

    Raises:
        ControllerError: names the entry, the value and what would be valid.
    """
    what = f"controller '{name}'"
    if not isinstance(config, dict):
        raise ControllerError(
            f"{what} has configuration {config!r}, must be a mapping with type and joint"
        )
    settings = Settings(config, what)
    kind = KINDS.get(str(settings.get("type")))
    if kind is None:
        raise ControllerError(
            f"{what} has type '{config.get('type')}', must be one of {', '.join(KINDS)}"
        )
    if kind.interface == "state":
        values = _state(settings, joint_names)
    elif kind.reports_sensors:
        values = _sensors(settings, kind, description)
    elif kind.drive:
        values = _drive(settings, kind, joint_names, description)
    elif kind.action:
        values = _action(settings, kind, joint_names)
    else:
        values = _command(settings, kind, joint_names)
    values["warnings"] = (*values.get("warnings", ()), *settings.unknown())
    return ControllerSpec(name, kind, **values)


def _state(settings, joint_names):
    wanted = settings.get("joints") or []
    if not isinstance(wanted, list):
        raise ControllerError(
            f"{settings.what} has joints {wanted!r}, must be a list of joint names"
        )
    check_joints(wanted, settings.what, joint_names)
    settings.ignore("interface_name")
    extra = settings.get("extra_joints", [])
    if not isinstance(extra, list):
        raise ControllerError(f"{settings.what} has extra_joints {extra!r}, must be a list")
    rows, warnings = [], []
    for number, item in enumerate(extra):
        row = Settings(item, f"{settings.what} extra_joints #{number}")
        rows.append(
            (
                row.text("name", None),
                row.number("position", 0.0),
                row.number("velocity", 0.0),
                row.number("effort", 0.0),
            )
        )
        warnings += row.unknown()
    return {
        "joints": tuple(wanted),
        "publish_rate": rate(settings),
        "extra_joints": tuple(rows),
        "warnings": warnings,
    }


def _sensors(settings, kind, description):
    sort, words = _SENSORS[kind.interface]
    if not any(isinstance(spec, sort) for spec in getattr(description, "sensors", ())):
        raise ControllerError(f"{settings.what} publishes {words}, of which the robot has none")
    if settings.number("publish_rate", None, above=0.0) is None:
        raise ControllerError(f"{settings.what} has no publish_rate, which {kind.type} needs [Hz]")
    return {"publish_rate": rate(settings)}


def rate(settings):
    """The publish_rate [Hz]."""
    return settings.number("publish_rate", 50.0, above=0.0)


def _drive(settings, kind, joint_names, description):
    drive, claims, notes = _DRIVES[kind.drive](settings, description)
    joints = tuple(joint for _, names in claims for joint in names)
    check_joints(joints, settings.what, joint_names)
    return {
        "joints": joints,
        "publish_rate": rate(settings),
        "drive": drive,
        "claims": claims,
        "notes": notes,
    }


def _action(settings, kind, joint_names):
    joints, warnings = _joints(settings, kind, joint_names), []
    regulated = kind.interface != "position"
    if kind.action == "trajectory":
        config, gains, state_rate = parse_trajectory(settings, joints, regulated, warnings)
    else:
        config, gains = parse_gripper(settings, joints, regulated, warnings)
        state_rate = config.monitor_rate
    return {
        "joints": joints,
        "publish_rate": state_rate,
        "claims": ((kind.interface, joints),),
        "gains": gains,
        "publish_pid": (False,) * len(gains),
        "action": config,
        "warnings": warnings,
    }


def _command(settings, kind, joint_names):
    what, notes, warnings = settings.what, [], []
    joints = _joints(settings, kind, joint_names)
    settings.ignore("publish_rate")
    wanted = settings.get("interface_name")
    if wanted not in (None, kind.interface):
        raise ControllerError(
            f"{what} has interface_name '{wanted}', must be '{kind.interface}' for {kind.type}"
        )
    pids = []
    if kind.goal:
        for joint in joints:
            holder = settings.block(joint) if kind.group else settings
            if "pid" not in holder:
                raise ControllerError(
                    f"{holder.what} has no pid, which {kind.type} needs: a mapping with p, i, d"
                )
            pids.append((holder.get("pid"), holder.what))
    elif "pid" in settings:
        parse_pid(settings.get("pid"), what, warnings)
        notes.append(
            f"{what}: pid is accepted and not used, as upstream: {kind.type} hands its "
            "command to the joint within the limits of the URDF"
        )
    return {
        "joints": joints,
        "claims": ((kind.interface, joints),),
        "gains": tuple(parse_pid(pid, owner, warnings) for pid, owner in pids),
        "publish_pid": tuple(pid.get("publish_state") is True for pid, _ in pids),
        "notes": tuple(notes),
        "warnings": warnings,
    }


def _joints(settings, kind, joint_names):
    key = "joints" if kind.group else "joint"
    value = settings.get(key)
    joints = value if kind.group else [value]
    if not isinstance(joints, list) or not joints or value is None:
        raise ControllerError(
            f"{settings.what} has {key} {value!r}, must be "
            f"{'a list of joint names' if kind.group else 'a joint name'}"
        )
    check_joints(joints, settings.what, joint_names)
    return tuple(joints)


def check_joints(joints, what, joint_names):
    """Raise ControllerError for a joint that does not exist or is named twice."""
    for number, joint in enumerate(joints):
        if joint not in joint_names:
            raise ControllerError(
                f"{what} names joint '{joint}', which does not exist; joints "
                f"are {', '.join(joint_names) or '(none)'}"
            )
        if joint in joints[:number]:
            raise ControllerError(f"{what} names joint '{joint}' twice, must be once")

"""Controller kinds as a table, and the parsing of their YAML entries."""

import math
from dataclasses import dataclass
from typing import Optional, Tuple

from bullet_sim.errors import CommandError, ControllerError
from bullet_sim.pid import PidGains, parse_pid


@dataclass(frozen=True)
class Kind:
    """A controller type: its hardware interface and how many joints it has."""

    type: str
    interface: str          # velocity, position or state
    group: bool = False

    @property
    def hardware_interface(self):
        """Name of the ros_control hardware interface, as list_controllers reports it."""
        return {'velocity': 'hardware_interface::VelocityJointInterface',
                'position': 'hardware_interface::PositionJointInterface',
                'state': 'hardware_interface::JointStateInterface'}[self.interface]


KINDS = {kind.type: kind for kind in (
    Kind('joint_state_controller/JointStateController', 'state'),
    Kind('velocity_controllers/JointVelocityController', 'velocity'),
    Kind('velocity_controllers/JointGroupVelocityController', 'velocity', True),
    Kind('position_controllers/JointPositionController', 'position'),
    Kind('position_controllers/JointGroupPositionController', 'position', True),
)}

_COMMAND_KEYS = {'type', 'joint', 'joints', 'pid', 'interface_name', 'publish_rate'}
_STATE_KEYS = {'type', 'publish_rate', 'extra_joints', 'joints', 'interface_name'}


@dataclass(frozen=True)
class ControllerSpec:
    """One checked entry of the controllers' YAML.

    Attributes:
        name: the entry's key.
        kind: its row of the table.
        joints: joint names; empty for a state controller that reports all.
        publish_rate: of joint states [Hz].
        pid: gains, accepted and checked (velocity and position interfaces do not use them).
        notes: what is accepted without effect, one sentence each.
    """

    name: str
    kind: Kind
    joints: Tuple[str, ...] = ()
    publish_rate: float = 50.0
    pid: Optional[PidGains] = None
    notes: Tuple[str, ...] = ()


def parse_controller(name, config, joint_names):
    """Check one controller's configuration.

    Args:
        name: controller name.
        config: mapping from the YAML file.
        joint_names: movable joints of the robot.

    Raises:
        ControllerError: names the entry, the value and what would be valid.
    """
    what = f"controller '{name}'"
    if not isinstance(config, dict):
        raise ControllerError(f'{what} has configuration {config!r}, must be a mapping with '
                              'type and joint')
    kind = KINDS.get(str(config.get('type')))
    if kind is None:
        raise ControllerError(f"{what} has type '{config.get('type')}', must be one of "
                              f"{', '.join(KINDS)}")
    unknown = sorted(set(config) - (_STATE_KEYS if kind.interface == 'state' else _COMMAND_KEYS),
                     key=str)
    if unknown:
        raise ControllerError(f"{what} has key '{unknown[0]}', which {kind.type} does not know")
    if kind.interface == 'state':
        return ControllerSpec(name, kind, _state_joints(config, what, joint_names),
                              _rate(config, what))
    joints = _joints(config, kind, what, joint_names)
    pid = parse_pid(config['pid'], what) if 'pid' in config else None
    wanted = config.get('interface_name')
    if wanted not in (None, kind.interface):
        raise ControllerError(f"{what} has interface_name '{wanted}', must be "
                              f"'{kind.interface}' for {kind.type}")
    notes = ()
    if pid is not None:
        notes = (f'{what}: pid is accepted and not used, as upstream: {kind.type} hands its '
                 'command to the joint within the limits of the URDF',)
    return ControllerSpec(name, kind, joints, pid=pid, notes=notes)


def _rate(config, what):
    rate = config.get('publish_rate', 50.0)
    if isinstance(rate, bool) or not isinstance(rate, (int, float)) \
            or not math.isfinite(rate) or rate <= 0:
        raise ControllerError(f'{what} publish_rate is {rate!r}, must be a number above 0 [Hz]')
    return float(rate)


def _state_joints(config, what, joint_names):
    wanted = config.get('joints') or []
    if not isinstance(wanted, list):
        raise ControllerError(f'{what} has joints {wanted!r}, must be a list of joint names')
    _check_joints(wanted, what, joint_names)
    return tuple(wanted)


def _joints(config, kind, what, joint_names):
    key = 'joints' if kind.group else 'joint'
    value = config.get(key)
    joints = value if kind.group else [value]
    if not isinstance(joints, list) or not joints or value is None:
        raise ControllerError(f"{what} has {key} {value!r}, must be "
                              f"{'a list of joint names' if kind.group else 'a joint name'}")
    _check_joints(joints, what, joint_names)
    return tuple(joints)


def _check_joints(joints, what, joint_names):
    for joint in joints:
        if joint not in joint_names:
            raise ControllerError(f"{what} names joint '{joint}', which does not exist; joints "
                                  f"are {', '.join(joint_names) or '(none)'}")


def check_command(name, values, count):
    """Check a command.

    Args:
        name: controller name.
        values: sequence of `count` numbers [rad/s, m/s, rad, m].

    Returns:
        The values as a tuple of floats.

    Raises:
        CommandError: wrong count, NaN or infinite.
    """
    values = tuple(float(value) for value in values)
    if len(values) != count:
        raise CommandError(f"command of '{name}' has {len(values)} values, must have {count}")
    for value in values:
        if not math.isfinite(value):
            raise CommandError(f"command of '{name}' is {value}, must be a finite number; "
                               'the last good command stays')
    return values

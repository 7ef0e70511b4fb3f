"""Controllers: their configuration and their life cycles, on fake joints."""
import math

import pytest

from bullet_sim.controllers import KINDS, parse_controller
from bullet_sim.errors import CommandError, ControllerError
from bullet_sim.manager import INITIALIZED, RUNNING, STOPPED, Manager
from bullet_sim.pid import parse_pid

STATE = 'joint_state_controller/JointStateController'
VELOCITY = 'velocity_controllers/JointVelocityController'
GROUP = 'velocity_controllers/JointGroupVelocityController'
POSITION = 'position_controllers/JointPositionController'
JOINTS = ('left', 'right')


class FakeJoints:
    """Notes what it is told."""

    names = JOINTS

    def __init__(self):
        self.calls = []

    def positions_of(self, names):
        """Where the joints are."""
        return (0.25,) * len(names)

    def drive_velocities(self, names, values):
        """Note it."""
        self.calls.append(('velocity', tuple(names), tuple(values)))

    def drive_positions(self, names, values):
        """Note it."""
        self.calls.append(('position', tuple(names), tuple(values)))

    def release(self, names):
        """Note it."""
        self.calls.append(('release', tuple(names)))


@pytest.fixture(name='joints')
def _joints():
    return FakeJoints()


@pytest.fixture(name='manager')
def _manager(joints):
    manager = Manager(joints)
    manager.load('speed', {'type': VELOCITY, 'joint': 'left'})
    manager.load('angle', {'type': POSITION, 'joint': 'left'})
    manager.load('other', {'type': VELOCITY, 'joint': 'right'})
    manager.load('state', {'type': STATE, 'publish_rate': 10})
    return manager


def states(manager):
    """Map of name -> state."""
    return {spec.name: state for spec, state in manager.list()}


BAD = [
    (None, ['None', 'mapping']),
    ({}, ["type 'None'", VELOCITY]),
    ({'type': 'x/Y'}, ["type 'x/Y'", 'must be one of', STATE, GROUP]),
    ({'type': ['x']}, ["type '['x']'", 'must be one of']),
    ({'type': VELOCITY}, ['joint None', 'a joint name']),
    ({'type': VELOCITY, 'joint': 'nose'}, ["joint 'nose'", 'joints are left, right']),
    ({'type': GROUP, 'joints': 'left'}, ["joints 'left'", 'a list']),
    ({'type': GROUP, 'joints': []}, ['joints []', 'a list']),
    ({'type': GROUP, 'joints': ['left', 'nose']}, ["joint 'nose'"]),
    ({'type': VELOCITY, 'joint': 'left', 'gain': 1}, ["key 'gain'", VELOCITY]),
    ({'type': VELOCITY, 'joint': 'left', 'interface_name': 'effort'}, ["'effort'", "'velocity'"]),
    ({'type': VELOCITY, 'joint': 'left', 'pid': 3}, ['pid is 3', 'mapping']),
    ({'type': VELOCITY, 'joint': 'left', 'pid': {'p': 1, 'q': 1}}, ["key 'q'", 'p, i, d']),
    ({'type': VELOCITY, 'joint': 'left', 'pid': {'i': 1}}, ['no p']),
    ({'type': VELOCITY, 'joint': 'left', 'pid': {'p': 'high'}}, ["pid p is 'high'", 'finite']),
    ({'type': VELOCITY, 'joint': 'left', 'pid': {'p': 1, 'd': math.nan}}, ['pid d is nan']),
    ({'type': STATE, 'publish_rate': 0}, ['publish_rate is 0', 'above 0']),
    ({'type': STATE, 'publish_rate': 'fast'}, ["publish_rate is 'fast'"]),
    ({'type': STATE, 'publish_rate': True}, ['publish_rate is True']),
    ({'type': STATE, 'joints': ['nose']}, ["joint 'nose'"]),
    ({'type': STATE, 'joints': 3}, ['joints 3', 'a list']),
    ({'type': STATE, 1: 2, 'x': 3}, ["key '1'"]),
    ({'type': STATE, 'joint': 'left'}, ["key 'joint'"]),
]


@pytest.mark.parametrize('config, parts', BAD, ids=[' '.join(p) for _, p in BAD])
def test_bad_configurations_are_refused_by_name(config, parts):
    with pytest.raises(ControllerError) as error:
        parse_controller('c', config, JOINTS)
    for part in ["controller 'c'", *parts]:
        assert part in str(error.value)


@pytest.mark.parametrize('values, bounds', [
    ({'p': 1}, (0, 0)),
    ({'p': 1, 'i': 2, 'd': 3, 'i_clamp': 4}, (-4, 4)),
    ({'p': 1, 'i_clamp_min': -5, 'i_clamp_max': 6, 'antiwindup': True}, (-5, 6)),
    ({'p': 1.5, 'publish_state': True}, (0, 0)),
])
def test_pid_keys(values, bounds):
    gains = parse_pid(values, 'c')
    assert (gains.p, gains.i, gains.d) == (values['p'], values.get('i', 0), values.get('d', 0))
    assert (gains.i_clamp_min, gains.i_clamp_max) == bounds
    assert gains.antiwindup is values.get('antiwindup', False)


def test_unused_pid_is_said():
    spec = parse_controller('c', {'type': VELOCITY, 'joint': 'left', 'pid': {'p': 1}}, JOINTS)
    assert spec.pid.p == 1 and "controller 'c'" in spec.notes[0]


def test_types_and_interfaces():
    assert Manager.types() == list(KINDS)
    assert KINDS[VELOCITY].hardware_interface == 'hardware_interface::VelocityJointInterface'


def test_list_keeps_the_order_of_loading(manager):
    assert list(states(manager)) == ['speed', 'angle', 'other', 'state']
    assert set(states(manager).values()) == {INITIALIZED}


def test_loading_twice_is_refused_and_the_first_stays(manager):
    with pytest.raises(ControllerError, match="'speed' is loaded already"):
        manager.load('speed', {'type': POSITION, 'joint': 'right'})
    assert manager.list()[0][0].kind.type == VELOCITY


def test_failed_load_leaves_nothing(manager):
    with pytest.raises(ControllerError):
        manager.load('bad', {'type': 'x'})
    assert 'bad' not in states(manager)


def test_unload(manager):
    manager.switch(['speed'], [])
    with pytest.raises(ControllerError, match="'speed' is running"):
        manager.unload('speed')
    with pytest.raises(ControllerError, match="'gone' is not loaded; loaded are speed"):
        manager.unload('gone')
    manager.switch([], ['speed'])
    manager.unload('speed')
    assert 'speed' not in states(manager)


def test_start_and_stop(manager, joints):
    manager.switch(['speed', 'state'], [])
    assert joints.calls == [('velocity', ('left',), (0,))]
    assert [spec.name for spec in manager.running_state_controllers()] == ['state']
    manager.switch([], ['speed'])
    assert joints.calls[-1] == ('release', ('left',))
    assert states(manager)['speed'] == STOPPED


def test_position_controller_starts_where_the_joint_is(manager, joints):
    manager.switch(['angle'], [])
    assert joints.calls == [('position', ('left',), (0.25,))]


def test_swap_of_two_controllers_on_one_joint(manager, joints):
    manager.switch(['speed'], [])
    joints.calls.clear()
    assert manager.switch(['angle'], ['speed']) == []
    assert (states(manager)['speed'], states(manager)['angle']) == (STOPPED, RUNNING)
    assert joints.calls == [('release', ('left',)), ('position', ('left',), (0.25,))]


@pytest.mark.parametrize('start, stop, reason', [
    (['other', 'angle'], [], "'angle' cannot start: joint 'left' is claimed by 'speed'"),
    (['other', 'gone'], ['speed'], "'gone' is not loaded"),
    (['other'], ['speed', 'angle'], "'angle' is not running"),
    (['other', 'speed'], [], "'speed' is running already"),
])
def test_strict_switch_refuses_all_with_a_reason(manager, joints, start, stop, reason):
    manager.switch(['speed'], [])
    before, calls = states(manager), list(joints.calls)
    with pytest.raises(ControllerError, match=reason):
        manager.switch(start, stop, strict=True)
    assert (states(manager), joints.calls) == (before, calls)


def test_two_rivals_in_one_switch_are_refused(manager):
    with pytest.raises(ControllerError, match="claimed by 'speed'"):
        manager.switch(['speed', 'angle'], [])
    assert RUNNING not in states(manager).values()


def test_best_effort_switch_leaves_out_what_does_not_fit(manager):
    manager.switch(['speed'], [])
    reasons = manager.switch(['angle', 'other', 'gone'], ['state'], strict=False)
    assert states(manager) == {'speed': RUNNING, 'angle': INITIALIZED, 'other': RUNNING,
                               'state': INITIALIZED}
    assert len(reasons) == 3
    for name in ('angle', 'gone', 'state'):
        assert any(f"'{name}'" in reason for reason in reasons)


@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf])
def test_command_that_is_no_number_keeps_the_last(manager, joints, value):
    manager.switch(['speed'], [])
    manager.command('speed', [3.0])
    calls = list(joints.calls)
    with pytest.raises(CommandError, match="'speed' is -?(nan|inf), must be a finite number"):
        manager.command('speed', [value])
    assert joints.calls == calls and calls[-1] == ('velocity', ('left',), (3.0,))


def test_commands_of_the_wrong_length_to_nobody_and_to_a_stopped_one(manager, joints):
    with pytest.raises(CommandError, match='has 2 values, must have 1'):
        manager.command('speed', [1, 2])
    with pytest.raises(ControllerError, match="'gone' is not loaded"):
        manager.command('gone', [1])
    manager.command('speed', [1])
    assert joints.calls == []


def test_group_drives_its_joints_in_its_order(joints):
    manager = Manager(joints)
    manager.load('all', {'type': GROUP, 'joints': ['right', 'left']})
    manager.switch(['all'], [])
    manager.command('all', [1, 2])
    assert joints.calls[-1] == ('velocity', ('right', 'left'), (1, 2))


def test_restart_forgets_commands(manager, joints):
    manager.switch(['speed'], [])
    manager.command('speed', [5])
    manager.restart()
    assert joints.calls[-1] == ('velocity', ('left',), (0,))
    assert states(manager)['speed'] == RUNNING

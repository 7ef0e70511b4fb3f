"""The state of all bodies of PyBullet as a value, in memory."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import FileIO
from typing import Any

from bullet_sim.engine.api import EngineState
from bullet_sim.engine.bullet.owner import Owner
from bullet_sim.files import silenced

_FAR = 1e5  # [m] from the origin: where bodies touch nothing
_APART = 1e3  # [m] between two bodies there


@dataclass(frozen=True)
class BodiesState:
    """State of all bodies.

    Attributes:
        data: Bullet's own copy of poses, velocities and contacts.
        motions: number of a body -> (position, orientation, linear, angular velocity, joints'
            positions and velocities).
        motors: number of a body -> for each joint the last command of its motor, and what was
            applied to it.
    """

    data: bytes
    motions: dict[int, tuple[Any, ...]]
    motors: dict[int, list[tuple[str, tuple[float, ...], float | None]]]


def save_bodies(engine: Owner) -> EngineState:
    """Save the state of all bodies."""
    motions = {number: _motion(engine, number) for number in engine.bodies}
    points = _contact_points(engine)
    data = _data(engine)
    _restore_data(engine, data)
    clear = _contact_points(engine) != points  # which Bullet does not bring back
    if clear:
        _set_motions(engine, motions)  # as restore_bodies() does it
        _clear_contacts(engine)
    motors = {
        number: [(*motor.command, motor.applied) for motor in body.motors.values()]
        for number, body in engine.bodies.items()
    }
    return EngineState(engine.layout, clear, BodiesState(data, motions, motors))


def restore_bodies(engine: Owner, saved: EngineState) -> bool:
    """Restore a state; the bodies have to be the same.

    Returns:
        Whether the world goes on as it did when the state was saved, to the bit. False: the layout
        is another one, the contacts' warm start is lost.
    """
    state: BodiesState = saved.data
    warm = saved.layout == engine.layout and not saved.is_cleared
    if warm:
        _restore_data(engine, state.data)
    else:
        _set_motions(engine, state.motions)
        _clear_contacts(engine)
    for number, commands in state.motors.items():
        motors = engine.bodies[number].motors.values()
        for motor, (command, arguments, applied) in zip(motors, commands):
            getattr(motor, command)(*arguments)
            motor.applied = applied
    return warm or saved.is_cleared


def _data(engine: Owner) -> bytes:
    """Bullet's copy of poses, velocities and contacts."""
    with _file_in_memory() as file:
        with silenced():
            engine.client.api.saveBullet(_path(file))
        return file.read()


def _contact_points(engine: Owner) -> list[tuple[Any, ...]]:
    return sorted(point[1:] for point in engine.client.api.getContactPoints())


def _restore_data(engine: Owner, data: bytes) -> None:
    api = engine.client.api
    # Bullet leaves contacts that its copy does not have: put all bodies where there are none.
    free = sorted(number for number, body in engine.bodies.items() if not body.is_fixed)
    for count, body in enumerate(free):
        place = (_FAR + count * _APART, 0.0, _FAR)
        api.resetBasePositionAndOrientation(body, place, (0.0, 0.0, 0.0, 1.0))
    api.performCollisionDetection()
    with _file_in_memory(data) as file, silenced(), _fitted_bounds(engine):
        api.restoreState(fileName=_path(file))


@contextmanager
def _fitted_bounds(engine: Owner) -> Iterator[None]:
    """What never moves and is elsewhere afterwards is put there again: as it sleeps, Bullet leaves
    its bounding box where it was, and neither rays nor bodies meet it."""
    before = {body: body.pose() for body in engine.bodies.values() if not body.moves}
    yield
    for body, pose in before.items():
        now = body.pose()
        if now != pose:
            body.set_pose(*now)


def _clear_contacts(engine: Owner) -> None:
    """Forget all contacts, as if the bodies had just been put where they are."""
    for body in sorted(engine.bodies):
        # any change of a filter gives a body new numbers in the broad phase
        engine.client.api.setCollisionFilterPair(body, body, -1, -1, 1)
        engine.note_layout("clear", body)


def _motion(engine: Owner, number: int) -> tuple[Any, ...]:
    api = engine.client.api
    return (
        *api.getBasePositionAndOrientation(number),
        *api.getBaseVelocity(number),
        tuple(state[:2] for state in engine.bodies[number].states()),
    )


def _set_motions(engine: Owner, motions: dict[int, tuple[Any, ...]]) -> None:
    api = engine.client.api
    for number, (position, orientation, linear, angular, joints) in motions.items():
        api.resetBasePositionAndOrientation(number, position, orientation)
        api.resetBaseVelocity(number, linear, angular)
        for motor, (angle, speed) in zip(engine.bodies[number].motors.values(), joints):
            motor.set_position(angle, speed)


def _file_in_memory(data: bytes = b"") -> FileIO:
    """A file for a library that takes paths; Bullet does not notice when a disk is full."""
    file = open(os.memfd_create("bullet_state"), "w+b", buffering=0)
    file.write(data)
    file.seek(0)
    return file


def _path(file: FileIO) -> str:
    return f"/proc/self/fd/{file.fileno()}"

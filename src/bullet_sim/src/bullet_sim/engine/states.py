"""The state of all bodies of an engine as a value, in memory."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import FileIO
from typing import Any

import pybullet as p

from bullet_sim.engine.engine import Engine
from bullet_sim.files import silenced

_FAR = 1e5  # [m] from the origin: where bodies touch nothing
_APART = 1e3  # [m] between two bodies there


@dataclass(frozen=True)
class BodiesState:
    """State of all bodies.

    Attributes:
        layout: of the engine when it was saved.
        is_cleared: the contacts were cleared; the world has to go on without them.
        data: Bullet's own copy of poses, velocities and contacts.
        motions: body -> (position, orientation, linear, angular velocity, joints' positions and
            velocities).
        motors: (body, joint) -> last command of its motor.
        solver: all of it in the place of the others, of an engine that keeps its bodies' states.
    """

    layout: int
    is_cleared: bool
    data: bytes
    motions: dict[int, tuple[Any, ...]]
    motors: dict[tuple[int, int], tuple[str, tuple[Any, ...]]]
    solver: Any = None


def save_bodies(engine: Engine) -> BodiesState:
    """Save the state of all bodies."""
    if engine.keeps_states:
        return BodiesState(engine.layout, False, b"", {}, {}, engine.save_solver())
    motions = {body: _motion(engine, body) for body in engine.movable}
    points = _contact_points(engine)
    data = _data(engine)
    _restore_data(engine, data)
    clear = _contact_points(engine) != points  # which Bullet does not bring back
    if clear:
        _set_motions(engine, motions)  # as restore_bodies() does it
        _clear_contacts(engine)
    return BodiesState(engine.layout, clear, data, motions, dict(engine.motors()))


def restore_bodies(engine: Engine, state: BodiesState) -> bool:
    """Restore a state; the bodies have to be the same.

    Returns:
        Whether the world goes on as it did when the state was saved, to the bit. False: the layout
        is another one, the contacts' warm start is lost.
    """
    if engine.keeps_states:
        engine.restore_solver(state.solver)
        return state.layout == engine.layout
    warm = state.layout == engine.layout and not state.is_cleared
    if warm:
        _restore_data(engine, state.data)
    else:
        _set_motions(engine, state.motions)
        _clear_contacts(engine)
    for (body, _), (command, arguments) in dict(state.motors).items():
        getattr(engine, command)(body, *arguments)
    return warm or state.is_cleared


def _data(engine: Engine) -> bytes:
    """Bullet's copy of poses, velocities and contacts."""
    with _file_in_memory() as file:
        with silenced():
            p.saveBullet(_path(file), physicsClientId=engine.client)
        return file.read()


def _contact_points(engine: Engine) -> list[tuple[Any, ...]]:
    return sorted(point[1:] for point in p.getContactPoints(physicsClientId=engine.client))


def _restore_data(engine: Engine, data: bytes) -> None:
    client = engine.client
    # Bullet leaves contacts that its copy does not have: put all bodies where there are none.
    for number, body in enumerate(sorted(engine.free)):
        place = (_FAR + number * _APART, 0.0, _FAR)
        p.resetBasePositionAndOrientation(body, place, (0.0, 0.0, 0.0, 1.0), physicsClientId=client)
    p.performCollisionDetection(physicsClientId=client)
    with _file_in_memory(data) as file, silenced(), _fitted_bounds(engine):
        p.restoreState(fileName=_path(file), physicsClientId=client)


@contextmanager
def _fitted_bounds(engine: Engine) -> Iterator[None]:
    """What never moves and is elsewhere afterwards is put there again: as it sleeps, Bullet leaves
    its bounding box where it was, and neither rays nor bodies meet it."""
    before = {body: engine.body_pose(body) for body in engine.movable if not engine.moves(body)}
    yield
    for body, pose in before.items():
        now = engine.body_pose(body)
        if now != pose:
            engine.put(body, *now)


def _clear_contacts(engine: Engine) -> None:
    """Forget all contacts, as if the bodies had just been put where they are."""
    for body in sorted(engine.movable):
        # any change of a filter gives a body new numbers in the broad phase
        p.setCollisionFilterPair(body, body, -1, -1, 1, physicsClientId=engine.client)
        engine.note_layout("clear", body)


def _motion(engine: Engine, body: int) -> tuple[Any, ...]:
    return (
        *p.getBasePositionAndOrientation(body, physicsClientId=engine.client),
        *p.getBaseVelocity(body, physicsClientId=engine.client),
        tuple(joint[:2] for joint in engine.joint_states(body)),
    )


def _set_motions(engine: Engine, motions: dict[int, tuple[Any, ...]]) -> None:
    for body, (position, orientation, linear, angular, joints) in motions.items():
        engine.put(body, position, orientation)
        p.resetBaseVelocity(body, linear, angular, physicsClientId=engine.client)
        for joint, (angle, speed) in zip(engine.movable[body], joints):
            p.resetJointState(body, joint, angle, speed, physicsClientId=engine.client)


def _file_in_memory(data: bytes = b"") -> FileIO:
    """A file for a library that takes paths; Bullet does not notice when a disk is full."""
    file = open(os.memfd_create("bullet_state"), "w+b", buffering=0)
    file.write(data)
    file.seek(0)
    return file


def _path(file: FileIO) -> str:
    return f"/proc/self/fd/{file.fileno()}"

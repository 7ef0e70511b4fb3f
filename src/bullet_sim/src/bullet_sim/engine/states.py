"""The state of all bodies as a value."""

import os
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import FileIO
from typing import TYPE_CHECKING, Any

import pybullet as p

from bullet_sim.files import silenced

if TYPE_CHECKING:
    from bullet_sim.engine.engine import Engine

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
        solver: state of the engine's OdeSolver, if it has one.
    """

    layout: int
    is_cleared: bool
    data: bytes
    motions: dict[int, tuple[Any, ...]]
    motors: dict[tuple[int, int], tuple[str, tuple[Any, ...]]]
    solver: dict[str, Any] | None = None


class BodyStates:
    """Saves and restores the state of an engine's bodies, in memory.

    Attributes:
        layout: number of what was loaded, removed or filtered so far: it gives bodies their numbers
            in the broad phase.
    """

    def __init__(self, engine: "Engine") -> None:
        self._engine = engine
        self.layout = 0

    @property
    def _client(self) -> int:
        return self._engine.client

    def save(self) -> BodiesState:
        """Save the state of all bodies."""
        motions = {body: self._motion(body) for body in self._engine.movable}
        points = self._contact_points()
        data = self._data()
        self._restore_data(data)
        clear = self._contact_points() != points  # which Bullet does not bring back
        if clear:
            self._set_motions(motions)  # as restore() does it
            self._clear_contacts()
        solver = self._engine.save_solver()
        return BodiesState(self.layout, clear, data, motions, dict(self._engine.motors()), solver)

    def restore(self, state: BodiesState) -> bool:
        """Restore a state; the bodies have to be the same.

        Returns:
            Whether the world goes on as it did when the state was saved, to the bit. False: the
            layout is another one, the contacts' warm start is lost.
        """
        warm = state.layout == self.layout and not state.is_cleared
        if warm:
            self._restore_data(state.data)
        else:
            self._set_motions(state.motions)
            self._clear_contacts()
        self._set_motors(state.motors)
        self._engine.restore_solver(state.solver)
        return warm or state.is_cleared

    def _set_motors(self, motors: dict[tuple[int, int], tuple[str, tuple[Any, ...]]]) -> None:
        for (body, _), (command, arguments) in dict(motors).items():
            getattr(self._engine, command)(body, *arguments)

    def _data(self) -> bytes:
        """Bullet's copy of poses, velocities and contacts."""
        with _file_in_memory() as file:
            with silenced():
                p.saveBullet(_path(file), physicsClientId=self._client)
            return file.read()

    def note_layout(self, *event: object) -> None:
        """Note what gives bodies numbers in the broad phase."""
        self.layout = zlib.crc32(repr((self.layout, event)).encode())

    def _contact_points(self) -> list[tuple[Any, ...]]:
        return sorted(point[1:] for point in p.getContactPoints(physicsClientId=self._client))

    def _restore_data(self, data: bytes) -> None:
        self._engine.rays.scenery.check_poses()
        # Bullet leaves contacts that its copy does not have: put all bodies where there are none.
        for number, body in enumerate(sorted(self._engine.free)):
            place = (_FAR + number * _APART, 0.0, _FAR)
            p.resetBasePositionAndOrientation(
                body, place, (0.0, 0.0, 0.0, 1.0), physicsClientId=self._client
            )
        p.performCollisionDetection(physicsClientId=self._client)
        with _file_in_memory(data) as file, silenced(), self.fitted_bounds():
            p.restoreState(fileName=_path(file), physicsClientId=self._client)

    @contextmanager
    def fitted_bounds(self) -> Iterator[None]:
        """What never moves and is elsewhere afterwards is put there again: as it sleeps, Bullet
        leaves its bounding box where it was, and neither rays nor bodies meet it."""
        engine = self._engine
        before = {body: engine.body_pose(body) for body in engine.movable if not engine.moves(body)}
        yield
        for body, pose in before.items():
            now = engine.body_pose(body)
            if now != pose:
                engine.put(body, *now)

    def _clear_contacts(self) -> None:
        """Forget all contacts, as if the bodies had just been put where they are."""
        for body in sorted(self._engine.movable):
            # any change of a filter gives a body new numbers in the broad phase
            p.setCollisionFilterPair(body, body, -1, -1, 1, physicsClientId=self._client)
            self.note_layout("clear", body)

    def _motion(self, body: int) -> tuple[Any, ...]:
        client = self._client
        return (
            *p.getBasePositionAndOrientation(body, physicsClientId=client),
            *p.getBaseVelocity(body, physicsClientId=client),
            tuple(joint[:2] for joint in self._engine.joint_states(body)),
        )

    def _set_motions(self, motions: dict[int, tuple[Any, ...]]) -> None:
        self._engine.rays.scenery.check_poses()
        for body, (position, orientation, linear, angular, joints) in motions.items():
            self._engine.put(body, position, orientation)
            p.resetBaseVelocity(body, linear, angular, physicsClientId=self._client)
            for joint, (angle, speed) in zip(self._engine.movable[body], joints):
                p.resetJointState(body, joint, angle, speed, physicsClientId=self._client)


def _file_in_memory(data: bytes = b"") -> FileIO:
    """A file for a library that takes paths; Bullet does not notice when a disk is full."""
    file = open(os.memfd_create("bullet_state"), "w+b", buffering=0)
    file.write(data)
    file.seek(0)
    return file


def _path(file: FileIO) -> str:
    return f"/proc/self/fd/{file.fileno()}"

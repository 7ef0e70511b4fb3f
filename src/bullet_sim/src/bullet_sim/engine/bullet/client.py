"""A headless client of PyBullet, and the bodies that it has loaded from LumpedModels."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
import pybullet as p

from bullet_sim.description.lump import LumpedModel
from bullet_sim.engine.api import BodyLink, Rays
from bullet_sim.engine.bullet.urdf import lumped_urdf
from bullet_sim.errors import ModelError
from bullet_sim.files import silenced
from bullet_sim.pose import Array, Pose, Quat, Vec3, compose

_FLAGS = (
    p.URDF_USE_IMPLICIT_CYLINDER
    | p.URDF_USE_INERTIA_FROM_FILE
    | p.URDF_USE_MATERIAL_COLORS_FROM_MTL
)
# Bits that a link with a collide_bitmask of its own shares with all that have none, and where its
# own bits begin.
_COMMON, _SHIFT = 3, 8
SLEEP = (
    p.ACTIVATION_STATE_SLEEP | p.ACTIVATION_STATE_ENABLE_SLEEPING | p.ACTIVATION_STATE_ENABLE_WAKEUP
)
MOVABLE = (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC)


@dataclass(frozen=True)
class Loaded:
    """A body of PyBullet's.

    Attributes:
        uid: PyBullet's number.
        links: name -> PyBullet's index; the root link has -1.
        joints: name -> PyBullet's index, of those that move.
        inertial: pose of the root link's principal axes at its center of mass, in its frame.
        is_static: none of PyBullet's multibodies, which cost time in every step.
    """

    uid: int
    links: Mapping[str, int]
    joints: Mapping[str, int]
    inertial: Pose
    is_static: bool

    def frame(self, position: Vec3, orientation: Quat) -> tuple[Vec3, Quat]:
        """Pose of the root link's frame where its principal axes have one."""
        outward = self.outward
        return compose(position, orientation, outward.position, outward.orientation)

    @cached_property
    def outward(self) -> Pose:
        """Pose of the root link's frame in its principal axes."""
        return self.inertial.inverse()


class Point(NamedTuple):
    """A contact point that Bullet finds: two links, where it is on the second one, the normal
    towards the first one, and the distance; negative: they overlap [m]."""

    one: BodyLink
    two: BodyLink
    position: Vec3
    normal: Vec3
    distance: float


class Api:
    """The functions of PyBullet, of the client of a number."""

    def __init__(self, number: int) -> None:
        self._number = number

    def __getattr__(self, name: str) -> Any:
        function = partial(getattr(p, name), physicsClientId=self._number)
        setattr(self, name, function)  # it is looked up once
        return function


class Client:
    """A client of PyBullet, which loads bodies and says how they touch.

    Args:
        draw: load what bodies look like, for a PyBulletCamera. A client that draws nothing would
            decode the textures of all meshes for nothing.

    Attributes:
        number: PyBullet's.
        api: its functions.
        bodies: those that are loaded, by the engine's numbers.
    """

    def __init__(self, draw: bool = False) -> None:
        self._flags = _FLAGS if draw else _FLAGS | p.URDF_IGNORE_VISUAL_SHAPES
        with silenced():
            self.number = p.connect(p.DIRECT)
        self.api = Api(self.number)
        self.clear()

    def clear(self) -> None:
        """Remove all bodies."""
        self.api.resetSimulation()
        self.api.setPhysicsEngineParameter(deterministicOverlappingPairs=1, enableFileCaching=0)
        self.bodies: dict[int, Loaded] = {}
        self._names: dict[int, tuple[int, list[str]]] = {}  # uid -> number, names of links

    def close(self) -> None:
        """Disconnect."""
        if self.number >= 0:
            self.api.disconnect()
            self.number = -1

    def load(
        self,
        number: int | None,
        model: LumpedModel,
        static: bool,
        fixed_base: bool,
        self_collide: bool = False,
    ) -> Loaded:
        """Load a model.

        Args:
            number: the engine's; None: PyBullet's.
            static: one link that never moves, of which meshes collide as they are.
            fixed_base: the root link never moves.
            self_collide: links collide with each other, those of one joint excepted.

        Raises:
            ModelError: PyBullet refuses it.
        """
        return self.load_text(
            number, lumped_urdf(model, static), model.root, static, fixed_base, self_collide
        )

    def load_text(
        self,
        number: int | None,
        text: str,
        label: str,
        static: bool = False,
        fixed_base: bool = False,
        self_collide: bool = False,
    ) -> Loaded:
        """Load a URDF text, see load(); label: name of its root link."""
        with tempfile.NamedTemporaryFile("w", suffix=".urdf", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            try:
                with silenced():
                    uid: int = self.api.loadURDF(
                        file.name,
                        (0, 0, 0),
                        (0, 0, 0, 1),
                        useFixedBase=fixed_base,
                        useMaximalCoordinates=static,
                        flags=self._flags | (p.URDF_USE_SELF_COLLISION if self_collide else 0),
                    )
            except p.error as error:
                raise ModelError(f"PyBullet cannot load '{label}': {error}") from error
        loaded = self._described(uid, label, static)
        number = uid if number is None else number
        self.bodies[number] = loaded
        self._names[uid] = number, list(loaded.links)
        return loaded

    def _described(self, uid: int, root: str, static: bool) -> Loaded:
        count = self.api.getNumJoints(uid)
        infos = [self.api.getJointInfo(uid, i) for i in range(count)]
        center = Pose()  # of what is static; PyBullet has a quaternion of zeros for it
        if not static:
            dynamics = self.api.getDynamicsInfo(uid, -1)
            center = Pose(dynamics[3], dynamics[4])
        return Loaded(
            uid,
            {root: -1, **{info[12].decode(): info[0] for info in infos}},
            {info[1].decode(): info[0] for info in infos if info[2] in MOVABLE},
            center,
            static,
        )

    def remove(self, number: int) -> None:
        """Remove a body."""
        loaded = self.bodies.pop(number)
        del self._names[loaded.uid]
        self.api.removeBody(loaded.uid)

    def put(self, number: int, pose: Pose, moves: bool) -> None:
        """Move a body's root link's frame to a pose."""
        loaded = self.bodies[number]
        inertial = loaded.inertial.position, loaded.inertial.orientation
        place = compose(pose.position, pose.orientation, *inertial)
        self.api.resetBasePositionAndOrientation(loaded.uid, *place)
        if not moves:  # Bullet need not look at its bounds in each step
            self.api.changeDynamics(loaded.uid, -1, activationState=SLEEP)

    # Contacts -----------------------------------------------------------------------------------
    def index(self, link: BodyLink) -> tuple[int, int]:
        """PyBullet's numbers of a link."""
        loaded = self.bodies[link[0]]
        return loaded.uid, loaded.links[link[1]]

    def link(self, uid: int, index: int) -> BodyLink:
        """The link of PyBullet's numbers."""
        number, names = self._names[uid]
        return number, names[index + 1]

    def link_frame(self, link: BodyLink) -> tuple[Vec3, Quat]:
        """Pose of a link's frame in the world."""
        uid, index = self.index(link)
        if index < 0:
            place = self.api.getBasePositionAndOrientation(uid)
            return self.bodies[link[0]].frame(*place)
        state = self.api.getLinkState(uid, index, computeForwardKinematics=1)
        return state[4], state[5]

    def center_frame(self, link: BodyLink) -> tuple[Vec3, Quat]:
        """Pose of a link's principal axes at its center of mass, in the world."""
        uid, index = self.index(link)
        if index < 0:
            return self.api.getBasePositionAndOrientation(uid)
        state = self.api.getLinkState(uid, index, computeForwardKinematics=1)
        return state[0], state[1]

    def set_bitmask(self, link: BodyLink, bits: int) -> None:
        """Let a link touch only what shares a bit (of 16) with it; the others have all bits."""
        own = bits << _SHIFT
        group, mask = own, own | (_COMMON if bits else 0)
        self.api.setCollisionFilterGroupMask(*self.index(link), group, mask)

    def set_pair_collision(self, one: BodyLink, other: BodyLink, collide: bool) -> None:
        """Enable or disable collision between two links."""
        (uid, link), (other_uid, other_link) = self.index(one), self.index(other)
        self.api.setCollisionFilterPair(uid, other_uid, link, other_link, int(collide))

    def depth(self, one: BodyLink, other: BodyLink) -> float:
        """How deep [m] two links overlap, also where they pass through each other; 0: not."""
        (uid, link), (other_uid, other_link) = self.index(one), self.index(other)
        points = self.api.getClosestPoints(uid, other_uid, 0.0, link, other_link)
        return max((-point[8] for point in points), default=0.0)

    def touching_points(self) -> Iterator[Point]:
        """Contact points where bodies are now."""
        self.api.performCollisionDetection()
        for point in self.api.getContactPoints() or ():
            one, two = self.link(point[1], point[3]), self.link(point[2], point[4])
            yield Point(one, two, point[6], point[7], point[8])

    def first_hits(self, starts: Array, ends: Array) -> tuple[Array, Array]:
        """Of rays between points (n, 3) the part (n,) of the way to the first hit, inf: none, and
        the numbers (n,) of the bodies there."""
        hits: list[tuple[Any, ...]] = []
        limit = p.MAX_RAY_INTERSECTION_BATCH_SIZE
        for first in range(0, len(starts), limit):
            rays = starts[first : first + limit], ends[first : first + limit]
            hits += self.api.rayTestBatch(*rays)
        uids = np.array([hit[0] for hit in hits], int)
        parts = np.where(uids >= 0, np.array([hit[2] for hit in hits], float), np.inf)
        return parts, np.array([self._names[uid][0] if uid >= 0 else -1 for uid in uids.tolist()])

    def cast_rays(self, rays: Rays) -> Array:
        """As Engine.cast_rays, where bodies are now."""
        center, directions, near, far = rays
        parts, _ = self.first_hits(center + near * directions, center + far * directions)
        ranges: Array = near + parts * (far - near)
        return ranges

    def set_joints(self, number: int, states: Mapping[str, Sequence[float]]) -> None:
        """Put joints to (position, velocity)."""
        loaded = self.bodies[number]
        if states:
            self.api.resetJointStatesMultiDof(
                loaded.uid,
                [loaded.joints[name] for name in states],
                [[state[0]] for state in states.values()],
                [[state[1]] for state in states.values()],
            )

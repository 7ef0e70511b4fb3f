"""Where all links of all bodies are, from a snapshot: a few numpy calls however many there are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from bullet_sim.description.model import VisualLink
from bullet_sim.pose import Array, Pose
from bullet_sim.snapshot import BodyState, Snapshot


def pose_matrix(pose: Pose) -> Array:
    """(4, 4) of a Pose."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = pose.matrix, pose.position
    return matrix


def matrices(positions: Array, quaternions: Array) -> Array:
    """(n, 4, 4) of positions (n, 3) [m] and quaternions (n, 4) (x, y, z, w) of any length."""
    q = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    x, y, z, w = q.T
    result = np.zeros((len(q), 4, 4))
    result[:, 0, 0], result[:, 0, 1] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w)
    result[:, 0, 2], result[:, 1, 0] = 2 * (x * z + y * w), 2 * (x * y + z * w)
    result[:, 1, 1], result[:, 1, 2] = 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    result[:, 2, 0], result[:, 2, 1] = 2 * (x * z - y * w), 2 * (y * z + x * w)
    result[:, 2, 2] = 1 - 2 * (x * x + y * y)
    result[:, :3, 3], result[:, 3, 3] = positions, 1.0
    return result


def rotations(axes: Array, angles: Array) -> Array:
    """(n, 4, 4) of rotations about unit axes (n, 3) by angles (n,) [rad] (Rodrigues)."""
    x, y, z = axes.T
    cross = np.zeros((len(axes), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -z, y, -x
    cross[:, 1, 0], cross[:, 2, 0], cross[:, 2, 1] = z, -y, x
    result = np.tile(np.eye(4), (len(axes), 1, 1))
    result[:, :3, :3] += np.sin(angles)[:, None, None] * cross
    result[:, :3, :3] += (1.0 - np.cos(angles))[:, None, None] * (cross @ cross)
    return result


def quaternions(poses: Array) -> Array:
    """Quaternions (n, 4) (x, y, z, w) of the rotations of (n, 4, 4): of each the largest of its
    four numbers first, which divides the others (Shepperd, 1978)."""
    a, b, c = poses[:, 0, 0], poses[:, 1, 1], poses[:, 2, 2]
    squares = 0.25 * np.column_stack(
        [1.0 + a - b - c, 1.0 - a + b - c, 1.0 - a - b + c, 1.0 + a + b + c]
    )
    sums = 0.25 * (poses + poses.transpose(0, 2, 1))
    gaps = 0.25 * (poses - poses.transpose(0, 2, 1))
    products = np.empty((len(poses), 4, 4))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        products[:, i, i] = squares[:, i]
        products[:, i, j] = products[:, j, i] = sums[:, i, j]
        products[:, i, 3] = products[:, 3, i] = gaps[:, k, j]
    products[:, 3, 3] = squares[:, 3]
    largest = np.argmax(squares, axis=1)
    each = np.arange(len(poses))
    found: Array = products[each, largest]
    return found / np.sqrt(squares[each, largest])[:, None]


class Level:
    """Links at one depth of the trees: rows, those of their parents, and their joints."""

    def __init__(
        self, rows: Sequence[int], links: Sequence[VisualLink], firsts: Sequence[int]
    ) -> None:
        self.rows = np.array(rows)
        self.parents = np.array([firsts[row] + links[row].parent for row in rows])
        self.origins = np.array([pose_matrix(links[row].origin) for row in rows])
        self.axes = np.array([links[row].axis for row in rows], float)
        types = [links[row].kind for row in rows]
        self.revolute = np.flatnonzero([name == "revolute" for name in types])
        self.prismatic = np.flatnonzero([name == "prismatic" for name in types])


class Kinematics:
    """The links of all bodies in one table.

    Attributes:
        firsts: key -> row of the body's root link.
        poses: (n, 4, 4) float64, the links' frames in the world.
        counts: key -> number of the body's links.
        changed: (n,) bool, whether the body of a link was somewhere else in the last snapshot.
    """

    def __init__(self, bodies: Mapping[int, Sequence[VisualLink]]) -> None:
        links: list[VisualLink] = []
        first_of: list[int] = []
        self.firsts: dict[int, int] = {}
        self._joint_rows: dict[int, list[int]] = {}
        for key, chain in bodies.items():
            first = self.firsts[key] = len(links)
            links += chain
            first_of += [first] * len(chain)
            self._joint_rows[key] = [
                row for row, link in enumerate(chain, first) if link.kind != "fixed"
            ]
        depths: list[int] = []
        for row, link in enumerate(links):
            depths.append(0 if link.parent < 0 else depths[first_of[row] + link.parent] + 1)
        self.poses = np.tile(np.eye(4), (len(links), 1, 1))
        self.changed = np.ones(len(links), bool)
        self._positions = np.zeros(len(links))  # of the joints
        self.counts = {key: len(chain) for key, chain in bodies.items()}
        self._states: dict[int, BodyState] = {}
        self._levels = [
            Level([row for row, other in enumerate(depths) if other == depth], links, first_of)
            for depth in range(1, max(depths, default=0) + 1)
        ]
        self._propagate()

    def apply(self, snapshot: Snapshot) -> None:
        """Put the links where a Snapshot has them; bodies without a state stay."""
        self._apply(snapshot.bodies)

    def _apply(self, states: Iterable[BodyState]) -> None:
        moved = [
            state
            for state in states
            if state.key in self.firsts and self._states.get(state.key) != state
        ]
        self.changed[:] = False
        if not moved:
            return
        rows = [self.firsts[state.key] for state in moved]
        self.poses[rows] = matrices(
            np.array([state.position for state in moved], float),
            np.array([state.orientation for state in moved], float),
        )
        for state, row in zip(moved, rows):
            self._states[state.key] = state
            self.changed[row : row + self.counts[state.key]] = True
            joints = self._joint_rows[state.key]
            if len(state.joints) and joints:
                count = min(len(joints), len(state.joints))
                self._positions[joints[:count]] = state.joints[:count]
        self._propagate()

    def _propagate(self) -> None:
        for level in self._levels:
            local, angles = level.origins, self._positions[level.rows]
            if len(level.revolute):
                local = local.copy()
                chosen = level.revolute
                local[chosen] = local[chosen] @ rotations(level.axes[chosen], angles[chosen])
            if len(level.prismatic):
                chosen, local = level.prismatic, local.copy()
                shift = (level.axes[chosen] * angles[chosen, None])[:, :, None]
                local[chosen, :3, 3:] += local[chosen, :3, :3] @ shift
            self.poses[level.rows] = self.poses[level.parents] @ local

    def keep_from(self, other: Kinematics) -> None:
        """Take the states of bodies that another table has, too."""
        self._apply(other._states.values())
        self.changed[:] = True

"""Rows of the solver's tables (see quickstep/layout.py) of what a model's description has."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from bullet_sim.description.model import Link, Shape, Surface
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.state import Building
from bullet_sim.pose import Array, Pose, Vec3

STIFFNESS, DAMPING = 1e12, 1.0  # kp, kd of a contact where a file gives none, as in sdformat
MAX_SPEED = 0.01  # [m/s] max_vel of a contact where a file gives none, as in sdformat
FRICTION = 1.0
FIELD_THICKNESS = 1.0  # [m] of a heightmap's box below its zero, as ODEHeightmapShape gives it
UNKNOWN = 2.0  # [m] radius of shapes of other kinds
KINDS = {"sphere": q.SPHERE, "cylinder": q.CYLINDER, "box": q.BOX, "mesh": q.MESH}


class Tree(NamedTuple):
    """A mesh in its own frame, scaled.

    Attributes:
        corners: (t, 9) triangles [m] in the order of the tree.
        nodes: (k, 6) center and half the edges of boxes [m].
        children: (k, 2) numbers of nodes, or -1 - the number of a triangle; q.NO_CHILD: none.
        depth: how deep it is.
        exact: (t, 9) a corner and two edges of each triangle, not in single precision [m].
    """

    corners: Array
    nodes: Array
    children: Array
    depth: int
    exact: Array


class Field(NamedTuple):
    """A heightmap in its own frame, z upwards.

    Attributes:
        heights: (rows, columns) [m], those at +y first.
        size: along x and y, and how high its box is [m].
    """

    heights: Array
    size: Vec3


def table(rows: Sequence[Any], columns: int, kind: Any = float) -> Array:
    """Rows as an array, which has its columns also where there is no row."""
    return np.array(rows, kind).reshape(len(rows), columns)


def set_inertia(row: Array, mass: float, inertia: Array) -> None:
    """Mass [kg] and inertia (3, 3) [kg m^2] of a row of bodies."""
    row[q.MASS] = mass
    row[q.INERTIA : q.INERTIA + 9] = inertia.ravel()
    row[q.INVERSE : q.INVERSE + 9] = np.linalg.inv(inertia).ravel()


def body_row(link: Link, max_speed: float) -> Array:
    """Row of a link that moves; max_speed [m/s]: of its contacts at most."""
    row = np.zeros(q.B_SIZE)
    row[q.QUAT + 3], row[q.PLACE] = 1.0, math.inf
    row[q.REST], row[q.REST_STEPS] = q.REST_TIME, q.REST_COUNT
    set_inertia(row, link.mass, link.inertia)
    surface = link.surface
    if link.collisions:  # the last counts
        surface = link.collisions[-1].surface or surface
    row[q.GRAVITY] = float(link.gravity)
    if link.kinematic:  # as heavy as what never moves
        row[q.MASS], row[q.GRAVITY] = q.INFINITE, 0.0
        row[q.INVERSE : q.INVERSE + 9] = 0.0
    row[q.DECAY : q.DECAY + 2] = link.decay
    row[q.MAX_VEL] = MAX_SPEED if surface.max_speed is None else surface.max_speed
    row[q.MAX_VEL] = min(row[q.MAX_VEL], max_speed)
    row[q.MIN_DEPTH] = surface.min_depth
    for shape in link.collisions:
        radius = reach(shape.geometry.kind, shape.geometry.size)
        distance = float(np.linalg.norm(np.subtract(shape.pose.position, link.center)))
        row[q.RADIUS] = max(row[q.RADIUS], radius + distance)
    return row


def extent(shape: Shape, link: Link, corners: Array) -> Array:
    """Center and half the edges (6,) [m] of a box around a shape, from its link's center of mass
    and along the link's axes; corners: of a mesh."""
    if len(corners):
        low, high = corners.min(axis=0), corners.max(axis=0)
        return np.concatenate([0.5 * (low + high), 0.5 * (high - low)])
    half = half_size(shape.geometry.kind, shape.geometry.size)
    half = np.full(3, UNKNOWN) if half is None else np.abs(shape.pose.matrix) @ half
    return np.concatenate([np.subtract(shape.pose.position, link.center), half])


def solid_size(kind: int, size: Sequence[float] | Array) -> Array:
    """Half the edges (3,), or radius and half the length [m], of a solid of an SDF's size; of a
    mesh: 0."""
    if kind == q.BOX:
        return 0.5 * np.asarray(size, float)
    if kind in (q.MESH, q.FIELD):
        return np.zeros(3)
    return np.array([size[0], 0.5 * size[1] if kind == q.CYLINDER else 0.0, 0.0])


def chunks(corners: Array) -> Array:
    """Boxes (m, 6) around q.CHUNK of vertices (n, 3) each: center and half the edges."""
    boxes = []
    for start in range(0, len(corners), q.CHUNK):
        low = corners[start : start + q.CHUNK].min(axis=0)
        high = corners[start : start + q.CHUNK].max(axis=0)
        boxes.append([*(0.5 * (low + high)), *(0.5 * (high - low))])
    return table(boxes, 6)


def reach(kind: str, size: tuple[float, ...]) -> float:
    """Radius [m] of a sphere around a shape's origin that contains it."""
    if kind == "sphere":
        return size[0]
    if kind == "cylinder":
        return math.hypot(size[0], 0.5 * size[1])
    if kind == "box":
        return 0.5 * math.hypot(*size)
    return 0.0


def half_size(kind: str, size: tuple[float, ...]) -> Array | None:
    """Half the edges (3,) [m] of a box around a shape, along its own axes; None: unknown."""
    if kind == "sphere":
        return np.full(3, size[0])
    if kind == "cylinder":
        return np.array([size[0], size[0], 0.5 * size[1]])
    return 0.5 * np.asarray(size, float) if kind == "box" else None


def field_row(field: Field, first: int) -> Array:
    """Row of a heightmap, whose heights begin at a number."""
    wide, deep, _ = field.size
    rows, columns = field.heights.shape
    steps = wide / (columns - 1), deep / (rows - 1)
    return np.array([wide, deep, *steps, columns, rows, first])


def field_box(field: Field, pose: Pose) -> Array:
    """Box (6,) around a heightmap in the world: from one meter below its zero to its height, where
    ODE has it, also where it is lower or higher."""
    wide, deep, high = field.size
    middle = pose * Pose((0.0, 0.0, 0.5 * (high - FIELD_THICKNESS)))
    half = np.abs(pose.matrix) @ (0.5 * np.array((wide, deep, high + FIELD_THICKNESS)))
    return np.concatenate([middle.position - half, middle.position + half])


def around(boxes: Array) -> Array:
    """Box (6,) around boxes (n, 6)."""
    return np.concatenate([boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)])


def make_tree(triangles: Array, scale: Vec3) -> Tree:
    """The tree of triangles (n, 3, 3) [m], which are scaled; single precision, as in Gazebo."""
    corners = triangles.astype(np.float32) * np.asarray(scale, np.float32)
    order, nodes, children, depth = sorted_tree(corners)
    exact = (triangles * np.asarray(scale))[order]
    exact[:, 1:] -= exact[:, :1]
    placed = corners[order].reshape(-1, 9).astype(float)
    return Tree(placed, nodes, children, depth, exact.reshape(-1, 9))


def sorted_tree(corners: Array) -> tuple[Array, Array, Array, int]:
    """Order (n,) of triangles (n, 3, 3), single precision, and their tree: as in a Tree its nodes,
    children and depth."""
    from bullet_sim.engine.quickstep.library import build_tree  # the solver 'bullet' has no numba

    count = len(corners)
    order = np.empty(count, np.int64)
    nodes = np.empty((max(1, count - 1), 6))
    children = np.full((max(1, count - 1), 2), q.NO_CHILD, np.int64)
    todo, means = np.empty((count + 1, 5), np.int64), np.empty(7, np.float32)
    depth = build_tree(Building(corners, order, nodes, children, todo, means))
    return order, nodes, children, depth


def shape_row(shape: Shape, link: Link) -> Array:
    """Row of a shape of a link that moves."""
    size, pose = shape.geometry.size, shape.pose
    row = np.zeros(q.G_COLUMNS)
    row[q.G_SIZE : q.G_SIZE + min(3, len(size))] = size[:3]
    row[q.G_OFFSET : q.G_OFFSET + 3] = np.subtract(pose.position, link.center)
    row[q.G_ROTATION : q.G_ROTATION + 9] = pose.matrix.ravel()
    surface_columns(row[q.G_MU :], shape.surface or link.surface)
    return row


def plane_row(normal: Array, distance: float, surface: Surface) -> Array:
    """Row of a plane: normal (3,), distance from the origin along it [m]."""
    row = np.zeros(q.P_COLUMNS)
    row[q.P_PLANE : q.P_PLANE + 4] = (*normal, distance)
    surface_columns(row[q.P_MU :], surface)
    return row


def surface_columns(row: Array, surface: Surface) -> None:
    """mu, mu2, fdir1 and what follows in the columns of shapes and planes."""
    row[:2] = friction(surface)
    if surface.direction is not None:
        row[2:5] = surface.direction
    row[5:9] = stiffness(surface), damping(surface), surface.slip1, surface.slip2
    row[9:11] = surface.bounce, surface.bounce_speed
    row[11:17] = *torsion(surface), surface.most


def torsion(surface: Surface) -> tuple[float, float, float, float, float]:
    """Torsional friction of a surface: coefficient, radius of the patch, of the surface [m],
    whether the patch's counts, slip; where a file gives none it is flat."""
    it = surface.torsion
    if it is None:
        return 1.0, 0.0, math.inf, 1.0, 0.0
    return it.coefficient, it.patch_radius, it.surface_radius, float(it.by_patch), it.slip


def friction(surface: Surface) -> tuple[float, float]:
    """mu and mu2 of a contact."""
    first, second = surface.friction, surface.friction2
    return FRICTION if first is None else first, FRICTION if second is None else second


def stiffness(surface: Surface) -> float:
    """kp [N/m] of a contact."""
    return surface.kp or STIFFNESS


def damping(surface: Surface) -> float:
    """kd [N s/m] of a contact."""
    return DAMPING if surface.kd is None else surface.kd

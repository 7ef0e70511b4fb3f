"""Rays: single ones, and all those of a lidar from one point.

What never moves is in Embree, where rays meet triangles instead of PyBullet's shapes: PyBullet
tests a ray against each shape of a body that it comes near, of a track's walls 128 boxes; Embree
against those few triangles that it meets. PyBullet casts the rays that come near anything else.
"""

import math
import operator
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pybullet as p

from bullet_sim.pose import Array, Pose, Quat, Vec3, Vector, matrix_from_quaternion

Box = tuple[Array, Array]  # lower and upper corner (3,) [m]

_CUBE = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_SIDES = np.array(  # corners of _CUBE's triangles, counter-clockwise seen from outside
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
    + [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
)
_CUBE_TRIANGLES = _CUBE[_SIDES]  # (12, 3, 3)


@dataclass
class Shapes:
    """Collision shapes of one body, in the frame of its link.

    Attributes:
        triangles: (n, 3, 3) corners [m].
        solid: (n,) whether a triangle is a side of a box, counter-clockwise seen from outside.
        planes: (point (3,) [m], normal (3,)) of each.
        spheres: (k, 4) centre and radius [m] around each other shape.
    """

    triangles: Array
    solid: Array
    planes: list[tuple[Array, Array]]
    spheres: Array


def read_shapes(path: str, with_triangles: bool) -> Shapes | None:
    """Shapes of the only link of what never moves.

    PyBullet tells the shapes of multibodies alone, and what never moves is none (Engine.load).

    Args:
        path: of the prepared URDF file that was loaded.
        with_triangles: False: boxes and meshes become spheres, too.

    Returns:
        None if a shape is of a type that is not known here.
    """
    triangles, solid, planes, spheres = [], [], [], []
    for collision in ET.parse(path).iterfind("link/collision"):
        origin, shape = collision.find("origin"), collision.find("geometry/*")
        if shape is None:
            return None
        pose = (
            Pose() if origin is None else Pose.from_xyz_rpy(*map(_floats(origin), ("xyz", "rpy")))
        )
        floats, place, turn = _floats(shape), np.array(pose.position), pose.matrix
        if shape.tag == "plane":
            planes.append((place, turn[:, 2]))
        elif shape.tag in ("box", "mesh"):
            size = floats("size" if shape.tag == "box" else "scale")
            own = _CUBE_TRIANGLES if shape.tag == "box" else mesh_triangles(shape.get("filename"))
            if own is None:
                return None
            own = (own * size) @ turn.T + place
            if with_triangles:
                triangles.append(own)
                solid.append(np.full(len(own), shape.tag == "box"))
            else:
                low, high = own.min(axis=(0, 1)), own.max(axis=(0, 1))
                spheres.append((*(low + high) / 2.0, np.linalg.norm(high - low) / 2.0))
        elif shape.tag == "sphere":
            spheres.append((*place, *floats("radius")))
        elif shape.tag == "cylinder":
            (length,), (radius,) = floats("length"), floats("radius")
            spheres.append((*place, np.hypot(length / 2.0, radius) + radius))
        else:
            return None
    return Shapes(
        np.concatenate([np.zeros((0, 3, 3)), *triangles]),
        np.concatenate([np.zeros(0, bool), *solid]),
        planes,
        np.reshape(np.array(spheres, float), (-1, 4)),
    )


def _floats(element: ET.Element) -> Callable[[str], tuple[float, ...]]:
    """Function of an attribute's name that returns its numbers."""
    return lambda name: tuple(map(float, element.get(name, "").split()))


def _load_mesh(path: str | None) -> Any:
    """A trimesh.Trimesh, or None if the file cannot be read."""
    import trimesh  # takes 0.2 s, for worlds with meshes alone

    try:
        return trimesh.load(path, force="mesh", process=False, skip_materials=True)
    except Exception:  # pylint: disable=broad-except  # whatever a reader raises: PyBullet has it
        return None


def mesh_triangles(path: str | None) -> Array | None:
    """Triangles (n, 3, 3) of a mesh file, or None if it cannot be read."""
    mesh = _load_mesh(path)
    triangles = np.zeros((0, 3, 3)) if mesh is None else np.asarray(mesh.triangles, float)
    return triangles if len(triangles) and np.isfinite(triangles).all() else None


def mesh_corners(path: str, shared: bool) -> Array:
    """Vertices (n, 3) of a mesh file as Gazebo has them, in the order of its triangles.

    Of STL and OBJ files it has three for each triangle. There are none if the file cannot be read.

    Args:
        shared: triangles share those that have the same place and normal, as of COLLADA files.
    """
    mesh = _load_mesh(path)
    if mesh is None or not np.isfinite(mesh.vertices).all():
        return np.zeros((0, 3))
    order = np.asarray(mesh.faces).ravel()
    corners = np.asarray(mesh.vertices, float)[order]
    if shared:
        normals = np.asarray(mesh.vertex_normals, float)[order]
        _, first = np.unique(np.hstack([corners, normals]), axis=0, return_index=True)
        corners = corners[np.sort(first)]
    return corners


MOST_MOVES = 3  # a body that is put elsewhere more often is not taken for scenery any more
FARTHEST = 4000.0  # corner from the middle [m], where single precision has 0.25 mm


class Scenery:
    """The bodies that never move, as they stand.

    Attributes:
        planes: (point (3,) [m], normal (3,)) of each in the world.
        spheres: (k, 4) centre and radius [m] around what PyBullet has to cast at.
    """

    def __init__(self, client: int) -> None:
        self._client = client
        self._paths: dict[int, str] = {}  # of the prepared URDF files
        self._shapes: dict[int, Any] = {}  # Shapes, None: not read yet
        self._poses: dict[int, tuple[Vec3, Quat]] = {}
        self._moves: dict[int, int] = {}
        self._is_current = True  # no pose has changed since the last look at them
        self._has_same = True  # no body has come or gone since
        self._scene: Any = None
        self.planes: list[tuple[Array, Array]] = []
        self.spheres = np.zeros((0, 4))

    def __contains__(self, body: int | None) -> bool:
        return body in self._shapes

    def add(self, body: int, path: str) -> None:
        """Take a body of which meshes collide as they are, and its prepared URDF file."""
        self._paths[body], self._shapes[body], self._moves[body] = path, None, 0
        self._is_current = self._has_same = False

    def discard(self, body: int) -> None:
        """Leave a body to PyBullet from now on, or forget one that is removed."""
        if body in self._shapes:
            self._forget(body)
            self._is_current = self._has_same = False

    def _forget(self, body: int) -> None:
        del self._paths[body], self._shapes[body], self._moves[body]
        self._poses.pop(body, None)  # another body may get its number

    def check_poses(self) -> None:
        """Bodies may stand elsewhere now."""
        self._is_current = False

    def refresh(self) -> None:
        """Take the bodies as they stand now; needed before anything is read or cast."""
        if self._is_current:
            return
        self._is_current = True
        poses = {
            body: p.getBasePositionAndOrientation(body, physicsClientId=self._client)
            for body in self._shapes
        }
        if self._has_same and poses == self._poses:
            return
        self._has_same = True
        for body, pose in poses.items():
            if self._shapes[body] is None:
                self._shapes[body] = read_shapes(self._paths[body], _has_embree())
            self._moves[body] += self._poses.get(body, pose) != pose
            if self._shapes[body] is None or self._moves[body] > MOST_MOVES:
                self._forget(body)
        self._poses = {body: poses[body] for body in self._shapes}
        self._build()

    def _build(self) -> None:
        triangles, solid, spheres = [np.zeros((0, 3, 3))], [], [np.zeros((0, 4))]
        self.planes = []
        for body, shapes in self._shapes.items():
            position, orientation = self._poses[body]
            turn = matrix_from_quaternion(orientation).T
            triangles.append(shapes.triangles @ turn + position)
            solid.append(shapes.solid)
            centres = shapes.spheres[:, :3] @ turn + position
            spheres.append(np.column_stack([centres, shapes.spheres[:, 3]]))
            self.planes += [(at @ turn + position, normal @ turn) for at, normal in shapes.planes]
        corners = np.concatenate(triangles)
        self._scene = None
        if len(corners):
            self._low, self._high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
            self._middle = (self._low + self._high) / 2.0
            radius = np.linalg.norm(self._high - self._middle)
            if radius > FARTHEST:
                spheres.append(np.array([(*self._middle, radius)]))
            else:
                self._take(corners, np.concatenate(solid))
        self.spheres = np.concatenate(spheres)

    def _take(self, corners: Array, solid: Array) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        edges = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        self._normals = np.cross(*edges)
        self._offsets = np.einsum("ij,ij->i", self._normals, corners[:, 0] - self._middle)
        self._solid = solid
        self._scene = EmbreeScene(robust=True)
        TriangleMesh(self._scene, (corners - self._middle).astype(np.float32))

    def cast(
        self,
        centre: Array,
        directions: Array,
        box: Box,
        start: float,
        end: float,
    ) -> tuple[Array, Array] | None:
        """Cast rays at the triangles.

        Args:
            centre: (3,) [m] from which all rays come.
            directions: (n, 3) unit vectors.
            box: two corners (3,) [m] of a box that contains the rays.
            start, end: distances from the centre between which they are cast [m].

        Returns:
            distances (n,) [m] from the centre, inf: none; numbers (m,) of rays that begin inside
            a box, which PyBullet does not see from there. Or None: nothing is near.
        """
        if self._scene is None or (box[0] > self._high).any() or (box[1] < self._low).any():
            return None
        centre = centre - self._middle
        vectors = directions.astype(np.float32)
        origins = np.empty_like(vectors)
        origins[:] = centre
        if start > 0.0:
            origins += np.float32(start) * vectors
        limits = np.full(len(vectors), end - start, np.float32)
        hit = self._scene.run(origins, vectors, limits, query="INTERSECT")
        # in double precision again: the bits are those of the triangle, whatever the processor
        normals = self._normals[hit]
        along = np.einsum("ij,ij->i", normals, directions)
        with np.errstate(divide="ignore", invalid="ignore"):
            distances = (self._offsets[hit] - normals @ centre) / along
        found = hit >= 0
        inside = np.flatnonzero(found & self._solid[hit] & (along > 0.0))
        np.clip(distances, start, end, out=distances)
        distances[~found] = np.inf
        return distances, inside


def _has_embree() -> bool:
    """Whether there is a wheel of it; else PyBullet casts all."""
    try:
        import embreex.mesh_construction
        import embreex.rtcore_scene  # noqa: F401
    except ImportError:
        return False
    return True


_MARGIN = 0.01  # around a box that may be hit [m]
_ALL, _MOVING = -1, ~2  # masks of rays; Bullet's group 2 is what never moves
_BODY, _FRACTION = operator.itemgetter(0), operator.itemgetter(2)  # of a ray's hit


class RayCaster:
    """Casts rays at the bodies of an engine.

    Args:
        free: bodies whose root link is not fixed; the caller changes it.

    Attributes:
        scenery: what never moves.
    """

    def __init__(self, client: int, free: set[int]) -> None:
        self._client, self._free = client, free
        self.scenery = Scenery(client)

    def cast(self, origins: Any, targets: Any, mask: int = _ALL) -> tuple[Array, Array]:
        """Cast rays between points (n, 3) of the world frame at what has a group of the mask.

        Returns:
            fractions (n,) of the way to the first hit, 1.0 for a miss; bodies (n,), -1: miss.
        """
        hits: list[tuple[Any, ...]] = []
        limit = p.MAX_RAY_INTERSECTION_BATCH_SIZE
        origins, targets = np.asarray(origins), np.asarray(targets)
        for start in range(0, len(origins), limit):
            hits += p.rayTestBatch(
                origins[start : start + limit],
                targets[start : start + limit],
                collisionFilterMask=mask,
                physicsClientId=self._client,
            )
        return (
            np.fromiter(map(_FRACTION, hits), float, len(hits)),
            np.fromiter(map(_BODY, hits), int, len(hits)),
        )

    def sweep(
        self,
        centre: Array,
        directions: Array,
        box: Box,
        near: float,
        far: float,
        own: int | None = None,
        look_near: bool = True,
    ) -> Array:
        """Distances to what the rays of a lidar hit first.

        Args:
            centre: (3,) [m] in the world, from which all come.
            directions: (n, 3) unit vectors, world axes.
            box: two corners (3,) [m] of a box that contains the rays up to `far`.
            near, far: distances between which a hit is measured [m].
            own: body that does not count where it is nearer than `near`.
            look_near: whether to look for what is nearer than `near`.

        Returns:
            (n,) float64 [m]; inf: nothing up to `far`; -inf: something nearer than `near`.
        """
        scenery = self.scenery
        scenery.refresh()
        look_near = look_near and near > 0.0
        is_housed = own in scenery  # then PyBullet tells its own body from the others
        start = 0.0 if look_near and not is_housed else near
        ranges, again = self._cast_at_scenery(centre, directions, box, start, far)
        rays = {_ALL: again, _MOVING: None}
        too_near = None if not (look_near and is_housed) else np.ones(len(directions), bool)
        for low, high, mask, body in self._others(box):
            corner = np.maximum(np.subtract(high, centre), np.subtract(centre, low))
            if corner @ corner > near * near:
                found = _towards(low, high, centre, directions, near, far)
                rays[mask] = _either(rays[mask], found)
            if look_near and body != own:
                found = _towards(low, high, centre, directions, 0.0, near)
                too_near = _either(too_near, found)
        for mask, wanted in rays.items():
            if wanted is not None:
                distances, _ = self._distances(centre, directions[wanted], near, far, mask)
                ranges[wanted] = np.minimum(ranges[wanted], distances)
        if look_near:
            ranges[ranges < near] = -np.inf
        if too_near is not None:
            distances, bodies = self._distances(centre, directions[too_near], 0.0, near, _ALL)
            hit = np.isfinite(distances) & (bodies != own)
            ranges[np.flatnonzero(too_near)[hit]] = -np.inf
        return ranges

    def _cast_at_scenery(
        self,
        centre: Array,
        directions: Array,
        box: Box,
        start: float,
        far: float,
    ) -> tuple[Array, Array | None]:
        """Distances (n,), and which rays (n,) PyBullet has to cast again, or None."""
        ranges, again = np.full(len(directions), np.inf), None
        found = self.scenery.cast(centre, directions, box, start, far)
        if found is not None:
            ranges, inside = found
            if len(inside):
                again = np.zeros(len(directions), bool)
                again[inside], ranges[inside] = True, np.inf
        middle, half = np.add(*box) / 2.0, np.subtract(box[1], box[0]) / 2.0
        for point, normal in self.scenery.planes:
            height = normal @ np.subtract(centre, point)
            reach = np.abs(normal) @ half
            if abs(normal @ (middle - point)) > reach:  # the whole box is on one side
                continue
            with np.errstate(divide="ignore", invalid="ignore"):
                distances = -height / (directions @ normal)
            hit = (distances >= start) & (distances <= far)
            ranges[hit] = np.minimum(ranges[hit], distances[hit])
        return ranges, again

    def _others(self, box: Box) -> Iterator[tuple[Vector, Vector, int, int]]:
        """Boxes (low, high) of what PyBullet has to cast at, the rays' mask, the body or -1."""
        overlapping = p.getOverlappingObjects(*map(tuple, box), physicsClientId=self._client) or ()
        for body, link in sorted(set(overlapping)):
            if body not in self.scenery:
                fixed = link < 0 and body not in self._free
                low, high = p.getAABB(body, link, physicsClientId=self._client)
                yield low, high, _ALL if fixed else _MOVING, body
        for *centre, radius in self.scenery.spheres:
            yield np.subtract(centre, radius), np.add(centre, radius), _ALL, -1

    def _distances(
        self, centre: Array, directions: Array, start: float, end: float, mask: int
    ) -> tuple[Array, Array]:
        """Distances (n,) [m] of the nearest hits, inf: none, and bodies (n,)."""
        fractions, bodies = self.cast(centre + start * directions, centre + end * directions, mask)
        distances = start + fractions * (end - start)
        return np.where(bodies >= 0, distances, np.inf), bodies


def _either(first: Array | None, second: Array | None) -> Array | None:
    if first is None or second is None:
        return first if second is None else second
    return first | second


def _towards(
    low: Vector,
    high: Vector,
    centre: Array,
    directions: Array,
    near: float,
    far: float,
) -> Array | None:
    """Which rays (n,) may meet a box between two distances; None: none does.

    Args:
        low, high: corners (3,) [m].
        centre: (3,) [m] from which the rays come.
        directions: (n, 3) unit vectors.
        near, far: [m].
    """
    way = np.add(low, high) / 2.0 - centre
    half = np.subtract(high, low) / 2.0 + _MARGIN
    outside = np.maximum(np.abs(way) - half, 0.0)
    if outside @ outside > far * far:
        return None
    square = way @ way - half @ half
    if square > 0.0:  # a cone around the sphere that contains the box
        found = directions @ way >= math.sqrt(square)
    else:
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.stack([way - half, way + half])[:, None] / directions
        enter, leave = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
        found = ~((enter > leave) | (leave < near) | (enter > far))
    return found if found.any() else None

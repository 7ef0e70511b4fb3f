"""Rays: single ones, and all those of a lidar from one point.

What never moves is in Embree, where rays meet triangles instead of PyBullet's shapes: PyBullet
tests a ray against each shape of a body that it comes near, of a track's walls 128 boxes; Embree
against those few triangles that it meets. So are the meshes of what moves with the solver 'ode'.
Spheres and cylinders, and what boxes move with it, have closed forms here. PyBullet casts the rays
that come near anything else.
"""

import functools
import math
import operator
import os
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pybullet as p

from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.state import Casting
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
        rounds: spheres and cylinders.
        spheres: (k, 4) center and radius [m] around each other shape.
    """

    triangles: Array
    solid: Array
    planes: list[tuple[Array, Array]]
    rounds: "list[RayShape]"
    spheres: Array


def read_shapes(path: str, with_triangles: bool, body: int) -> Shapes | None:
    """Shapes of the only link of what never moves.

    PyBullet tells the shapes of multibodies alone, and what never moves is none (Engine.load).

    Args:
        path: of the prepared URDF file that was loaded.
        with_triangles: False: boxes and meshes become spheres, too.

    Returns:
        None if a shape is of a type that is not known here.
    """
    triangles, solid, planes, rounds, spheres = [], [], [], [], []
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
        elif shape.tag in ("sphere", "cylinder"):
            (radius,), (length,) = floats("radius"), floats("length") or (0.0,)
            size, around = np.array([radius, length / 2.0, 0.0]), math.hypot(radius, length / 2.0)
            rounds.append(RayShape(body, 0, shape.tag, size, place, turn, around))
        else:
            return None
    return Shapes(
        np.concatenate([np.zeros((0, 3, 3)), *triangles]),
        np.concatenate([np.zeros(0, bool), *solid]),
        planes,
        rounds,
        np.reshape(np.array(spheres, float), (-1, 4)),
    )


def _floats(element: ET.Element) -> Callable[[str], tuple[float, ...]]:
    """Function of an attribute's name that returns its numbers."""
    return lambda name: tuple(map(float, element.get(name, "").split()))


def _load_mesh(path: str | None) -> Any:
    """A trimesh.Trimesh, or None if the file cannot be read."""
    try:
        changed = os.stat(path or "").st_mtime_ns
    except OSError:
        return None
    return _load_file(path, changed)


@functools.lru_cache(maxsize=1)  # its vertices and its triangles are asked for, one after the other
def _load_file(path: str | None, _changed: int) -> Any:
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


class Triangles:
    """Triangles (n, 3, 3) [m] in Embree."""

    def __init__(self, corners: Array) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        edges = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        self._normals = np.cross(*edges)
        self._offsets = np.einsum("ij,ij->i", self._normals, corners[:, 0])
        self._scene = EmbreeScene(robust=True)
        TriangleMesh(self._scene, corners.astype(np.float32))

    def cast(
        self, center: Array, directions: Array, start: float, end: float
    ) -> tuple[Array, Array, Array]:
        """Distances (n,) [m] from the center (3,), inf: none; triangles (n,), -1: none; and the
        directions (n,) along the triangles' normals."""
        vectors = directions.astype(np.float32)
        origins = np.empty_like(vectors)
        origins[:] = center
        if start > 0.0:
            origins += np.float32(start) * vectors
        limits = np.full(len(vectors), end - start, np.float32)
        hit = self._scene.run(origins, vectors, limits, query="INTERSECT")
        # in double precision again: the bits are those of the triangle, whatever the processor
        normals = self._normals[hit]
        along = np.einsum("ij,ij->i", normals, directions)
        with np.errstate(divide="ignore", invalid="ignore"):
            distances = (self._offsets[hit] - normals @ center) / along
        np.maximum(distances, start, out=distances)
        np.minimum(distances, end, out=distances)
        distances[hit < 0] = np.inf
        return distances, hit, along


@dataclass
class RayShape:
    """A shape at which rays are cast here.

    Attributes:
        body, row: PyBullet's number, the row of its link.
        kind: "box", "sphere", "cylinder" or "mesh".
        size: (3,) half the edges; radius; radius and half the length [m].
        place, turn: in the link, from its center of mass [m].
        radius: of a sphere around it [m].
        triangles: of a mesh.
    """

    body: int
    row: int
    kind: str
    size: Array
    place: Array
    turn: Array
    radius: float
    triangles: Triangles | None = None


KINDS = {"sphere": q.SPHERE, "cylinder": q.CYLINDER, "box": q.BOX, "mesh": q.MESH}


@functools.cache
def _caster() -> Callable[[Casting], Callable[[float], Any]]:
    """Makes the function that casts at what moves; imported once it is needed, since numba takes a
    while."""
    try:
        from bullet_sim.engine.quickstep.library import caster
    except ImportError:  # neither library nor numba
        from bullet_sim.engine.quickstep.rays import cast

        return lambda casting: lambda far: cast(far, casting)
    return caster


class RayShapes:
    """All shapes of bodies, by PyBullet's numbers, at which no ray of PyBullet needs to be cast.

    Attributes:
        bodies: these numbers.
    """

    def __init__(self, of_bodies: dict[int, list[RayShape]]) -> None:
        self._shapes = shapes = [shape for each in of_bodies.values() for shape in each]
        self.bodies = set(of_bodies)
        self._rows = np.array([shape.row for shape in shapes], int)
        self._places = np.reshape([shape.place for shape in shapes], (-1, 3, 1))
        self._turns = np.reshape([shape.turn for shape in shapes], (-1, 3, 3))
        self._radii = np.array([shape.radius for shape in shapes], float)
        self._sizes = np.reshape([shape.size for shape in shapes], (-1, 3))
        self._kinds = np.array([KINDS[shape.kind] for shape in shapes], np.int64)
        traced = [shape.kind == "mesh" and shape.triangles is not None for shape in shapes]
        self._meshes = np.flatnonzero(traced)
        self._owners = np.array([shape.body for shape in shapes], int)
        self._turned = np.empty((len(shapes), 3, 3))  # where their links are
        self._centers, self._frames = np.empty((len(shapes), 3)), np.empty((len(shapes), 3, 3))
        self._castings: dict[int, tuple[Casting, Callable[[float], Any]]] = {}  # of so many rays

    def __len__(self) -> int:
        return len(self._shapes)

    def place(self, positions: Array, orientations: Array) -> None:
        """Put the shapes where the links of all rows are: their centers of mass (m, 3) [m], their
        quaternions (m, 4)."""
        x, y, z, w = orientations[self._rows].T
        ww, xy, xz, yz, wx, wy, wz = w * w, x * y, x * z, y * z, w * x, w * y, w * z
        turn = self._turned
        turn[:, 0, 0], turn[:, 0, 1], turn[:, 0, 2] = ww + x * x - 0.5, xy - wz, xz + wy
        turn[:, 1, 0], turn[:, 1, 1], turn[:, 1, 2] = xy + wz, ww + y * y - 0.5, yz - wx
        turn[:, 2, 0], turn[:, 2, 1], turn[:, 2, 2] = xz - wy, yz + wx, ww + z * z - 0.5
        turn *= 2.0
        np.add(positions[self._rows], (turn @ self._places)[:, :, 0], out=self._centers)
        np.matmul(turn, self._turns, out=self._frames)

    def _casting(self, rays: int) -> tuple[Casting, Callable[[float], Any]]:
        """Arrays of a number of rays, which stay where they are, and the function that casts."""
        if rays not in self._castings:
            point, low, high = np.empty((3, 3))
            casting = Casting(
                point, np.empty((rays, 3)), low, high, self._centers, self._frames,
                self._sizes, self._radii, self._kinds, np.empty(len(self)), np.empty(rays),
            )  # fmt: skip
            self._castings[rays] = casting, _caster()(casting)
        return self._castings[rays]

    def cast(
        self,
        center: Array,
        directions: Array,
        box: Box,
        near: float,
        far: float,
        own: int | None,
        look_near: bool,
    ) -> Array:
        """As RayCaster.sweep; a ray that begins inside a shape does not meet it, but a mesh, which
        is a surface."""
        casting, cast = self._casting(len(directions))
        casting.center[:], casting.directions[:] = center, directions
        casting.low[:], casting.high[:] = box
        starts = casting.starts
        starts[:] = near
        if look_near:
            starts[self._owners != own] = 0.0
        casting.ranges[:] = np.inf
        cast(float(far))
        ranges = casting.ranges.copy()
        for number in self._near_meshes(center, box, starts):
            triangles: Any = self._shapes[number].triangles
            way, radius = self._centers[number] - center, self._radii[number]
            away = math.hypot(*way)
            square = away * away - radius * radius
            tangent = math.sqrt(square) if square > 0.0 else -np.inf
            ray = (directions @ way >= tangent).nonzero()[0]
            if len(ray):
                frame, start = self._frames[number], float(starts[number])
                hits = triangles.cast(-way @ frame, directions[ray] @ frame, start, far)
                ranges[ray] = np.minimum(ranges[ray], hits[0])
        if look_near:
            ranges[ranges < near] = -np.inf
        return ranges

    def _near_meshes(self, center: Array, box: Box, starts: Array) -> list[int]:
        """Numbers of the meshes whose spheres reach into a box, and beyond where hits count."""
        numbers = self._meshes
        if not len(numbers):
            return []
        at, radii = self._centers[numbers], self._radii[numbers]
        wide, way = radii[:, None], at - center
        outside = ((at + wide < box[0]) | (at - wide > box[1])).any(1)
        outside |= np.sqrt((way * way).sum(1)) + radii < starts[numbers]  # the lidar's housing
        found: list[int] = numbers[~outside].tolist()
        return found


MOST_MOVES = 3  # a body that is put elsewhere more often is not taken for scenery any more
FARTHEST = 4000.0  # corner from the middle [m], where single precision has 0.25 mm


class Scenery:
    """The bodies that never move, as they stand.

    Attributes:
        planes: (point (3,) [m], normal (3,)) of each in the world.
        rounds: spheres and cylinders.
        spheres: (k, 4) center and radius [m] around what PyBullet has to cast at.
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
        self.rounds = RayShapes({})
        self.spheres = np.zeros((0, 4))

    def __contains__(self, body: int | None) -> bool:
        return body in self._shapes

    def __len__(self) -> int:
        return len(self._shapes)

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
                self._shapes[body] = read_shapes(self._paths[body], has_embree(), body)
            self._moves[body] += self._poses.get(body, pose) != pose
            if self._shapes[body] is None or self._moves[body] > MOST_MOVES:
                self._forget(body)
        self._poses = {body: poses[body] for body in self._shapes}
        self._build()

    def _build(self) -> None:
        triangles, solid, spheres = [np.zeros((0, 3, 3))], [], [np.zeros((0, 4))]
        self.planes, rounds = [], {}
        for row, (body, shapes) in enumerate(self._shapes.items()):
            position, orientation = self._poses[body]
            rounds[body] = [replace(shape, row=row) for shape in shapes.rounds]
            turn = matrix_from_quaternion(orientation).T
            triangles.append(shapes.triangles @ turn + position)
            solid.append(shapes.solid)
            centers = shapes.spheres[:, :3] @ turn + position
            spheres.append(np.column_stack([centers, shapes.spheres[:, 3]]))
            self.planes += [(at @ turn + position, normal @ turn) for at, normal in shapes.planes]
        self.rounds = RayShapes(rounds)
        poses = [
            np.reshape([pose[i] for pose in self._poses.values()], (-1, n))
            for i, n in enumerate((3, 4))
        ]
        self.rounds.place(*poses)
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
        self._solid = solid
        self._scene = Triangles(corners - self._middle)

    def cast(
        self,
        center: Array,
        directions: Array,
        box: Box,
        start: float,
        end: float,
    ) -> tuple[Array, Array] | None:
        """Cast rays at the triangles.

        Args:
            center: (3,) [m] from which all rays come.
            directions: (n, 3) unit vectors.
            box: two corners (3,) [m] of a box that contains the rays.
            start, end: distances from the center between which they are cast [m].

        Returns:
            distances (n,) [m] from the center, inf: none; numbers (m,) of rays that begin inside
            a box, which PyBullet does not see from there. Or None: nothing is near.
        """
        if self._scene is None or (box[0] > self._high).any() or (box[1] < self._low).any():
            return None
        distances, hit, along = self._scene.cast(center - self._middle, directions, start, end)
        found = hit >= 0
        inside = (found & self._solid[hit] & (along > 0.0)).nonzero()[0]
        return distances, inside


def has_embree() -> bool:
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
        moving: gives what moves, where it is now; None: PyBullet casts at all of that.
        sync: puts PyBullet's bodies where they are.
    """

    def __init__(self, client: int, free: set[int]) -> None:
        self._client, self._free = client, free
        self.scenery = Scenery(client)
        self.moving: Callable[[], RayShapes | None] = lambda: None
        self.sync: Callable[[], None] = lambda: None

    def cast(self, origins: Any, targets: Any, mask: int = _ALL) -> tuple[Array, Array]:
        """Cast rays between points (n, 3) of the world frame at what has a group of the mask.

        Returns:
            fractions (n,) of the way to the first hit, 1.0 for a miss; bodies (n,), -1: miss.
        """
        self.sync()
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
        center: Array,
        directions: Array,
        box: Box,
        near: float,
        far: float,
        own: int | None = None,
        look_near: bool = True,
    ) -> Array:
        """Distances to what the rays of a lidar hit first.

        Args:
            center: (3,) [m] in the world, from which all come.
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
        ranges, again = self._cast_at_scenery(center, directions, box, start, far)
        rays = {_ALL: again, _MOVING: None}
        too_near = None if not (look_near and is_housed) else np.ones(len(directions), bool)
        moving = self.moving()
        for shapes in (scenery.rounds, moving):
            if shapes:
                hits = shapes.cast(center, directions, box, near, far, own, look_near)
                ranges = np.minimum(ranges, hits)
        for low, high, mask, body in self._others(box, set() if moving is None else moving.bodies):
            corner = np.maximum(np.subtract(high, center), np.subtract(center, low))
            if corner @ corner > near * near:
                found = _towards(low, high, center, directions, near, far)
                rays[mask] = _either(rays[mask], found)
            if look_near and body != own:
                found = _towards(low, high, center, directions, 0.0, near)
                too_near = _either(too_near, found)
        for mask, wanted in rays.items():
            if wanted is not None:
                distances, _ = self._distances(center, directions[wanted], near, far, mask)
                ranges[wanted] = np.minimum(ranges[wanted], distances)
        if look_near:
            ranges[ranges < near] = -np.inf
        if too_near is not None:
            distances, bodies = self._distances(center, directions[too_near], 0.0, near, _ALL)
            hit = np.isfinite(distances) & (bodies != own)
            ranges[np.flatnonzero(too_near)[hit]] = -np.inf
        return ranges

    def _cast_at_scenery(
        self,
        center: Array,
        directions: Array,
        box: Box,
        start: float,
        far: float,
    ) -> tuple[Array, Array | None]:
        """Distances (n,), and which rays (n,) PyBullet has to cast again, or None."""
        ranges, again = np.full(len(directions), np.inf), None
        found = self.scenery.cast(center, directions, box, start, far)
        if found is not None:
            ranges, inside = found
            if len(inside):
                again = np.zeros(len(directions), bool)
                again[inside], ranges[inside] = True, np.inf
        middle, half = np.add(*box) / 2.0, np.subtract(box[1], box[0]) / 2.0
        for point, normal in self.scenery.planes:
            height = normal @ np.subtract(center, point)
            reach = np.abs(normal) @ half
            if abs(normal @ (middle - point)) > reach:  # the whole box is on one side
                continue
            with np.errstate(divide="ignore", invalid="ignore"):
                distances = -height / (directions @ normal)
            hit = (distances >= start) & (distances <= far)
            ranges[hit] = np.minimum(ranges[hit], distances[hit])
        return ranges, again

    def _others(self, box: Box, known: set[int]) -> Iterator[tuple[Vector, Vector, int, int]]:
        """Boxes (low, high) of what PyBullet has to cast at, the rays' mask, the body or -1.

        Args:
            known: bodies at which it has not.
        """
        overlapping: Any = ()
        if p.getNumBodies(physicsClientId=self._client) > len(self.scenery) + len(known):
            self.sync()
            overlapping = p.getOverlappingObjects(*map(tuple, box), physicsClientId=self._client)
        for body, link in sorted(set(overlapping or ())):
            if body not in self.scenery and body not in known:
                fixed = link < 0 and body not in self._free
                low, high = p.getAABB(body, link, physicsClientId=self._client)
                yield low, high, _ALL if fixed else _MOVING, body
        for *center, radius in self.scenery.spheres:
            yield np.subtract(center, radius), np.add(center, radius), _ALL, -1

    def _distances(
        self, center: Array, directions: Array, start: float, end: float, mask: int
    ) -> tuple[Array, Array]:
        """Distances (n,) [m] of the nearest hits, inf: none, and bodies (n,)."""
        fractions, bodies = self.cast(center + start * directions, center + end * directions, mask)
        distances = start + fractions * (end - start)
        return np.where(bodies >= 0, distances, np.inf), bodies


def _either(first: Array | None, second: Array | None) -> Array | None:
    if first is None or second is None:
        return first if second is None else second
    return first | second


def _towards(
    low: Vector,
    high: Vector,
    center: Array,
    directions: Array,
    near: float,
    far: float,
) -> Array | None:
    """Which rays (n,) may meet a box between two distances; None: none does.

    Args:
        low, high: corners (3,) [m].
        center: (3,) [m] from which the rays come.
        directions: (n, 3) unit vectors.
        near, far: [m].
    """
    way = np.add(low, high) / 2.0 - center
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

"""What never moves, in Embree, so that rays meet triangles instead of shapes of PyBullet.

What never moves: rays are cast at it by Embree, not by PyBullet. PyBullet tests a ray against each
shape of a body that it comes near, of a track's walls 128 boxes; Embree against those few triangles
that it meets.
"""

from dataclasses import dataclass

import numpy as np

from bullet_sim.engine.library import p
from bullet_sim.pose import matrix_from_quaternion

_CUBE = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_SIDES = np.array(  # corners of _CUBE's triangles, counter-clockwise seen from outside
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
    + [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
)
_CUBE_TRIANGLES = _CUBE[_SIDES]  # (12, 3, 3)


@dataclass
class Shapes:
    """Collision shapes of one body, in the frame of its inertia.

    Attributes:
        triangles: (n, 3, 3) corners [m].
        solid: (n,) whether a triangle is a side of a box, counter-clockwise seen from outside.
        planes: list of (point (3,) [m], normal (3,)).
        spheres: (k, 4) centre and radius [m] around each other shape.
    """

    triangles: np.ndarray
    solid: np.ndarray
    planes: list
    spheres: np.ndarray


def read_shapes(client, body, with_triangles):
    """Shapes of a body's root link, the only one of what never moves.

    Args:
        client: PyBullet's number of the client.
        body: its number.
        with_triangles: False: boxes and meshes become spheres, too.

    Returns:
        Shapes, or None if a shape is of a kind that is not known here.
    """
    triangles, solid, planes, spheres = [], [], [], []
    for shape in p.getCollisionShapeData(body, -1, physicsClientId=client):
        kind, size, path, place = shape[2], np.array(shape[3]), shape[4], np.array(shape[5])
        turn = matrix_from_quaternion(shape[6])
        if kind == p.GEOM_PLANE:
            planes.append((place, turn[:, 2]))
        elif kind in (p.GEOM_BOX, p.GEOM_MESH):
            own = _CUBE_TRIANGLES if kind == p.GEOM_BOX else _mesh_triangles(path)
            if own is None:
                return None
            own = (own * size) @ turn.T + place
            if with_triangles:
                triangles.append(own)
                solid.append(np.full(len(own), kind == p.GEOM_BOX))
            else:
                low, high = own.min(axis=(0, 1)), own.max(axis=(0, 1))
                spheres.append((*(low + high) / 2.0, np.linalg.norm(high - low) / 2.0))
        elif kind == p.GEOM_SPHERE:
            spheres.append((*place, size[0]))
        elif kind in (p.GEOM_CYLINDER, p.GEOM_CAPSULE):  # length, radius
            spheres.append((*place, np.hypot(size[0] / 2.0, size[1]) + size[1]))
        else:
            return None
    return Shapes(
        np.concatenate([np.zeros((0, 3, 3)), *triangles]),
        np.concatenate([np.zeros(0, bool), *solid]),
        planes,
        np.reshape(np.array(spheres, float), (-1, 4)),
    )


def _mesh_triangles(path):
    """Triangles (n, 3, 3) of a mesh file, or None if it cannot be read."""
    import trimesh  # takes 0.2 s, for worlds with meshes alone

    try:
        mesh = trimesh.load(path.decode(), force="mesh", process=False, skip_materials=True)
    except Exception:  # pylint: disable=broad-except  # whatever a reader raises: PyBullet has it
        return None
    triangles = np.asarray(mesh.triangles, float)
    return triangles if len(triangles) and np.isfinite(triangles).all() else None


MOST_MOVES = 3  # a body that is put elsewhere more often is not taken for scenery any more
FARTHEST = 4000.0  # corner from the middle [m], where single precision has 0.25 mm


class Scenery:
    """The bodies that never move, as they stand.

    Args:
        client: PyBullet's number of the client.

    Attributes:
        planes: list of (point (3,) [m], normal (3,)) in the world.
        spheres: (k, 4) centre and radius [m] around what PyBullet has to cast at.
    """

    def __init__(self, client):
        self._client = client
        self._shapes, self._poses, self._moves = {}, {}, {}
        self._is_current = True  # no pose has changed since the last look at them
        self._has_same = True  # no body has come or gone since
        self._scene = None
        self.planes, self.spheres = [], np.zeros((0, 4))

    def __contains__(self, body):
        return body in self._shapes

    def add(self, body):
        """Take a body of which meshes collide as they are."""
        self._shapes[body], self._moves[body] = None, 0
        self._is_current = self._has_same = False

    def discard(self, body):
        """Leave a body to PyBullet from now on, or forget one that is removed."""
        if body in self._shapes:
            self._forget(body)
            self._is_current = self._has_same = False

    def _forget(self, body):
        del self._shapes[body], self._moves[body]
        self._poses.pop(body, None)  # another body may get its number

    def check_poses(self):
        """Bodies may stand elsewhere now."""
        self._is_current = False

    def refresh(self):
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
                self._shapes[body] = read_shapes(self._client, body, _embree() is not None)
            self._moves[body] += self._poses.get(body, pose) != pose
            if self._shapes[body] is None or self._moves[body] > MOST_MOVES:
                self._forget(body)
        self._poses = {body: poses[body] for body in self._shapes}
        self._build()

    def _build(self):
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
                spheres.append([(*self._middle, radius)])
            else:
                self._take(corners, np.concatenate(solid))
        self.spheres = np.concatenate(spheres)

    def _take(self, corners, solid):
        scene, mesh = _embree()
        edges = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        self._normals = np.cross(*edges)
        self._offsets = np.einsum("ij,ij->i", self._normals, corners[:, 0] - self._middle)
        self._solid = solid
        self._scene = scene(robust=True)
        mesh(self._scene, (corners - self._middle).astype(np.float32))

    def cast(self, centre, directions, box, start, end):
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


def _embree():
    """Embree's scene and triangle mesh, or None where there is no wheel: PyBullet casts all."""
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ImportError:
        return None
    return EmbreeScene, TriangleMesh

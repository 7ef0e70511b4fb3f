"""What never moves: rays are cast at it by Embree, not by PyBullet.

PyBullet tests a ray against each shape of a body that it comes near, of a track's walls 128 boxes;
Embree against those few triangles that it meets.
"""

import numpy as np

from bullet_sim.engine.library import p
from bullet_sim.engine.shapes import read_shapes
from bullet_sim.pose import matrix_from_quaternion

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

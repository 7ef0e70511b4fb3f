"""Collision shapes of a body that never moves, as what rays can be cast at."""

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

"""Closed solids of flat faces with one true normal each, written as Wavefront OBJ."""

import numpy as np


class Mesh:
    """Solids put together.

    Attributes:
        solids: List of solids; a solid is a list of (P, 3) polygons [m], each flat and convex,
            counter-clockwise seen from outside.
    """

    def __init__(self, *solids):
        self.solids = []
        for solid in solids:
            self.add(solid)

    def add(self, faces):
        """Add a closed solid; it is turned inside out if its faces point inwards."""
        faces = [np.asarray(face, dtype=float) for face in faces]
        if volume(faces) < 0.0:
            faces = [face[::-1] for face in faces]
        self.solids.append(faces)
        return self

    def add_both_sides(self, faces):
        """Add a solid and its mirror image across the plane y = 0."""
        faces = [np.asarray(face, dtype=float) for face in faces]
        return self.add(faces).add([face * (1.0, -1.0, 1.0) for face in faces])

    def bounds(self):
        """Lowest and highest corner, two (3,) arrays [m]."""
        corners = np.concatenate([face for solid in self.solids for face in solid])
        return corners.min(axis=0), corners.max(axis=0)

    def volume(self):
        """Sum of the solids' volumes [m^3]."""
        return sum(volume(solid) for solid in self.solids)

    def triangles(self):
        """Corners of all triangles (N, 3, 3) [m]; slivers without area are left out."""
        found = [
            triangle
            for solid in self.solids
            for face in solid
            for triangle in fan(face)
            if area_vector(triangle).any()
        ]
        return np.array(found)

    def to_obj(self, name):
        """OBJ text with a normal for each triangle; its colour is in NAME.mtl."""
        points, normals, faces = {}, {}, []
        for triangle in self.triangles():
            across = area_vector(triangle)
            length = np.linalg.norm(across)
            if length < 1e-10:
                continue
            normal = normals.setdefault(_words(across / length, 4), len(normals) + 1)
            corners = [points.setdefault(_words(corner, 5), len(points) + 1) for corner in triangle]
            if len(set(corners)) == 3:
                faces.append("f " + " ".join(f"{corner}//{normal}" for corner in corners))
        head = [
            "# made by cybertruck make_meshes",
            f"mtllib {name}.mtl",
            f"o {name}",
            f"usemtl {name}",
        ]
        return (
            "\n".join(
                head + [f"v {text}" for text in points] + [f"vn {text}" for text in normals] + faces
            )
            + "\n"
        )


def _words(vector, digits):
    # Adding 0.0 turns -0.0 into 0.0.
    return " ".join(f"{round(float(value), digits) + 0.0:g}" for value in vector)


def fan(face):
    """Triangles of a convex polygon."""
    return [(face[0], face[i], face[i + 1]) for i in range(1, len(face) - 1)]


def area_vector(triangle):
    """Normal of a triangle, twice its area long [m^2]."""
    a, b, c = triangle
    return np.cross(np.subtract(b, a), np.subtract(c, a))


def volume(faces):
    """Volume of a closed solid [m^3], negative if its faces point inwards (Gauss)."""
    return sum(
        float(np.dot(a, np.cross(b, c))) / 6.0
        for face in faces
        for a, b, c in fan(np.asarray(face))
    )


def tube(sections):
    """Solid through closed sections (S, P, 3) [m] of equally many corners, ends closed."""
    sections = np.asarray(sections, dtype=float)
    count = sections.shape[1]
    faces = [
        (a[i], a[(i + 1) % count], b[(i + 1) % count], b[i])
        for a, b in zip(sections[:-1], sections[1:])
        for i in range(count)
    ]
    return faces + [sections[0][::-1], sections[-1]]


def wall(outline, y0, y1):
    """Solid between y0 and y1 [m] with an outline (P, 2) in the x-z plane, convex."""
    return tube([[(x, y, z) for x, z in outline] for y in (y0, y1)])


def block(low, high):
    """Box between two corners [m]."""
    return wall(
        [(low[0], low[2]), (high[0], low[2]), (high[0], high[2]), (low[0], high[2])],
        low[1],
        high[1],
    )


def turned(profile, flats):
    """Solid of revolution about y.

    Args:
        profile: (P, 2) of (radius, y) [m], a closed outline.
        flats: number of flats around.
    """
    angles = 2.0 * np.pi * np.arange(flats + 1) / flats
    rings = np.array([[(r * np.cos(a), y, r * np.sin(a)) for r, y in profile] for a in angles])
    count = len(profile)
    return [
        (a[i], a[(i + 1) % count], b[(i + 1) % count], b[i])
        for a, b in zip(rings[:-1], rings[1:])
        for i in range(count)
    ]


def plate(corners, thickness):
    """Thin solid on a flat polygon (P, 3) [m], grown along its normal by a thickness [m]."""
    corners = np.asarray(corners, dtype=float)
    normal = area_vector(corners[:3])
    normal = normal / np.linalg.norm(normal)
    return tube([corners, corners + thickness * normal])

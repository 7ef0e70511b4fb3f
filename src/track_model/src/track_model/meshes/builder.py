"""Closed solids put together from quads: lofts, lathes, arches; written as Wavefront OBJ."""

import numpy as np


class Mesh:
    """Triangles and quads with one flat normal each.

    Attributes:
        faces: List of (3 or 4, 3) float arrays, corners [m], counter-clockwise from outside.
    """

    def __init__(self):
        self.faces = []

    def add(self, faces):
        """Add one closed solid; its faces are turned outwards together if they point inwards."""
        faces = [np.asarray(face, dtype=float) for face in faces]
        volume = sum(
            np.dot(face[0], np.cross(face[i], face[i + 1])) / 6.0
            for face in faces
            for i in range(1, len(face) - 1)
        )
        self.faces += [face[::-1] for face in faces] if volume < 0.0 else faces

    def add_mirrored(self, faces):
        """Add a solid and its mirror image across the plane y = 0."""
        faces = [np.asarray(face, dtype=float) for face in faces]
        self.add(faces)
        self.add([face * (1.0, -1.0, 1.0) for face in faces])

    def bounds(self):
        """Return (minimum (3,), maximum (3,)) [m]."""
        corners = np.concatenate(self.faces)
        return corners.min(axis=0), corners.max(axis=0)

    def to_obj(self, name):
        """Return the OBJ text: positions to 0.01 mm, normals to 0.001, shared by index."""
        positions, normals, lines = {}, {}, []
        for face in self.faces:
            normal = np.cross(face[1] - face[0], face[2] - face[0])
            if len(face) == 4:
                normal = np.cross(face[2] - face[0], face[3] - face[1])
            length = np.linalg.norm(normal)
            if length < 1e-12:
                continue
            n = normals.setdefault(_text(normal / length, 3), len(normals) + 1)
            corners = [
                positions.setdefault(_text(corner, 5), len(positions) + 1) for corner in face
            ]
            # PyBullet's loader wants triangles.
            for i in range(1, len(corners) - 1):
                triangle = (corners[0], corners[i], corners[i + 1])
                if len(set(triangle)) == 3:
                    lines.append("f " + " ".join(f"{corner}//{n}" for corner in triangle))
        return (
            "\n".join(
                [
                    "# made by track_model make_meshes",
                    "mtllib " + name + ".mtl",
                    "o " + name,
                    "usemtl " + name,
                ]
                + ["v " + text for text in positions]
                + ["vn " + text for text in normals]
                + lines
            )
            + "\n"
        )


def _text(vector, digits):
    # Adding 0.0 turns -0.0 into 0.0.
    return " ".join("%g" % (round(float(value), digits) + 0.0) for value in vector)


def loft(sections):
    """Return the faces of a solid through closed sections, with flat caps.

    Args:
        sections: (S, P, 3) corners [m], all sections with the same number of points.
    """
    sections = np.asarray(sections, dtype=float)
    count = sections.shape[1]
    faces = [
        (a[i], a[(i + 1) % count], b[(i + 1) % count], b[i])
        for a, b in zip(sections[:-1], sections[1:])
        for i in range(count)
    ]
    for cap, order in ((sections[0], -1), (sections[-1], 1)):
        centre = cap.mean(axis=0)
        ring = cap[::order]
        faces += [(centre, ring[i], ring[(i + 1) % count]) for i in range(count)]
    return faces


def box(low, high):
    """Return the faces of an axis-aligned box between two corners [m]."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    ring = ((y0, z0), (y1, z0), (y1, z1), (y0, z1))
    return loft([[(x, y, z) for y, z in ring] for x in (x0, x1)])


def prism(outline, y0, y1):
    """Return the faces of an outline in the x-z plane (P, 2), stretched from y0 to y1 [m]."""
    return loft([[(x, y, z) for x, z in outline] for y in (y0, y1)])


def ring(sections):
    """Return the faces of a tube through closed sections whose last joins the first."""
    sections = np.asarray(sections, dtype=float)
    count = sections.shape[1]
    return [
        (a[i], a[(i + 1) % count], b[(i + 1) % count], b[i])
        for a, b in zip(sections, np.roll(sections, -1, axis=0))
        for i in range(count)
    ]


def lathe(profile, steps):
    """Return the faces of a closed profile turned about the y axis.

    Args:
        profile: (P, 2) closed outline of (radius, y) [m].
        steps: Number of flats around the axis.
    """
    angles = 2.0 * np.pi * np.arange(steps) / steps
    return ring([[(r * np.cos(a), y, r * np.sin(a)) for r, y in profile] for a in angles])


def arch(centre, inner, outer, start, stop, y_inner, y_outer, steps):
    """Return the faces of a wheel arch: part of a flat ring about an axis along y.

    Args:
        centre: (x, z) of the wheel's axis [m].
        inner, outer: Radii [m].
        start, stop: Angles from the x axis towards z [rad].
        y_inner, y_outer: Sideways extent [m].
        steps: Number of flats.
    """
    sections = []
    for a in np.linspace(start, stop, steps + 1):
        direction = np.array((np.cos(a), np.sin(a)))
        sections.append(
            [
                (*(np.array(centre) + radius * direction), y)
                for radius, y in (
                    (inner, y_inner),
                    (inner, y_outer),
                    (outer - 0.002, y_outer),
                    (outer, y_outer - 0.004),
                    (outer, y_inner),
                )
            ]
        )
    return loft(np.array(sections)[:, :, (0, 2, 1)])

"""Solids as triangles, and OBJ files of them."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, List

import numpy as np
import numpy.typing as npt

Solid = List[npt.NDArray[Any]]


class Mesh:
    """A collection of solids.

    Attributes:
        solids: List of solids; a solid is a list of (P, 3) polygons [m], each convex,
            counter-clockwise as viewed from outside.
    """

    def __init__(self, *solids: Iterable[npt.ArrayLike]) -> None:
        self.solids: list[Solid] = []
        for solid in solids:
            self.add(solid)

    def add(self, faces: Iterable[npt.ArrayLike]) -> Mesh:
        """Add a closed solid; its faces are reversed if they point inwards."""
        solid = [np.asarray(face, dtype=float) for face in faces]
        if volume(solid) < 0.0:
            solid = [face[::-1] for face in solid]
        self.solids.append(solid)
        return self

    def add_mirrored(self, faces: Iterable[npt.ArrayLike]) -> Mesh:
        """Add a solid and its mirror image across the plane y = 0."""
        solid = [np.asarray(face, dtype=float) for face in faces]
        return self.add(solid).add([face * (1.0, -1.0, 1.0) for face in solid])

    @property
    def faces(self) -> Solid:
        """The polygons of all solids, in order."""
        return [face for solid in self.solids for face in solid]

    def bounds(self) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Minimum and maximum corner, two (3,) arrays [m]."""
        corners = np.concatenate(self.faces)
        return corners.min(axis=0), corners.max(axis=0)

    def triangles(self) -> npt.NDArray[Any]:
        """Corners of all triangles (N, 3, 3) [m]; slivers without area are skipped."""
        triangles = [triangle for face in self.faces for triangle in fan(face)]
        return np.array([triangle for triangle in triangles if area_vector(triangle).any()])

    def volume(self) -> float:
        """Sum of the solids' volumes [m^3]."""
        return sum(volume(solid) for solid in self.solids)


def fan(face: Any) -> list[tuple[Any, Any, Any]]:
    """Triangles of a convex polygon."""
    return [(face[0], face[i], face[i + 1]) for i in range(1, len(face) - 1)]


def area_vector(face: Any) -> npt.NDArray[Any]:
    """Normal of a polygon (P, 3), twice its area long [m^2]; of a bent one the mean (Newell)."""
    a = np.asarray(face[0])
    return sum(np.cross(np.subtract(b, a), np.subtract(c, a)) for _, b, c in fan(face))


def volume(faces: Iterable[npt.ArrayLike]) -> float:
    """Volume of a closed solid [m^3], negative if its faces point inwards (Gauss)."""
    return sum(
        float(np.dot(a, np.cross(b, c))) / 6.0
        for face in faces
        for a, b, c in fan(np.asarray(face))
    )


def loft(sections: npt.ArrayLike, fans: bool = False) -> list[Any]:
    """Solid through closed sections, with closed ends.

    Args:
        sections: (S, P, 3) corners [m], all sections with the same number of points.
        fans: Close the ends with triangles about their center, for ends that are not convex.
    """
    sections = np.asarray(sections, dtype=float)
    faces = [face for pair in zip(sections[:-1], sections[1:]) for face in between(*pair)]
    for end in (sections[0][::-1], sections[-1]):
        faces += fan_about_center(end) if fans else [end]
    return faces


def between(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> list[Any]:
    """Quads between two closed sections (P, 3)."""
    count = len(a)
    return [(a[i], a[(i + 1) % count], b[(i + 1) % count], b[i]) for i in range(count)]


def fan_about_center(ring: npt.NDArray[Any]) -> list[Any]:
    """Triangles of a polygon (P, 3) about its corners' mean."""
    center = ring.mean(axis=0)
    return [(center, ring[i], ring[(i + 1) % len(ring)]) for i in range(len(ring))]


def box(low: Sequence[float], high: Sequence[float]) -> list[Any]:
    """Box between two corners [m]."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return prism([(x0, z0), (x1, z0), (x1, z1), (x0, z1)], y0, y1)


def prism(outline: Any, y0: float, y1: float, fans: bool = False) -> list[Any]:
    """Solid between y0 and y1 [m] with an outline (P, 2) in the x-z plane."""
    return loft([[(x, y, z) for x, z in outline] for y in (y0, y1)], fans)


def lathe(profile: Any, flats: int) -> list[Any]:
    """Solid of revolution about the y axis.

    Args:
        profile: (P, 2) of (radius, y) [m], a closed outline.
        flats: Number of flats around.
    """
    angles = 2.0 * np.pi * np.arange(flats) / flats
    rings = np.array([[(r * np.cos(a), y, r * np.sin(a)) for r, y in profile] for a in angles])
    pairs = zip(rings, np.roll(rings, -1, axis=0))
    return [face for pair in pairs for face in between(*pair)]


def arch(
    center: tuple[float, float],
    inner: float,
    outer: float,
    start: float,
    stop: float,
    y_inner: float,
    y_outer: float,
    flats: int,
) -> list[Any]:
    """Wheel arch: part of a flat ring about an axis along y.

    Args:
        center: (x, z) of the wheel's axis [m].
        inner, outer: Radii [m].
        start, stop: Angles from the x axis towards z [rad].
        y_inner, y_outer: Sideways extent [m].
        flats: Number of flats.
    """
    profile = (
        (inner, y_inner),
        (inner, y_outer),
        (outer - 0.002, y_outer),
        (outer, y_outer - 0.004),
        (outer, y_inner),
    )
    (x, z), angles = center, np.linspace(start, stop, flats + 1)
    return loft(
        [[(x + r * np.cos(a), y, z + r * np.sin(a)) for r, y in profile] for a in angles], fans=True
    )


def plate(corners: npt.ArrayLike, thickness: float) -> list[Any]:
    """Thin solid on a flat polygon (P, 3) [m], grown along its normal by a thickness [m]."""
    corners = np.asarray(corners, dtype=float)
    normal = area_vector(corners[:3])
    normal = normal / np.linalg.norm(normal)
    return loft([corners, corners + thickness * normal])


MIN_AREA = 1e-10  # faces below twice this have no normal and are skipped [m^2]


@dataclass(frozen=True)
class MeshSet:
    """The meshes of one description.

    Attributes:
        package: Package whose make_meshes generates them, for the files' first line.
        makers: Name -> function without arguments that returns the Mesh.
        colors: Name -> RGB 0..1. rviz takes the color of an OBJ from its MTL.
        specular: Brightness of highlights, 0..1.
        digits: Decimals of the normals; positions have 0.01 mm.
        folded: A bent face is written with one normal per triangle; else it has one normal.
    """

    package: str
    makers: dict[str, Callable[[], Mesh]]
    colors: dict[str, tuple[float, float, float]]
    specular: float = 0.2
    digits: int = 4
    folded: bool = False

    def obj(self, name: str) -> str:
        """Text of NAME.obj: triangles, one normal for each flat face."""
        mesh = self.makers[name]()
        faces: Any = mesh.triangles() if self.folded else mesh.faces
        head = [f"# made by {self.package} make_meshes", f"mtllib {name}.mtl"]
        head += [f"o {name}", f"usemtl {name}"]
        return "\n".join(head + obj_lines(faces, self.digits)) + "\n"

    def mtl(self, name: str) -> str:
        """Text of NAME.mtl: one uniform color."""
        color = " ".join(f"{channel:.2f}" for channel in self.colors[name])
        shine = " ".join([f"{self.specular:.1f}"] * 3)
        return f"newmtl {name}\nKa {color}\nKd {color}\nKs {shine}\nd 1\nillum 2\n"

    def write(self, directory: str) -> list[str]:
        """Write every mesh as NAME.obj and NAME.mtl into a directory; return the paths."""
        os.makedirs(directory, exist_ok=True)
        paths = []
        for name in self.makers:
            for ending, text in ((".obj", self.obj(name)), (".mtl", self.mtl(name))):
                paths.append(os.path.join(directory, name + ending))
                with open(paths[-1], "w", encoding="ascii", newline="\n") as stream:
                    stream.write(text)
        return paths

    def main(self, default: str, argv: Sequence[str] | None = None) -> int:
        """Command line: target folder, by default that of the source tree; prints the paths.

        Args:
            default: Folder to write to when none is given.
            argv: Arguments; None: those of the process.
        """
        parser = argparse.ArgumentParser(
            prog="make_meshes", description=f"Writes the meshes of {self.package}."
        )
        default = os.path.normpath(default)
        optional: Any = "?" if os.path.isdir(default) else None  # an install space has no sources
        parser.add_argument("directory", nargs=optional, default=default)
        for path in self.write(parser.parse_args(argv).directory):
            print(path)
        return 0


def obj_lines(faces: Iterable[Any], digits: int) -> list[str]:
    """Lines of an OBJ: positions, normals, triangles, each position and normal written once.

    Args:
        faces: (P, 3) polygons [m].
        digits: Decimals of the normals.
    """
    points: dict[str, int] = {}
    normals: dict[str, int] = {}
    triangles = []
    for face in faces:
        across = area_vector(face)
        length = np.linalg.norm(across)
        if length < MIN_AREA:
            continue
        normal = normals.setdefault(_text(across / length, digits), len(normals) + 1)
        corners = [points.setdefault(_text(corner, 5), len(points) + 1) for corner in face]
        for triangle in fan(corners):  # PyBullet's loader requires triangles
            if len(set(triangle)) == 3:
                triangles.append("f " + " ".join(f"{corner}//{normal}" for corner in triangle))
    return [f"v {text}" for text in points] + [f"vn {text}" for text in normals] + triangles


def _text(vector: Iterable[float], digits: int) -> str:
    # Adding 0.0 converts -0.0 to 0.0.
    return " ".join(f"{round(float(value), digits) + 0.0:g}" for value in vector)

"""Meshes of the car: shell, wheels, hinges, sensors."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from functools import partial
from typing import Any, List, Tuple

import numpy as np
import numpy.typing as npt
from paddock_common.meshes import Mesh, MeshSet, arch, box, lathe

from paddock_common import meshes

FRONT_AXLE = (0.082311, 0.011759)  # (x, z) in chassis [m]
REAR_AXLE = (-0.081663, 0.01575)
# Stations of the shell from tail to nose [m]:
# x, half widths (sill, shoulder, deck), heights (sill, shoulder, deck).
SHELL = np.array(
    (
        (-0.134, 0.036, 0.042, 0.034, 0.024, 0.040, 0.056),
        (-0.126, 0.042, 0.050, 0.040, 0.014, 0.042, 0.064),
        (-0.100, 0.046, 0.056, 0.046, 0.006, 0.046, 0.071),
        (-0.060, 0.050, 0.060, 0.048, 0.003, 0.046, 0.071),
        (-0.010, 0.050, 0.058, 0.046, 0.003, 0.044, 0.067),
        (0.040, 0.047, 0.054, 0.042, 0.003, 0.042, 0.063),
        (0.080, 0.044, 0.051, 0.040, 0.003, 0.040, 0.057),
        (0.115, 0.043, 0.049, 0.037, 0.004, 0.034, 0.048),
        (0.145, 0.044, 0.047, 0.033, 0.006, 0.024, 0.035),
        (0.158, 0.038, 0.041, 0.028, 0.010, 0.018, 0.026),
    )
)
# Stations of the cabin: x, half widths (foot, roof), heights (foot, roof).
CABIN = np.array(
    (
        (-0.088, 0.030, 0.026, 0.066, 0.071),
        (-0.050, 0.041, 0.029, 0.062, 0.100),
        (-0.015, 0.043, 0.030, 0.060, 0.104),
        (0.015, 0.042, 0.029, 0.058, 0.099),
        (0.062, 0.034, 0.026, 0.056, 0.061),
    )
)
# Outline of the wing (x, z).
WING = (
    (-0.140, 0.089),
    (-0.138, 0.0925),
    (-0.120, 0.0900),
    (-0.108, 0.0865),
    (-0.108, 0.0850),
    (-0.120, 0.0865),
)

loft, prism = partial(meshes.loft, fans=True), partial(meshes.prism, fans=True)
Section = List[Tuple[float, float, float]]


def _stations(table: npt.NDArray[Any], fine: int) -> npt.NDArray[Any]:
    """Interpolate a table of stations at finer x with Hermite segments of limited slope."""
    x = table[:, 0]
    at = np.concatenate(
        [np.linspace(a, b, fine, endpoint=False) for a, b in zip(x[:-1], x[1:])] + [x[-1:]]
    )
    step = np.diff(table, axis=0) / np.diff(x)[:, None]
    slope = np.vstack([step[:1], (step[:-1] + step[1:]) / 2.0, step[-1:]])
    index = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    width = (x[index + 1] - x[index])[:, None]
    t = ((at - x[index])[:, None]) / width
    return (
        (1 + 2 * t) * (1 - t) ** 2 * table[index]
        + t**2 * (3 - 2 * t) * table[index + 1]
        + width * (t * (1 - t) ** 2 * slope[index] - t**2 * (1 - t) * slope[index + 1])
    )


def _shell_section(row: npt.NDArray[Any]) -> Section:
    x, sill, shoulder, deck, z_sill, z_shoulder, z_deck = row
    half = [
        (sill, z_sill),
        (0.4 * sill + 0.6 * shoulder, 0.6 * z_sill + 0.4 * z_shoulder),
        (shoulder, z_shoulder),
        (0.75 * shoulder + 0.25 * deck, 0.4 * z_shoulder + 0.6 * z_deck),
        (deck, z_deck),
        (0.55 * deck, z_deck + 0.0025),
    ]
    return [(x, y, z) for y, z in half] + [(x, -y, z) for y, z in half[::-1]]


def _cabin_section(row: npt.NDArray[Any], grow: float = 0.0) -> Section:
    x, foot, roof, z_foot, z_roof = row
    half = [
        (foot + grow, z_foot),
        (roof + grow, max(z_roof - 0.004, z_foot + 0.001) + grow),
        (0.8 * roof + grow, z_roof + grow),
    ]
    return [(x, y, z) for y, z in half] + [(x, -y, z) for y, z in half[::-1]]


def _cabin_at(x: float) -> npt.NDArray[Any]:
    return np.array([x] + [np.interp(x, CABIN[:, 0], column) for column in CABIN.T[1:]])


def body() -> Mesh:
    """Painted shell, fenders over the four wheels, roof, pillars, wing."""
    mesh = Mesh(loft([_shell_section(row) for row in _stations(SHELL, 4)]))
    for axle, start, stop in ((FRONT_AXLE, 0.12, 2.9), (REAR_AXLE, 0.3, 2.95)):
        mesh.add_mirrored(arch(axle, 0.0365, 0.0415, start, stop, 0.040, 0.0975, 18))
    # Roof slab and pillars protrude 1 mm from the glass.
    mesh.add(loft([_roof_section(_cabin_at(x)) for x in np.linspace(-0.052, 0.012, 7)]))
    for a, b in ((-0.022, -0.014), (-0.056, -0.049)):
        mesh.add(loft([_cabin_section(_cabin_at(x), 0.0012) for x in (a, b)]))
    # Windscreen posts follow the cabin's edge from hood to roof.
    for a, b in ((0.060, 0.010), (-0.086, -0.048)):
        mesh.add_mirrored(loft([_post_section(_cabin_at(x)) for x in np.linspace(a, b, 6)]))
    mesh.add(prism(WING, -0.078, 0.078))
    return mesh


def _roof_section(row: npt.NDArray[Any]) -> Section:
    x, _, roof, _, top = row
    left = [(0.85 * roof, top - 0.001), (0.85 * roof, top + 0.002)]
    right = [(-y, z) for y, z in left[::-1]]
    return [(x, y, z) for y, z in [*left, (0.0, top + 0.004), *right]]


def _post_section(row: npt.NDArray[Any]) -> Section:
    x, _, roof, _, top = row
    edges = ((-0.007, 0.002), (0.0018, -0.002), (0.0018, -0.006), (-0.007, -0.003))
    return [(x, roof + dy, top + dz) for dy, dz in edges]


def stripe() -> Mesh:
    """Two racing stripes over hood and tail, 0.4 mm above the shell."""
    mesh = Mesh()
    rows = _stations(SHELL, 4)
    for a, b in ((0.055, 0.156), (-0.131, -0.080)):
        part = [row for row in rows if a <= row[0] <= b]
        for low, high in ((0.005, 0.013), (-0.013, -0.005)):
            edges = ((low, 0.0005), (high, 0.0005), (high, 0.0032), (low, 0.0032))
            mesh.add(loft([[(row[0], y, row[6] + z) for y, z in edges] for row in part]))
    return mesh


def glass() -> Mesh:
    """Cabin windows in one piece."""
    x = np.concatenate([np.linspace(-0.088, 0.062, 13), CABIN[:, 0]]).round(4)
    return Mesh(loft([_cabin_section(_cabin_at(x)) for x in np.unique(x)]))


def trim() -> Mesh:
    """Black parts: bumpers, skirts, diffuser, wing posts and plates, mirrors, masts."""
    mesh = Mesh()
    _add_bumper(mesh)
    _add_skirts(mesh)
    _add_tail(mesh)
    _add_hood(mesh)
    _add_sensors(mesh)
    # Mirrors.
    mesh.add_mirrored(
        loft(
            [
                [(x, 0.046, z), (x, 0.060, z + 0.002), (x, 0.060, z + 0.010), (x, 0.052, z + 0.010)]
                for x, z in ((0.026, 0.068), (0.034, 0.069))
            ]
        )
    )
    # Axles between shell and wheels.
    for x, z in (FRONT_AXLE, REAR_AXLE):
        mesh.add(box((x - 0.004, -0.074, z - 0.003), (x + 0.004, 0.074, z + 0.003)))
    return mesh


def _add_bumper(mesh: Mesh) -> None:
    bumper = (
        (0.122, 0.050, -0.001, 0.012),
        (0.140, 0.082, -0.001, 0.012),
        (0.158, 0.078, -0.001, 0.010),
        (0.170, 0.060, 0.000, 0.006),
    )
    mesh.add(loft([[(x, w, z0), (x, w, z1), (x, -w, z1), (x, -w, z0)] for x, w, z0, z1 in bumper]))
    mesh.add_mirrored(box((0.128, 0.078, -0.001), (0.160, 0.081, 0.026)))


def _add_skirts(mesh: Mesh) -> None:
    skirt = (
        (-0.043, 0.080, 0.014),
        (-0.036, 0.089, 0.020),
        (0.032, 0.089, 0.018),
        (0.040, 0.080, 0.012),
    )
    mesh.add_mirrored(
        loft(
            [
                [(x, 0.040, 0.000), (x, w, 0.000), (x, w, z), (x, 0.040, z + 0.006)]
                for x, w, z in skirt
            ]
        )
    )


def _add_tail(mesh: Mesh) -> None:
    """Diffuser with its fins, posts and plates of the wing."""
    mesh.add(
        prism([(-0.118, 0.002), (-0.146, 0.010), (-0.146, 0.020), (-0.118, 0.022)], -0.072, 0.072)
    )
    for y in (-0.045, -0.015, 0.015, 0.045):
        mesh.add(
            prism(
                [(-0.120, 0.000), (-0.147, 0.006), (-0.147, 0.018), (-0.120, 0.018)],
                y - 0.001,
                y + 0.001,
            )
        )
    mesh.add_mirrored(
        prism([(-0.118, 0.066), (-0.126, 0.066), (-0.130, 0.089), (-0.118, 0.089)], 0.028, 0.031)
    )
    mesh.add_mirrored(
        prism([(-0.144, 0.074), (-0.144, 0.098), (-0.106, 0.092), (-0.106, 0.078)], 0.078, 0.081)
    )


def _add_hood(mesh: Mesh) -> None:
    """Grille and hood scoop."""
    mesh.add(
        prism([(0.150, 0.012), (0.1605, 0.012), (0.1585, 0.0185), (0.150, 0.0185)], -0.024, 0.024)
    )
    mesh.add(
        loft(
            [
                [(x, w, z), (x, w * 0.8, z + h), (x, -w * 0.8, z + h), (x, -w, z)]
                for x, w, z, h in (
                    (0.070, 0.020, 0.056, 0.007),
                    (0.084, 0.019, 0.053, 0.010),
                    (0.098, 0.016, 0.048, 0.007),
                )
            ]
        )
    )


def _add_sensors(mesh: Mesh) -> None:
    """Mast of the camera (lens at x 0.145, z 0.107) and foot of the lidar."""
    mesh.add(
        loft(
            [
                [
                    (x - 0.005, -0.006, z),
                    (x + 0.005, -0.006, z),
                    (x + 0.005, 0.006, z),
                    (x - 0.005, 0.006, z),
                ]
                for x, z in ((0.104, 0.046), (0.124, 0.104))
            ]
        )
    )
    mesh.add(box((-0.035, -0.015, 0.100), (-0.005, 0.015, 0.121)))


def headlights() -> Mesh:
    """A lamp on either side of the hood's front."""
    mesh = Mesh()
    mesh.add_mirrored(
        loft(
            [
                [(x, y0, z), (x, y1, z - 0.004), (x, y1, z + 0.003), (x, y0, z + 0.006)]
                for x, y0, y1, z in (
                    (0.120, 0.030, 0.0480, 0.037),
                    (0.140, 0.028, 0.0480, 0.030),
                    (0.1525, 0.026, 0.0430, 0.0225),
                )
            ]
        )
    )
    return mesh


def taillights() -> Mesh:
    """A wide lamp on either side of the tail."""
    mesh = Mesh()
    mesh.add_mirrored(box((-0.1355, 0.012, 0.046), (-0.125, 0.036, 0.053)))
    return mesh


def tyre() -> Mesh:
    """Tyre of radius 0.03 m and width 0.025 m with round shoulders and tread grooves."""
    half = [
        (0.0195, 0.0105),
        (0.0225, 0.0125),
        (0.0265, 0.0122),
        (0.0288, 0.0105),
        (0.03, 0.0080),
        (0.03, 0.0048),
        (0.0288, 0.0044),
        (0.0288, 0.0034),
        (0.03, 0.0030),
    ]
    return Mesh(lathe(half + [(r, -y) for r, y in half[::-1]], 36))


def rim() -> Mesh:
    """Rim with five spokes and a hub on both faces; radius 0.021 m."""
    mesh = Mesh()
    mesh.add(lathe([(0.0180, 0.0116), (0.0212, 0.0124), (0.0212, -0.0124), (0.0180, -0.0116)], 30))
    mesh.add(
        lathe(
            [
                (0.0001, 0.0125),
                (0.0035, 0.0125),
                (0.0050, 0.0105),
                (0.0050, -0.0105),
                (0.0035, -0.0125),
                (0.0001, -0.0125),
            ],
            15,
        )
    )
    for spoke in range(5):
        a = 2.0 * np.pi * spoke / 5.0
        along, across = np.array((np.cos(a), np.sin(a))), np.array((-np.sin(a), np.cos(a)))
        outline = [
            along * r + across * w
            for r, w in ((0.004, -0.0032), (0.0188, -0.0022), (0.0188, 0.0022), (0.004, 0.0032))
        ]
        mesh.add_mirrored(prism(outline, 0.0070, 0.0108))
    return mesh


MAKERS = {
    "body": body,
    "stripe": stripe,
    "trim": trim,
    "glass": glass,
    "headlights": headlights,
    "taillights": taillights,
    "tyre": tyre,
    "rim": rim,
}
# RGB 0..1, as in urdf/materials.xacro.
COLORS = {
    "body": (0.05, 0.25, 0.75),
    "stripe": (0.95, 0.95, 0.95),
    "trim": (0.09, 0.09, 0.10),
    "glass": (0.16, 0.21, 0.26),
    "headlights": (1.0, 0.96, 0.75),
    "taillights": (0.85, 0.05, 0.05),
    "tyre": (0.05, 0.05, 0.05),
    "rim": (0.75, 0.77, 0.80),
}
MESHES = MeshSet("track_model", MAKERS, COLORS, specular=0.1, digits=3)


def main(argv: Sequence[str] | None = None) -> int:
    """Command line: optional target folder; prints the paths written."""
    return MESHES.main(os.path.join(os.path.dirname(__file__), "..", "..", "meshes"), argv)


if __name__ == "__main__":
    sys.exit(main())

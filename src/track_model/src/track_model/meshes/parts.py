"""The car's black parts, lamps and wheels, in the chassis frame (wheels: in the wheel's frame)."""

from functools import partial

import numpy as np
from paddock_common.meshes import solids
from paddock_common.meshes.solids import Mesh, box, lathe

from track_model.meshes.shell import FRONT_AXLE, REAR_AXLE

loft, prism = (partial(make, fans=True) for make in (solids.loft, solids.prism))


def trim():
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


def _add_bumper(mesh):
    bumper = [
        (x, w, z0, z1)
        for x, w, z0, z1 in (
            (0.122, 0.050, -0.001, 0.012),
            (0.140, 0.082, -0.001, 0.012),
            (0.158, 0.078, -0.001, 0.010),
            (0.170, 0.060, 0.000, 0.006),
        )
    ]
    mesh.add(loft([[(x, w, z0), (x, w, z1), (x, -w, z1), (x, -w, z0)] for x, w, z0, z1 in bumper]))
    mesh.add_mirrored(box((0.128, 0.078, -0.001), (0.160, 0.081, 0.026)))


def _add_skirts(mesh):
    skirt = [
        (x, w, z)
        for x, w, z in (
            (-0.043, 0.080, 0.014),
            (-0.036, 0.089, 0.020),
            (0.032, 0.089, 0.018),
            (0.040, 0.080, 0.012),
        )
    ]
    mesh.add_mirrored(
        loft(
            [
                [(x, 0.040, 0.000), (x, w, 0.000), (x, w, z), (x, 0.040, z + 0.006)]
                for x, w, z in skirt
            ]
        )
    )


def _add_tail(mesh):
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


def _add_hood(mesh):
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


def _add_sensors(mesh):
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


def headlights():
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


def taillights():
    """A wide lamp on either side of the tail."""
    mesh = Mesh()
    mesh.add_mirrored(box((-0.1355, 0.012, 0.046), (-0.125, 0.036, 0.053)))
    return mesh


def tyre():
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
    mesh = Mesh()
    mesh.add(lathe(half + [(r, -y) for r, y in half[::-1]], 36))
    return mesh


def rim():
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

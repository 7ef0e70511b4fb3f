"""The trailer's meshes: ground at z = 0, middle of its axle at x = 0, hitch ahead, in metres."""

import numpy as np
from paddock_common.meshes.solids import Mesh, box, loft, prism

FRONT, REAR = 0.40, -0.34  # x of the box; the hitch is at +0.70
FLOOR, SHOULDER, ROOF = 0.225, 0.520, 0.605
HALF = 0.25


def trailer_box():
    """Box with a folded roof and a raked front, and skirts before and behind the wheels."""
    sections = []
    for x, half, low, shoulder, ridge, top in (
        (REAR, HALF, FLOOR, SHOULDER, 0.200, ROOF),
        (0.30, HALF, FLOOR, SHOULDER, 0.200, ROOF),
        (FRONT, 0.225, FLOOR + 0.02, SHOULDER - 0.05, 0.190, ROOF - 0.055),
    ):
        sections.append(
            [
                (x, half - 0.012, low),
                (x, half, shoulder - 0.11),
                (x, half, shoulder),
                (x, ridge, top),
                (x, -ridge, top),
                (x, -half, shoulder),
                (x, -half, shoulder - 0.11),
                (x, 0.012 - half, low),
            ]
        )
    mesh = Mesh(loft(sections))
    for outline in (
        ((0.130, 0.130), (0.340, 0.150), (0.370, 0.235), (0.088, 0.235)),
        ((-0.300, 0.150), (-0.130, 0.130), (-0.088, 0.235), (REAR, 0.235)),
    ):
        mesh.add_mirrored(prism(outline, 0.110, HALF - 0.014))
    return mesh


def trailer_trim():
    """Black parts: frame, arch edges, bumper, door gap, drawbar's brace, crease strips."""
    mesh = Mesh(box((REAR + 0.01, -0.110, 0.125), (0.36, 0.110, 0.232)))
    # A-frame from the box's corners to the tongue
    for side in (1.0, -1.0):
        mesh.add(
            loft(
                [
                    [
                        (x, side * y + w, z)
                        for w, z in (
                            (-0.018, 0.125),
                            (0.018, 0.125),
                            (0.018, 0.155),
                            (-0.018, 0.155),
                        )
                    ]
                    for x, y in ((0.36, 0.090), (0.58, 0.015))
                ]
            )
        )
    inner = ((-0.112, 0.150), (-0.074, 0.213), (0.074, 0.213), (0.112, 0.150))
    outer = ((-0.138, 0.142), (-0.090, 0.232), (0.090, 0.232), (0.138, 0.142))
    for i in range(3):
        mesh.add_mirrored(prism([inner[i], inner[i + 1], outer[i + 1], outer[i]], 0.215, 0.254))
    mesh.add(box((REAR - 0.010, -0.225, 0.225), (REAR + 0.02, 0.225, 0.255)))
    mesh.add(box((REAR - 0.002, -0.004, 0.260), (REAR + 0.01, 0.004, ROOF - 0.02)))
    for x in (-0.17, 0.06):
        mesh.add_mirrored(box((x - 0.003, HALF - 0.020, 0.30), (x + 0.003, HALF + 0.0015, 0.50)))
    return mesh


def trailer_lights():
    """Two upright lamps at the tail."""
    mesh = Mesh()
    corners = np.array(((REAR - 0.006, 0.205, 0.275), (REAR + 0.01, 0.235, 0.500)))
    mesh.add_mirrored(box(*corners))
    return mesh

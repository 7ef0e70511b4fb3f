"""Meshes of truck and trailer, generated.

The truck's meshes in base_footprint: ground at z = 0, rear axle's center at x = 0, in meters. A few
planes only: one line from the nose to the roof's ridge, one from there to the tail, sides that lean
in above a shoulder crease, trapezoid arches.
"""

import os
import sys

import numpy as np
from paddock_common.meshes import Mesh, MeshSet, box, lathe, loft, plate, prism

AXLES = (0.0, 0.508)  # x of the rear and front axle
NOSE, RIDGE, TAIL = 0.7302, 0.30, -0.235
RADIUS, WIDTH = 0.1016, 0.0762  # of a wheel
FLOOR, ARCH = 0.085, 0.222  # z of the underside, of the arches' tops
HALF = 0.254  # half width at the shoulder crease
LEAN = 0.73  # of the upper sides: inwards by this for each meter up


def _at(x, table):
    """Value at x of a broken line through (x, value) pairs."""
    return float(np.interp(x, *zip(*sorted(table))))


def top(x):
    """Height of the roof line [m]."""
    return _at(x, ((NOSE, 0.232), (RIDGE, 0.365), (TAIL, 0.272)))


def shoulder(x):
    """Height of the crease along the side [m]."""
    return _at(x, ((NOSE, 0.226), (TAIL, 0.262)))


def side_half(x):
    """Half width at the crease [m]; the nose is narrower."""
    return _at(x, ((NOSE, 0.230), (0.66, HALF), (TAIL + 0.03, HALF), (TAIL, 0.246)))


def roof_half(x):
    """Half width of the roof [m]: where the leaning side, a plane, meets the roof line."""
    return side_half(x) - LEAN * (top(x) - shoulder(x))


def _mirrored(left):
    """A section of the left half's points, and of those of the right half."""
    return left + [(x, -y, z) for x, y, z in left[::-1]]


def shell():
    """Upper body from the arches' tops to the roof: one convex, folded solid."""
    sections = []
    for x in (TAIL, TAIL + 0.03, RIDGE, 0.66, NOSE):
        half = side_half(x)
        lower = half - 0.006
        left = [(x, lower, ARCH - 0.006), (x, half, shoulder(x)), (x, roof_half(x), top(x))]
        sections.append(_mirrored(left))
    return Mesh(loft(sections))


def _skirt(outline):
    """Lower side panel: outline (4, 2) in x-z, leaning in towards the ground; both sides."""

    def half(z, x):
        return side_half(x) - 0.006 - 0.10 * (ARCH - z)

    return loft(
        [
            [(x, inner if inner is not None else half(z, x), z) for x, z in outline]
            for inner in (0.100, None)
        ]
    )


def sides():
    """Lower side panels before, between and behind the arches."""
    mesh = Mesh()
    for outline in (
        ((0.140, FLOOR), (0.368, FLOOR), (0.413, ARCH), (0.095, ARCH)),
        ((0.648, FLOOR + 0.02), (0.705, FLOOR + 0.035), (NOSE, ARCH), (0.603, ARCH)),
        ((-0.205, FLOOR + 0.035), (-0.140, FLOOR + 0.01), (-0.095, ARCH), (TAIL, ARCH)),
    ):
        mesh.add_mirrored(_skirt(outline))
    return mesh


def trim():
    """Black parts: tub between the wheels, arch edges, bumpers, tow bar, cut-out of the lidar."""
    mesh = Mesh(box((-0.200, -0.100, FLOOR), (0.700, 0.100, ARCH)))
    # bumpers between the side panels
    mesh.add(prism([(0.665, 0.105), (0.712, 0.120), (0.724, 0.190), (0.665, 0.190)], -0.205, 0.205))
    mesh.add(
        prism([(-0.215, 0.125), (-0.165, 0.100), (-0.165, 0.215), (-0.229, 0.215)], -0.215, 0.215)
    )
    # edges of the arches: three flat strips each
    for axle in AXLES:
        inner = ((-0.118, 0.150), (-0.078, 0.212), (0.078, 0.212), (0.118, 0.150))
        outer = ((-0.146, 0.142), (-0.094, 0.228), (0.094, 0.228), (0.146, 0.142))
        for i in range(3):
            outline = [(axle + x, z) for x, z in (inner[i], inner[i + 1], outer[i + 1], outer[i])]
            mesh.add_mirrored(prism(outline, 0.215, 0.2575))
    # tow bar to the hitch at x = -0.30, z = 0.14
    mesh.add(box((-0.310, -0.020, 0.125), (-0.190, 0.020, 0.150)))
    # lidar's foot in the roof's ridge
    mesh.add(
        loft(
            [
                [
                    (x, y, z)
                    for x, y in ((RIDGE - a, -b), (RIDGE + a, -b), (RIDGE + a, b), (RIDGE - a, b))
                ]
                for z, a, b in ((0.335, 0.085, 0.080), (0.3685, 0.050, 0.055))
            ]
        )
    )
    return mesh


def _on_roof(x, part):
    """Point on the roof plane: part is the fraction of its half width."""
    return (x, part * roof_half(x), top(x))


def _on_side(x, up):
    """Point on the leaning upper side: up is 0 at the crease, 1 at the roof."""
    low = np.array((x, side_half(x), shoulder(x)))
    return tuple(low + up * (np.array((x, roof_half(x), top(x))) - low))


def glass():
    """Windscreen, roof glass and the wedge-shaped side windows, laid on the planes."""
    front, rear, low = RIDGE + 0.006, RIDGE - 0.006, 0.56
    mesh = Mesh(
        *(
            plate([_on_roof(*corner) for corner in corners], 0.0025)
            for corners in (
                ((low, 0.90), (front, 0.90), (front, -0.90), (low, -0.90)),
                ((rear, 0.90), (0.09, 0.86), (0.09, -0.86), (rear, -0.90)),
            )
        )
    )
    for corners in (
        ((0.575, 0.42), (RIDGE + 0.004, 0.34), (RIDGE + 0.004, 0.88)),
        ((RIDGE - 0.010, 0.33), (0.060, 0.30), (0.130, 0.84), (RIDGE - 0.010, 0.88)),
    ):
        points = [_on_side(x, up) for x, up in corners]
        mesh.add_mirrored(_outward(points, 0.0025))
    return mesh


def _outward(points, thickness):
    """Plate on a left-hand panel that grows away from the truck's center."""
    solid = plate(points, thickness)
    if np.asarray(solid[-1])[:, 1].mean() < np.asarray(points)[:, 1].mean():
        solid = plate(points[::-1], thickness)
    return solid


def _bar(outline, half):
    """Lamp across the truck: an outline in x-z from -half to half."""
    return Mesh(loft([[(x, y, z) for x, z in outline] for y in (-half, half)]))


def light_bar():
    """Thin lamp across the nose."""
    rear, front = NOSE - 0.012, NOSE + 0.004
    return _bar(((rear, 0.2225), (front, 0.2225), (front, 0.2310), (rear, 0.2335)), 0.221)


def tail_bar():
    """Thin lamp across the tail."""
    rear, front = TAIL - 0.003, TAIL + 0.010
    return _bar(((rear, 0.252), (front, 0.252), (front, 0.266), (rear, 0.266)), 0.236)


def tyre():
    """Tyre with bevelled shoulders; its 48 corners are at the wheel's radius."""
    half = WIDTH / 2.0
    side = [(0.068, half - 0.008), (0.074, half), (0.090, half), (RADIUS, half - 0.012)]
    return Mesh(lathe(side + [(r, -y) for r, y in side[::-1]], 48))


def hub():
    """Hub cap: a seven-sided dish with straight spokes on both faces."""
    half = WIDTH / 2.0
    dish = [
        (0.0005, half - 0.012),
        (0.070, half - 0.010),
        (0.070, 0.010 - half),
        (0.0005, 0.012 - half),
    ]
    mesh = Mesh(lathe(dish, 21))
    for spoke in range(7):
        a = 2.0 * np.pi * spoke / 7.0
        along, across = np.array((np.cos(a), np.sin(a))), np.array((-np.sin(a), np.cos(a)))
        outline = [
            along * r + across * w
            for r, w in ((0.008, -0.006), (0.070, -0.013), (0.070, 0.013), (0.008, 0.006))
        ]
        mesh.add_mirrored(prism(outline, half - 0.013, half - 0.003))
    mesh.add(
        lathe(
            [
                (0.0005, half - 0.001),
                (0.016, half - 0.003),
                (0.016, 0.003 - half),
                (0.0005, 0.001 - half),
            ],
            7,
        )
    )
    return mesh


FRONT, REAR = 0.40, -0.34  # x of the box; the hitch is at +0.70
TRAILER_FLOOR, SHOULDER, ROOF = 0.225, 0.520, 0.605
TRAILER_HALF = 0.25


def trailer_box():
    """Box with a folded roof and a raked front, and skirts before and behind the wheels."""
    sections = []
    for x, half, low, shoulder, ridge, top in (
        (REAR, TRAILER_HALF, TRAILER_FLOOR, SHOULDER, 0.200, ROOF),
        (0.30, TRAILER_HALF, TRAILER_FLOOR, SHOULDER, 0.200, ROOF),
        (FRONT, 0.225, TRAILER_FLOOR + 0.02, SHOULDER - 0.05, 0.190, ROOF - 0.055),
    ):
        left = [(x, half - 0.012, low), (x, half, shoulder - 0.11), (x, half, shoulder)]
        sections.append(_mirrored([*left, (x, ridge, top)]))
    mesh = Mesh(loft(sections))
    for outline in (
        ((0.130, 0.130), (0.340, 0.150), (0.370, 0.235), (0.088, 0.235)),
        ((-0.300, 0.150), (-0.130, 0.130), (-0.088, 0.235), (REAR, 0.235)),
    ):
        mesh.add_mirrored(prism(outline, 0.110, TRAILER_HALF - 0.014))
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
        mesh.add_mirrored(
            box((x - 0.003, TRAILER_HALF - 0.020, 0.30), (x + 0.003, TRAILER_HALF + 0.0015, 0.50))
        )
    return mesh


def trailer_lights():
    """Two upright lamps at the tail."""
    mesh = Mesh()
    corners = np.array(((REAR - 0.006, 0.205, 0.275), (REAR + 0.01, 0.235, 0.500)))
    mesh.add_mirrored(box(*corners))
    return mesh


MAKERS = {
    make.__name__: make
    for make in (
        shell,
        sides,
        trim,
        glass,
        light_bar,
        tail_bar,
        tyre,
        hub,
        trailer_box,
        trailer_trim,
        trailer_lights,
    )
}

# RGB 0..1, as in urdf/materials.xacro.
STEEL, TRIM, GLASS = (0.66, 0.68, 0.70), (0.10, 0.10, 0.11), (0.07, 0.09, 0.11)
COLORS = {
    "shell": STEEL,
    "sides": STEEL,
    "trim": TRIM,
    "glass": GLASS,
    "light_bar": (1.0, 0.98, 0.90),
    "tail_bar": (0.85, 0.05, 0.05),
    "tyre": (0.06, 0.06, 0.06),
    "hub": (0.32, 0.33, 0.35),
    "trailer_box": (0.78, 0.79, 0.80),
    "trailer_trim": TRIM,
    "trailer_lights": (0.85, 0.05, 0.05),
}
MESHES = MeshSet("cybertruck", MAKERS, COLORS, folded=True)


def main(argv=None):
    """Command line: optional target folder; prints the paths written."""
    return MESHES.main(os.path.join(os.path.dirname(__file__), "..", "..", "meshes"), argv)


if __name__ == "__main__":
    sys.exit(main())

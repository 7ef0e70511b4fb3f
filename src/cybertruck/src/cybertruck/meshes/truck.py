"""The truck's meshes in base_footprint: ground at z = 0, rear axle's middle at x = 0, in metres.

A few planes only: one line from the nose to the roof's ridge, one from there to the tail, sides
that lean in above a shoulder crease, trapezoid arches.
"""

import numpy as np
from paddock_common.meshes.solids import Mesh, box, lathe, loft, plate, prism

AXLES = (0.0, 0.508)  # x of the rear and front axle
NOSE, RIDGE, TAIL = 0.7302, 0.30, -0.235
RADIUS, WIDTH = 0.1016, 0.0762  # of a wheel
FLOOR, ARCH = 0.085, 0.222  # z of the underside, of the arches' tops
HALF = 0.254  # half width at the shoulder crease
LEAN = 0.73  # of the upper sides: inwards by this for each metre up


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


def shell():
    """Upper body from the arches' tops to the roof: one convex, folded solid."""
    sections = []
    for x in (TAIL, TAIL + 0.03, RIDGE, 0.66, NOSE):
        half = side_half(x)
        lower = half - 0.006
        left = [(x, lower, ARCH - 0.006), (x, half, shoulder(x)), (x, roof_half(x), top(x))]
        sections.append(left + [(x, -y, z) for x, y, z in left[::-1]])
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
        plate(
            [
                _on_roof(low, 0.90),
                _on_roof(front, 0.90),
                _on_roof(front, -0.90),
                _on_roof(low, -0.90),
            ],
            0.0025,
        ),
        plate(
            [
                _on_roof(rear, 0.90),
                _on_roof(0.09, 0.86),
                _on_roof(0.09, -0.86),
                _on_roof(rear, -0.90),
            ],
            0.0025,
        ),
    )
    for corners in (
        ((0.575, 0.42), (RIDGE + 0.004, 0.34), (RIDGE + 0.004, 0.88)),
        ((RIDGE - 0.010, 0.33), (0.060, 0.30), (0.130, 0.84), (RIDGE - 0.010, 0.88)),
    ):
        points = [_on_side(x, up) for x, up in corners]
        mesh.add_mirrored(_outward(points, 0.0025))
    return mesh


def _outward(points, thickness):
    """Plate on a left-hand panel that grows away from the truck's middle."""
    solid = plate(points, thickness)
    if np.asarray(solid[-1])[:, 1].mean() < np.asarray(points)[:, 1].mean():
        solid = plate(points[::-1], thickness)
    return solid


def light_bar():
    """Thin lamp across the nose."""
    return Mesh(
        loft(
            [
                [
                    (NOSE - 0.012, y, 0.2225),
                    (NOSE + 0.004, y, 0.2225),
                    (NOSE + 0.004, y, 0.2310),
                    (NOSE - 0.012, y, 0.2335),
                ]
                for y in (-0.221, 0.221)
            ]
        )
    )


def tail_bar():
    """Thin lamp across the tail."""
    return Mesh(
        loft(
            [
                [
                    (TAIL - 0.003, y, 0.252),
                    (TAIL + 0.010, y, 0.252),
                    (TAIL + 0.010, y, 0.266),
                    (TAIL - 0.003, y, 0.266),
                ]
                for y in (-0.236, 0.236)
            ]
        )
    )


def tyre():
    """Tyre with bevelled shoulders; 48 flats reach the wheel's radius at their corners."""
    half = WIDTH / 2.0
    side = [(0.068, half - 0.008), (0.074, half), (0.090, half), (RADIUS, half - 0.012)]
    mesh = Mesh(lathe(side + [(r, -y) for r, y in side[::-1]], 48))
    return mesh


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

"""The car's shell, its stripes and windows, drawn in the chassis frame."""

from functools import partial

import numpy as np
from paddock_common.meshes import solids
from paddock_common.meshes.solids import Mesh, arch

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

loft, prism = (partial(make, fans=True) for make in (solids.loft, solids.prism))


def _stations(table, fine):
    """Interpolate a table of stations at finer x with Hermite pieces of limited slope."""
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


def _shell_section(row):
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


def _cabin_section(row, grow=0.0):
    x, foot, roof, z_foot, z_roof = row
    half = [
        (foot + grow, z_foot),
        (roof + grow, max(z_roof - 0.004, z_foot + 0.001) + grow),
        (0.8 * roof + grow, z_roof + grow),
    ]
    return [(x, y, z) for y, z in half] + [(x, -y, z) for y, z in half[::-1]]


def _cabin_at(x):
    return np.array([x] + [np.interp(x, CABIN[:, 0], column) for column in CABIN.T[1:]])


def body():
    """Painted shell, fenders over the four wheels, roof, pillars, wing."""
    mesh = Mesh(loft([_shell_section(row) for row in _stations(SHELL, 4)]))
    for axle, start, stop in ((FRONT_AXLE, 0.12, 2.9), (REAR_AXLE, 0.3, 2.95)):
        mesh.add_mirrored(arch(axle, 0.0365, 0.0415, start, stop, 0.040, 0.0975, 18))
    # Roof slab and pillars stand 1 mm out of the glass.
    mesh.add(loft([_roof_section(_cabin_at(x)) for x in np.linspace(-0.052, 0.012, 7)]))
    for a, b in ((-0.022, -0.014), (-0.056, -0.049)):
        mesh.add(loft([_cabin_section(_cabin_at(x), 0.0012) for x in (a, b)]))
    # Windscreen posts follow the cabin's edge from hood to roof.
    for a, b in ((0.060, 0.010), (-0.086, -0.048)):
        mesh.add_mirrored(loft([_post_section(_cabin_at(x)) for x in np.linspace(a, b, 6)]))
    mesh.add(prism(WING, -0.078, 0.078))
    return mesh


def _roof_section(row):
    x, _, roof, _, top = row
    left = [(0.85 * roof, top - 0.001), (0.85 * roof, top + 0.002)]
    right = [(-y, z) for y, z in left[::-1]]
    return [(x, y, z) for y, z in [*left, (0.0, top + 0.004), *right]]


def _post_section(row):
    x, _, roof, _, top = row
    edges = ((-0.007, 0.002), (0.0018, -0.002), (0.0018, -0.006), (-0.007, -0.003))
    return [(x, roof + dy, top + dz) for dy, dz in edges]


def stripe():
    """Two racing stripes over hood and tail, lying 0.4 mm above the shell."""
    mesh = Mesh()
    rows = _stations(SHELL, 4)
    for a, b in ((0.055, 0.156), (-0.131, -0.080)):
        part = [row for row in rows if a <= row[0] <= b]
        for low, high in ((0.005, 0.013), (-0.013, -0.005)):
            edges = ((low, 0.0005), (high, 0.0005), (high, 0.0032), (low, 0.0032))
            mesh.add(loft([[(row[0], y, row[6] + z) for y, z in edges] for row in part]))
    return mesh


def glass():
    """Cabin windows in one piece."""
    x = np.concatenate([np.linspace(-0.088, 0.062, 13), CABIN[:, 0]]).round(4)
    return Mesh(loft([_cabin_section(_cabin_at(x)) for x in np.unique(x)]))

"""Report of a drive along a path: key figures, CSV and a plot."""

import csv
import math

import numpy as np

from cybertruck.trailer.kinematics import hitch_position, rear_axle, trailer_axle

COLUMNS = (
    "time",
    "arc",
    "lateral_error",
    "heading_error",
    "hitch_angle",
    "trailer_x",
    "trailer_y",
    "trailer_heading",
    "truck_x",
    "truck_y",
    "truck_heading",
    "speed",
)
UNITS = ("s", "m", "m", "rad", "rad", "m", "m", "rad", "m", "m", "rad", "m/s")
TRUCK_BOX = (-0.225, 0.72, 0.48)  # rear end, front end from the rear axle, and width [m]
TRAILER_BOX = (-0.34, 0.40, 0.50)  # the same of the trailer, from its axle [m]


def table(path, times, states, speeds, geometry):
    """Measures a drive against its path.

    Args:
        path: Path of the trailer's axle, driven backwards.
        times: (n,) [s].
        states: (n, 4) x, y of C, θ1 and ψ [m, m, rad, rad].
        speeds: (n,) of C [m/s].

    Returns:
        (n, 12) in the order of COLUMNS.
    """
    states = np.asarray(states, dtype=float)
    x, y, heading = trailer_axle(*states[:, :3].T, states[:, 3], geometry)
    arc = np.empty(len(states))
    arc[0] = path.first_nearest(x[0], y[0], 3.0)
    for index in range(1, len(states)):
        arc[index] = path.nearest(x[index], y[index], arc[index - 1])
    lateral, heading_error = path.errors(x, y, heading + math.pi, arc)
    return np.column_stack(
        (
            np.asarray(times) - times[0],
            arc,
            lateral,
            heading_error,
            states[:, 3],
            x,
            y,
            heading,
            states[:, :3],
            speeds,
        )
    )


def column(rows, name):
    """Returns one column of a table by its name."""
    return rows[:, COLUMNS.index(name)]


def summary(rows, path):
    """Returns the key figures of a drive.

    Returns:
        Dict of name -> number: lateral errors [m] of the full drive and of the last 5 m, distance
        and heading error at the path's end [m, degrees].
    """
    lateral, arc = column(rows, "lateral_error"), column(rows, "arc")
    late = lateral[arc > path.length - 5.0]
    return {
        "rms_lateral_error_m": float(np.sqrt(np.mean(lateral**2))),
        "max_lateral_error_m": float(np.max(np.abs(lateral))),
        "rms_lateral_error_last_5_m": float(np.sqrt(np.mean(late**2))) if len(late) else None,
        "end_distance_m": float(math.hypot(arc[-1] - path.length, lateral[-1])),
        "end_heading_error_deg": float(math.degrees(column(rows, "heading_error")[-1])),
        "max_hitch_angle_deg": float(np.degrees(np.max(np.abs(column(rows, "hitch_angle"))))),
    }


def write_csv(file, rows):
    """Writes a table with a header of names and units."""
    with open(file, "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(f"{name} [{unit}]" for name, unit in zip(COLUMNS, UNITS))
        writer.writerows([f"{value:.5f}" for value in row] for row in rows)


def outline(x, y, heading, box):
    """Returns the corners (5, 2) of a box at a pose, closed [m]."""
    rear, front, width = box
    half = 0.5 * width
    corners = np.array(((rear, -half), (front, -half), (front, half), (rear, half), (rear, -half)))
    cos, sin = math.cos(heading), math.sin(heading)
    return corners @ np.array(((cos, sin), (-sin, cos))) + (x, y)


def plot_truck(axes, trailer, hitch_angle, geometry, alpha=1.0):
    """Plots truck, trailer and tongue from above.

    Args:
        trailer: (x, y, θ2) of Q.
        hitch_angle: ψ [rad].
    """
    truck = rear_axle(*trailer, hitch_angle, geometry)
    hitch = hitch_position(*truck, geometry)
    axes.plot(*outline(*truck, TRUCK_BOX).T, color="#2f5d8a", linewidth=1.0, alpha=alpha)
    axes.plot(*outline(*trailer, TRAILER_BOX).T, color="#b5651d", linewidth=1.0, alpha=alpha)
    axes.plot(
        (truck[0], hitch[0], trailer[0]),
        (truck[1], hitch[1], trailer[1]),
        color="0.35",
        linewidth=0.8,
        alpha=alpha,
    )


def _plot_overview(above, rows, path, geometry, title):
    """Plots the path, and truck and trailer every meter."""
    above.plot(*path.points.T, color="0.6", linewidth=4.0, label="path")
    above.plot(
        column(rows, "trailer_x"),
        column(rows, "trailer_y"),
        color="#b5651d",
        linewidth=1.4,
        label="trailer's axle",
    )
    above.plot(
        column(rows, "truck_x"),
        column(rows, "truck_y"),
        color="#2f5d8a",
        linewidth=0.8,
        linestyle="--",
        label="truck's rear axle",
    )
    steps = np.hypot(*np.diff(rows[:, [5, 6]], axis=0).T)
    driven = np.concatenate(([0.0], np.cumsum(steps)))
    for meter in np.arange(0.0, driven[-1], 1.0):
        row = rows[np.searchsorted(driven, meter)]
        plot_truck(above, row[5:8], row[4], geometry, 0.55)
    plot_truck(above, rows[-1, 5:8], rows[-1, 4], geometry)
    above.plot(*path.points[0], "o", color="0.3")
    above.plot(*path.points[-1], "s", color="0.3")
    above.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=title)
    above.set_adjustable("datalim")
    above.grid(alpha=0.3)
    above.legend(loc="best")


def write_figure(file, rows, path, geometry, title):
    """Plots the path, truck and trailer every meter, and the errors over arc length, into a PNG."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 6.5))
    grid = figure.add_gridspec(3, 5)
    _plot_overview(figure.add_subplot(grid[:, :3]), rows, path, geometry, title)
    for index, (name, label, scale) in enumerate(
        (
            ("lateral_error", "lateral error [cm]", 100.0),
            ("heading_error", "heading error [°]", 180.0 / math.pi),
            ("hitch_angle", "hitch angle [°]", 180.0 / math.pi),
        )
    ):
        axes = figure.add_subplot(grid[index, 3:])
        axes.plot(column(rows, "arc"), scale * column(rows, name), color="#b5651d", linewidth=1.2)
        axes.axhline(0.0, color="0.6", linewidth=0.6)
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    axes.set_xlabel("arc length [m]")
    figure.tight_layout()
    figure.savefig(file, dpi=100)

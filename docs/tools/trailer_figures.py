#!/usr/bin/env python3
"""Draws the figures of docs/trailer.md: geometry, forward off-tracking, backing."""

import math
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
sys.path.append(str(Path(__file__).resolve().parents[2] / "src" / "cybertruck" / "test"))
from cybertruck.trailer.geometry import Geometry, jackknife_angle, steady_hitch_angle, towing_limit  # noqa: E402
from cybertruck.trailer.kinematics import hitch_position, trailer_axle  # noqa: E402
from cybertruck.trailer.report import TRAILER_BOX, TRUCK_BOX, outline, plot_truck  # noqa: E402
from cybertruck.trailer.shapes import make_shape  # noqa: E402
from cybertruck.trailer.steering import IdealSteering  # noqa: E402
from cybertruck.trailer.tracker import Tracker  # noqa: E402
from matplotlib import pyplot  # noqa: E402
from matplotlib.patches import Arc  # noqa: E402
from trailer_sim import advance, simulate, start_state  # noqa: E402

TRUCK, TRAILER = "#2f5d8a", "#b5651d"
GEOMETRY = Geometry()


def wheel(axes, x, y, heading):
    """Draws a wheel from above at a pose [m, m, rad]."""
    axes.fill(*outline(x, y, heading, (-0.1, 0.1, 0.07)).T, color="0.15")


def annotate_angle(axes, at, first, second, radius, text):
    """Draws the arc from one direction to another [rad] and its name."""
    low, high = math.degrees(first), math.degrees(second)
    axes.add_patch(Arc(at, 2 * radius, 2 * radius, theta1=min(low, high), theta2=max(low, high)))
    center = 0.5 * (first + second)
    axes.text(
        at[0] + (radius + 0.10) * math.cos(center),
        at[1] + (radius + 0.10) * math.sin(center),
        text,
        ha="center",
        va="center",
        fontsize=13,
    )


def measure_line(axes, start, end, aside, text):
    """Draws a dimension line with its name along two points [m]."""
    start, end = np.array(start), np.array(end)
    along = (end - start) / np.hypot(*(end - start))
    shift = aside * np.array((-along[1], along[0]))
    axes.annotate("", end + shift, start + shift, arrowprops={"arrowstyle": "<->", "color": "0.3"})
    center = (
        0.5 * (start + end) + 1.0 * shift + np.sign(aside) * 0.07 * np.array((-along[1], along[0]))
    )
    axes.text(*center, text, ha="center", va="center", fontsize=13)


def geometry_figure(file):
    """Truck and trailer from above with points, lengths and angles."""
    heading, hitch_angle, steering = math.radians(42.0), math.radians(-26.0), math.radians(24.0)
    figure, axes = pyplot.subplots(figsize=(9.0, 7.0))
    truck = (0.0, 0.0, heading)
    front = (GEOMETRY.wheelbase * math.cos(heading), GEOMETRY.wheelbase * math.sin(heading))
    hitch = hitch_position(*truck, GEOMETRY)
    axle = trailer_axle(*truck, hitch_angle, GEOMETRY)
    axes.fill(*outline(*truck, TRUCK_BOX).T, color=TRUCK, alpha=0.16)
    axes.fill(*outline(*axle, TRAILER_BOX).T, color=TRAILER, alpha=0.16)
    for (x, y, direction), rotation, color in (
        (truck, 0.0, TRUCK),
        ((*front, heading), steering, TRUCK),
        (axle, 0.0, TRAILER),
    ):
        across = 0.215 * np.array((-math.sin(direction), math.cos(direction)))
        axes.plot(
            (x - across[0], x + across[0]),
            (y - across[1], y + across[1]),
            color=color,
            linewidth=1.5,
        )
        for side in (-1, 1):
            wheel(axes, x + side * across[0], y + side * across[1], direction + rotation)
    axes.plot((front[0], 0.0, hitch[0]), (front[1], 0.0, hitch[1]), color=TRUCK, linewidth=2.5)
    axes.plot((hitch[0], axle[0]), (hitch[1], axle[1]), color=TRAILER, linewidth=2.5)
    for (x, y), name, dx, dy in (
        (front, "", 0, 0),
        ((0.0, 0.0), "C", 0.03, -0.13),
        (hitch, "H", 0.03, -0.13),
        (axle[:2], "Q", 0.03, -0.13),
    ):
        axes.plot(x, y, "o", color="0.1", markersize=6)
        axes.text(x + dx, y + dy, name, fontsize=14, weight="bold")
    for (x, y), direction, color in (((0.0, 0.0), heading, TRUCK), (axle[:2], axle[2], TRAILER)):
        axes.plot((x, x + 0.42), (y, y), color="0.6", linestyle=":")
        axes.plot(
            (x, x + 0.42 * math.cos(direction)),
            (y, y + 0.42 * math.sin(direction)),
            color=color,
            linestyle=":",
        )
    axes.plot(
        (front[0], front[0] + 0.5 * math.cos(heading)),
        (front[1], front[1] + 0.5 * math.sin(heading)),
        color=TRUCK,
        linestyle=":",
    )
    axes.plot(
        (front[0], front[0] + 0.5 * math.cos(heading + steering)),
        (front[1], front[1] + 0.5 * math.sin(heading + steering)),
        color="0.2",
        linestyle=":",
    )
    axes.plot(
        (hitch[0], hitch[0] + 1.25 * math.cos(axle[2])),
        (hitch[1], hitch[1] + 1.25 * math.sin(axle[2])),
        color=TRAILER,
        linestyle="--",
        linewidth=1.0,
    )
    axes.plot(
        (front[0], hitch[0] + 1.25 * math.cos(heading)),
        (front[1], hitch[1] + 1.25 * math.sin(heading)),
        color=TRUCK,
        linestyle="--",
        linewidth=1.0,
    )
    annotate_angle(axes, (0.0, 0.0), 0.0, heading, 0.36, "θ₁")
    annotate_angle(axes, axle[:2], 0.0, axle[2], 0.30, "θ₂")
    annotate_angle(axes, front, heading, heading + steering, 0.42, "φ")
    annotate_angle(axes, hitch, axle[2], heading, 1.12, "ψ < 0")
    measure_line(axes, (0.0, 0.0), front, 0.36, "L")
    measure_line(axes, hitch, (0.0, 0.0), 0.36, "L₁")
    measure_line(axes, axle[:2], hitch, -0.36, "L₂")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", xlim=(-1.5, 1.15), ylim=(-0.95, 1.05))
    axes.grid(alpha=0.2)
    figure.tight_layout()
    figure.savefig(file, dpi=110)


def off_tracking_figure(file):
    """A corner driven forward: paths of both axles; and steady hitch angles over the radius."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(12.0, 5.2))
    radius, step = 1.4, 0.01
    quarter = 0.5 * math.pi * radius
    state, rows = np.zeros(4), []
    for index in range(round((2.5 + quarter + 3.0) / step)):
        path_curvature = 1.0 / radius if 2.5 <= index * step < 2.5 + quarter else 0.0
        rows.append(state)
        state = advance(state, 1.0, path_curvature, step, GEOMETRY)
    rows = np.array(rows)
    axle = np.column_stack(trailer_axle(*rows[:, :3].T, rows[:, 3], GEOMETRY))
    left.plot(rows[:, 0], rows[:, 1], color=TRUCK, label="truck's rear axle")
    left.plot(axle[:, 0], axle[:, 1], color=TRAILER, label="trailer's axle")
    for index in range(0, len(rows), 100):
        plot_truck(left, axle[index], rows[index, 3], GEOMETRY, 0.5)
    gap = np.array([np.min(np.hypot(*(axle[:, :2] - row[:2]).T)) for row in rows[100:-150]])
    left.set(
        aspect="equal",
        xlabel="x [m]",
        ylabel="y [m]",
        title=f"90° corner, R = {radius:g} m, cut by {100 * gap.max():.0f} cm",
    )
    left.legend(loc="upper left")
    left.grid(alpha=0.3)
    curvature = np.linspace(0.01, GEOMETRY.max_curvature, 600)
    angle = np.degrees(-steady_hitch_angle(curvature, GEOMETRY))
    right.plot(curvature, angle, color=TRAILER, label="steady hitch angle |ψ|")
    edge = 1.0 / math.sqrt(GEOMETRY.tongue_length**2 - GEOMETRY.hitch_offset**2)
    right.axvspan(
        edge, GEOMETRY.max_curvature, color="0.85", label="no steady towing: the trailer folds"
    )
    right.axvline(towing_limit(GEOMETRY), color=TRUCK, linestyle="--", label="limit for 45°")
    right.set(
        xlabel="truck's curvature F [1/m]",
        ylabel="[°]",
        ylim=(0, 125),
        xlim=(0, GEOMETRY.max_curvature),
        title="Towing forward on a circle",
    )
    right.legend(loc="upper left")
    right.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(file, dpi=100)


def backing_figure(file):
    """Kinematic drives onto a line from many starts, and from beyond the jackknife angle."""
    tight = Geometry(max_steering=math.atan(0.508 / 0.8))
    figure, axes = pyplot.subplots(
        2, 1, figsize=(11.0, 8.2), gridspec_kw={"height_ratios": (2.4, 4.6)}
    )
    path = make_shape("line", (8.0,))
    random = np.random.default_rng(7)
    count = 20
    limit = math.degrees(jackknife_angle(tight))
    starts = (
        (GEOMETRY, np.radians(random.uniform(-45, 45, count)), "20 random starts, hitch to 45°"),
        (
            tight,
            np.radians(random.uniform(limit, 79.0, count)) * random.choice((-1, 1), count),
            f"Fmax = 1/0.8: starts beyond the jackknife angle of {limit:.1f}° pull forward",
        ),
    )
    for view, (geometry, hitch, title) in zip(axes, starts):
        start = start_state(
            path,
            random.uniform(-1, 1, count),
            np.radians(random.uniform(-30, 30, count)),
            hitch,
            geometry,
        )
        steering = IdealSteering(geometry.wheelbase, geometry.max_steering)
        run = simulate(
            Tracker(path, geometry, steering, shape=(count,)), start, steering, geometry, 90.0
        )
        axle = trailer_axle(*np.moveaxis(run.states[..., :3], -1, 0), run.states[..., 3], geometry)
        view.plot(axle[0], axle[1], linewidth=0.8, alpha=0.8)
        view.axhline(0.0, color="0.6", linewidth=0.6)
        view.set(ylabel="y [m]", title=title, xlim=(-2.3, 8.2))
        view.set_aspect("equal")
        view.grid(alpha=0.3)
    axes[-1].set_xlabel("along the line, backing to the right; trailer's axle [m]")
    figure.tight_layout()
    figure.savefig(file, dpi=100)


def main():
    """Writes the figures into the argument's folder, or over those of the package."""
    images = Path(__file__).resolve().parents[2] / "src" / "cybertruck" / "docs" / "images"
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else images
    folder.mkdir(parents=True, exist_ok=True)
    geometry_figure(folder / "trailer_geometry.png")
    off_tracking_figure(folder / "trailer_off_tracking.png")
    backing_figure(folder / "trailer_backing.png")
    print(f"written to {folder}")


if __name__ == "__main__":
    main()

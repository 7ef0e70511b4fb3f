"""Paths of public packages in Gazebo and in Paddock, drawn over each other: docs/beside-gazebo.md.

    ./run exec python bench/paths_beside_gazebo.py                  the page from what is recorded
    ./run exec python bench/paths_beside_gazebo.py --update FOLDER  records anew, then the page

FOLDER has NAME.gazebo.json and NAME.paddock.json for each package, as bench/paths/record.py writes
them where one of the simulators runs the package's launch file. A package that FOLDER does not have
stays as it is recorded.

Two phases count as alike when speed and yaw rate of their second half agree within 5 %, or within
0.01 m/s and 0.015 rad/s. At rest it is the way that must be within 3 mm, or half of Gazebo's more.
"""

import argparse
import json
import math
import pathlib
import sys
from dataclasses import dataclass

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of the backend)

ROOT = pathlib.Path(__file__).resolve().parent.parent
RECORD = ROOT / "bench" / "paths" / "recorded.json"
PAGE = ROOT / "docs" / "beside-gazebo.md"
SIDES = ("gazebo", "paddock")
COLORS = {"gazebo": "#b3541e", "paddock": "#2f6f8f"}
PERIOD = 0.2  # simulated time between two recorded states [s]
UNIT = 1e4  # recorded are whole numbers: ms, 0.1 mm, 0.1 mrad
RATIO, SPEED, RATE = 0.05, 0.01, 0.015  # bounds of alike, [m/s], [rad/s]
WAY, MORE = 0.003, 1.5  # [m], times Gazebo's
RESTS, UNCOUNTED = ("idle", "rest"), ("stop",)
COLUMNS = 5


class InputError(ValueError):
    """What was given cannot be drawn."""


@dataclass(frozen=True)
class Motion:
    """The second half of a phase; way [m] is that of all of it.

    Attributes:
        speed: [m/s]; rate: of yaw [rad/s].
    """

    way: float
    speed: float
    rate: float


def turned(before, after):
    """Angle from one yaw to another [rad], the shorter way."""
    return (after - before + math.pi) % (2 * math.pi) - math.pi


def motion_of(rows):
    """Motion of a list of [time, x, y, yaw]."""
    middle = (rows[0][0] + rows[-1][0]) / 2
    late = [row for row in rows if row[0] >= middle]
    seconds = late[-1][0] - late[0][0]
    if not seconds > 0:
        raise InputError("its second half has no two states")

    def way(part):
        return sum(math.dist(a[1:3], b[1:3]) for a, b in zip(part, part[1:]))

    turn = sum(turned(a[3], b[3]) for a, b in zip(late, late[1:]))
    return Motion(way(rows), way(late) / seconds, turn / seconds)


def is_alike(phase, one, other):
    """Whether Paddock's Motion in a phase is Gazebo's."""
    if phase in RESTS:
        return other.way <= max(WAY, MORE * one.way)

    def near(a, b, least):
        return abs(a - b) <= max(RATIO * max(abs(a), abs(b)), least)

    return near(one.speed, other.speed, SPEED) and near(one.rate, other.rate, RATE)


def thinned(rows):
    """Rows about each PERIOD, the first and the last among them, in whole numbers."""
    kept = [rows[0]]
    for row in rows[1:-1]:
        if row[0] >= kept[-1][0] + PERIOD and row[0] <= rows[-1][0] - PERIOD / 2:
            kept.append(row)
    kept.append(rows[-1])
    return [[round(1e3 * t), *(round(UNIT * value) for value in rest)] for t, *rest in kept]


def widened(rows):
    """Recorded rows in s, m and rad."""
    return [[t / 1e3, *(value / UNIT for value in rest)] for t, *rest in rows]


def recorded():
    """name -> side -> phase -> rows [s, m, m, rad]."""
    cases = json.loads(RECORD.read_text(encoding="utf-8"))["cases"]
    return {
        name: {side: {k: widened(v) for k, v in sides[side].items()} for side in SIDES}
        for name, sides in cases.items()
    }


def read(folder):
    """The same of a folder's files, thinned."""
    folder, found = pathlib.Path(folder), {}
    for file in sorted(folder.glob("*.gazebo.json")):
        name = file.name[: -len(".gazebo.json")]
        sides = {}
        for side in SIDES:
            path = folder / f"{name}.{side}.json"
            if not path.is_file():
                raise InputError(f"'{path}' is missing; each package needs both")
            paths = json.loads(path.read_text()).get("paths")
            if not paths:
                raise InputError(f"'{path}' has no \"paths\"")
            sides[side] = {phase: thinned(rows) for phase, rows in paths.items()}
            for phase, rows in sides[side].items():
                try:
                    motion_of(widened(rows))
                except InputError as error:
                    raise InputError(f"phase '{phase}' of '{path}': {error}") from None
        if list(sides["gazebo"]) != list(sides["paddock"]):
            both = (", ".join(sides[side]) for side in SIDES)
            raise InputError("phases of '{}' are {} in Gazebo, {} in Paddock".format(name, *both))
        found[name] = sides
    if not found:
        raise InputError(f"'{folder}' has no file NAME.gazebo.json")
    return found


def update(folder):
    """Take a folder's paths into the record."""
    cases = json.loads(RECORD.read_text())["cases"] if RECORD.exists() else {}
    cases.update(read(folder))
    lines = []
    for name in sorted(cases):
        text = json.dumps(cases[name], separators=(",", ":"))
        lines.append(f"{json.dumps(name)}: {text}")
    RECORD.write_text('{"cases": {\n' + ",\n".join(lines) + "\n}}\n", encoding="utf-8")


def compare(cases):
    """name -> phase -> (Gazebo's Motion, Paddock's, whether they are alike)."""
    found = {}
    for name, sides in cases.items():
        found[name] = {}
        for phase in sides["gazebo"]:
            if phase not in UNCOUNTED:
                one, other = (motion_of(sides[side][phase]) for side in SIDES)
                found[name][phase] = one, other, is_alike(phase, one, other)
    return found


def curves(sides, side):
    """All phases of a side: times, x, y from its start in its direction there, speeds, rates."""
    rows = [row for phase in sides[side].values() for row in phase]
    _, x0, y0, yaw = rows[0]
    cos, sin = math.cos(yaw), math.sin(yaw)
    x = [cos * (row[1] - x0) + sin * (row[2] - y0) for row in rows]
    y = [cos * (row[2] - y0) - sin * (row[1] - x0) for row in rows]
    times, speeds, rates = [], [], []
    for a, b in zip(rows, rows[1:]):
        if b[0] - a[0] > PERIOD / 2:
            times.append((a[0] + b[0]) / 2 - rows[0][0])
            speeds.append(math.dist(a[1:3], b[1:3]) / (b[0] - a[0]))
            rates.append(turned(a[3], b[3]) / (b[0] - a[0]))
    return times, x, y, speeds, rates


def draw(cases, folder):
    """Three images: paths, speeds, yaw rates, with a small plot for each package."""
    kinds = {
        "paths": ("m", "m", lambda found: found[1:3]),
        "speeds": ("s", "m/s", lambda found: (found[0], found[3])),
        "yaw_rates": ("s", "rad/s", lambda found: (found[0], found[4])),
    }
    lines = math.ceil(len(cases) / COLUMNS)
    for kind, (x_unit, y_unit, pick) in kinds.items():
        figure, grid = pyplot.subplots(lines, COLUMNS, figsize=(2.5 * COLUMNS, 2.2 * lines))
        for axes in grid.flat:
            axes.set_axis_off()
        for axes, (name, sides) in zip(grid.flat, cases.items()):
            axes.set_axis_on()
            for side, width in zip(SIDES, (3.0, 1.2)):
                x, y = pick(curves(sides, side))
                axes.plot(x, y, color=COLORS[side], linewidth=width, label=side.capitalize())
            axes.set_title(f"{name} [{x_unit}, {y_unit}]", fontsize=8)
            axes.tick_params(labelsize=7)
            axes.grid(alpha=0.3)
            if kind == "paths":
                axes.set_aspect("equal", adjustable="datalim")
        grid.flat[0].legend(fontsize=7)
        figure.tight_layout()
        figure.savefig(pathlib.Path(folder) / f"beside_gazebo_{kind}.png", dpi=80)
        pyplot.close(figure)


SIX = {  # package -> what the picture calls it
    "husky-melodic-playpen": "Husky",
    "jackal-empty": "Jackal",
    "leo-gazebo": "Leo Rover",
    "tb3-world-burger": "TurtleBot3",
    "tfg-deepracer": "DeepRacer",
    "own-truck": "Paddock's truck with its trailer",
}


def draw_six(cases, file):
    """One image for the README: the paths of SIX."""
    figure, grid = pyplot.subplots(2, 3, figsize=(9, 5))
    for axes, (name, title) in zip(grid.flat, SIX.items()):
        if name not in cases:
            axes.set_axis_off()
            continue
        for side, width in zip(SIDES, (5.0, 1.5)):
            _, x, y, _, _ = curves(cases[name], side)
            axes.plot(x, y, color=COLORS[side], linewidth=width, label=side.capitalize())
        axes.set_title(f"{title} [m]", fontsize=10)
        axes.tick_params(labelsize=8)
        axes.grid(alpha=0.3)
        axes.set_aspect("equal", adjustable="datalim")
    grid.flat[0].legend(fontsize=9)
    figure.tight_layout()
    figure.savefig(file, dpi=100)
    pyplot.close(figure)


HEAD = """# Paths beside Gazebo

One plan of commands drives public packages, unmodified, in Gazebo Classic 11.1 and in Paddock:
{count} of them, one run each. All paths begin at the same place and heading (orange: Gazebo, blue:
Paddock):

![Paths](images/beside_gazebo_paths.png)

Their speed over the ground and their yaw rate over simulated time:

![Speeds](images/beside_gazebo_speeds.png)

![Yaw rates](images/beside_gazebo_yaw_rates.png)

Commands come from a program outside and arrive at other steps each time. A path that depends on the
step of a command differs from run to run in both simulators. A phase counts as alike when the speed
and the yaw rate of its second half agree within 5 %, or within 0.01 m/s and 0.015 rad/s; at rest,
when the way is at most 3 mm, or half as much again as Gazebo's. {alike} of {total}
are. The others, by cause: [compared with Gazebo](gazebo-comparison.md#motion).

What cameras see of a world with a place for each of their features (Gazebo's image on the left):

![Images](images/pictures_beside_gazebo.png)

| package | phase | Gazebo: m/s, rad/s | Paddock: m/s, rad/s | alike |
| --- | --- | --- | --- | --- |
"""
FOOT = """
At rest the two numbers are the way [mm] and the yaw rate.

This page and its images are made by `./run exec python bench/paths_beside_gazebo.py` from recorded
paths (`bench/paths/recorded.json`, numbers alone). To record a package again, or another one, run
its launch file in Gazebo and then in Paddock, and beside each
`python3 bench/paths/record.py PLAN.json FOLDER/NAME.gazebo.json` (`.paddock.json`); its first lines
say what PLAN.json has. Then `bench/paths_beside_gazebo.py --update FOLDER`.
"""


def page(compared):
    """The page's text."""
    phases = [phase for found in compared.values() for phase in found.values()]
    alike = sum(good for _, _, good in phases)
    text = HEAD.format(count=len(compared), alike=alike, total=len(phases))
    for name, found in compared.items():
        for phase, (one, other, good) in found.items():
            both = (
                f"{1e3 * m.way:.1f} mm, {m.rate:.3f}"
                if phase in RESTS
                else f"{m.speed:.3f}, {m.rate:.3f}"
                for m in (one, other)
            )
            text += f"| {name} | {phase} | {' | '.join(both)} | {'yes' if good else 'no'} |\n"
    return text + FOOT


def main(arguments=None):
    """Record, draw, write; returns the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--update", metavar="FOLDER", help="take these recordings into the record")
    chosen = parser.parse_args(arguments)
    try:
        if chosen.update:
            update(chosen.update)
        cases = recorded()
        compared = compare(cases)
    except (InputError, OSError, ValueError) as error:
        print(f"paths_beside_gazebo: {error}", file=sys.stderr)
        return 2
    draw(cases, ROOT / "docs" / "images")
    draw_six(cases, ROOT / "docs" / "images" / "beside_gazebo.png")
    PAGE.write_text(page(compared), encoding="utf-8")
    phases = [phase for found in compared.values() for phase in found.values()]
    print(f"{PAGE}: {sum(good for _, _, good in phases)} of {len(phases)} phases alike")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Paths of public packages in Gazebo and in Paddock, drawn over each other: docs/beside-gazebo.md.

    ./run exec python bench/paths_beside_gazebo.py                  the page from what is recorded
    ./run exec python bench/paths_beside_gazebo.py --update FOLDER  takes recordings, then the page

FOLDER has NAME.gazebo.json and NAME.paddock.json for each package, as bench/paths/record.py writes
them where one of the simulators runs the package's launch file; of further runs of the same plan
NAME.gazebo.2.json and so on. A package that FOLDER does not have stays as it is recorded.

A driven phase is alike when speed and yaw rate of its second half, the median of Paddock's runs,
are within 5 % of one of Gazebo's, or within 0.01 m/s and 0.015 rad/s. Where Gazebo's own runs
differ by more than 10 %, it is counted as neither; where Paddock's alone do, it is not alike. At
rest it is the way that must be within 3 mm, or half of Gazebo's more.
"""

import argparse
import json
import math
import pathlib
import re
import statistics
import sys
from dataclasses import dataclass

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of the backend)

ROOT = pathlib.Path(__file__).resolve().parent.parent
RECORD = ROOT / "bench" / "paths" / "recorded.json"
PACKAGES = ROOT / "bench" / "paths" / "packages.json"  # of the public ones: where they are from
PAGE = ROOT / "docs" / "beside-gazebo.md"
SIDES = ("gazebo", "paddock")
COLORS = {"gazebo": "#b3541e", "paddock": "#2f6f8f"}
PERIOD = 0.2  # simulated time between two recorded states [s]
UNIT = 1e4  # recorded are whole numbers: ms, 0.1 mm, 0.1 mrad
RATIO, SPEED, RATE = 0.05, 0.01, 0.015  # bounds of alike, [m/s], [rad/s]
WAY, MORE = 0.003, 1.5  # [m], times Gazebo's
SPREAD = 0.1  # of Gazebo's runs, above which a phase counts as neither
MOVES, TURNS = 0.02, 0.03  # a robot that is slower in Gazebo does not drive [m/s], [rad/s]
ALIKE, OTHERWISE, VARIES = "yes", "no", "Gazebo varies"
RESTS, UNCOUNTED = ("idle", "rest"), ("stop",)


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


def differs(values, least):
    """Whether values of several runs differ by more than SPREAD, and by more than `least`."""
    return max(values) - min(values) > max(SPREAD * max(map(abs, values)), least)


@dataclass(frozen=True)
class Compared:
    """A phase in both simulators.

    Attributes:
        phase: Its name.
        gazebo: Motion of each run.
        paddock: The same.
    """

    phase: str
    gazebo: tuple
    paddock: tuple

    @property
    def _sides(self):
        return self.gazebo, self.paddock

    @property
    def is_driven(self):
        """Whether the robot moves in Gazebo, commanded."""
        moves = (run.speed > MOVES or abs(run.rate) > TURNS for run in self.gazebo)
        return self.phase not in RESTS and any(moves)

    @property
    def verdict(self):
        """ALIKE, OTHERWISE or VARIES."""
        if self.phase in RESTS:
            way = statistics.median(run.way for run in self.paddock)
            near = way <= max(WAY, MORE * max(run.way for run in self.gazebo))
            return ALIKE if near else OTHERWISE
        found = set()
        for name, least in (("speed", SPEED), ("rate", RATE)):
            theirs, ours = ([getattr(run, name) for run in side] for side in self._sides)
            if differs(theirs, least):
                return VARIES
            middle = statistics.median(ours)
            bounds = (
                (abs(middle - a), max(RATIO * max(abs(middle), abs(a)), least)) for a in theirs
            )
            near = any(distance <= bound for distance, bound in bounds)
            found.add(near and not differs(ours, least))
        return OTHERWISE if False in found else ALIKE


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


def again():
    """name -> side -> phase -> Motion of each further run."""
    cases = json.loads(RECORD.read_text(encoding="utf-8"))["cases"]
    return {
        name: {
            side: {k: [Motion(*run) for run in runs] for k, runs in phases.items()}
            for side, phases in case.get("again", {}).items()
        }
        for name, case in cases.items()
    }


def read_run(path):
    """phase -> rows of one file, thinned, and phase -> Motion."""
    if not path.is_file():
        raise InputError(f"'{path}' is missing; each package needs both")
    paths = json.loads(path.read_text()).get("paths")
    if not paths:
        raise InputError(f"'{path}' has no \"paths\"")
    rows, motions = {phase: thinned(rows) for phase, rows in paths.items()}, {}
    for phase, few in rows.items():
        try:
            motions[phase] = motion_of(widened(few))
        except InputError as error:
            raise InputError(f"phase '{phase}' of '{path}': {error}") from None
    return rows, motions


def read(folder):
    """What is recorded of a package, of a folder's files."""
    folder, found = pathlib.Path(folder), {}
    for file in sorted(folder.glob("*.gazebo.json")):
        name = file.name[: -len(".gazebo.json")]
        sides, more = {}, {}
        for side in SIDES:
            sides[side], _ = read_run(folder / f"{name}.{side}.json")
            for path in sorted(folder.glob(f"{name}.{side}.[2-9].json")):
                for phase, motion in read_run(path)[1].items():
                    run = [motion.way, motion.speed, motion.rate]
                    more.setdefault(side, {}).setdefault(phase, []).append(run)
        if list(sides["gazebo"]) != list(sides["paddock"]):
            both = (", ".join(sides[side]) for side in SIDES)
            raise InputError("phases of '{}' are {} in Gazebo, {} in Paddock".format(name, *both))
        found[name] = {**sides, **({"again": more} if more else {})}
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


def compare(cases, more=None):
    """name -> list of Compared, of the phases that count.

    Args:
        cases: As recorded() gives them.
        more: As again() gives them; None: of the record.
    """
    found, more = {}, again() if more is None else more
    for name, sides in cases.items():
        runs = more.get(name, {})
        found[name] = [
            Compared(
                phase,
                *(
                    (motion_of(sides[side][phase]), *runs.get(side, {}).get(phase, ()))
                    for side in SIDES
                ),
            )
            for phase in sides["gazebo"]
            if phase not in UNCOUNTED
        ]
    return found


def packages():
    """name -> robot, address, branch, launch, of the public packages."""
    return json.loads(PACKAGES.read_text(encoding="utf-8"))


def sums(compared):
    """Rows of counts: what, robots, phases, alike, otherwise, Gazebo varies."""
    public, groups = packages(), {}
    for name, phases in compared.items():
        whose = "public" if name in public else "Paddock's own"
        for one in phases:
            stands = "at rest" if one.phase in RESTS else "commanded, but it stands in Gazebo"
            what = "driven" if one.is_driven else stands
            groups.setdefault((whose, what), []).append((name, one.verdict))
    rows = []
    for (whose, what), found in sorted(groups.items(), key=lambda group: group[0][0] != "public"):
        verdicts = [verdict for _, verdict in found]
        counts = [verdicts.count(verdict) for verdict in (ALIKE, OTHERWISE, VARIES)]
        rows.append((f"{whose}, {what}", len({name for name, _ in found}), len(found), *counts))
    return rows


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


KINDS = {  # of images: units of both axes, what of curves() they show
    "paths": ("x [m]", "y [m]", lambda found: found[1:3]),
    "speeds": ("time [s]", "speed [m/s]", lambda found: (found[0], found[3])),
    "yaw_rates": ("time [s]", "yaw rate [rad/s]", lambda found: (found[0], found[4])),
}
SIX = {  # package -> what the picture calls it
    "husky-melodic-playpen": "Husky",
    "jackal-empty": "Jackal",
    "leo-gazebo": "Leo Rover",
    "tb3-world-burger": "TurtleBot3",
    "tfg-deepracer": "DeepRacer",
    "own-truck": "Paddock's truck with its trailer",
}


def draw(cases, titles, kind, file, columns, size):
    """Draws an image with a plot for each package.

    Args:
        titles: package -> title of its plot.
        kind: Of KINDS.
        columns: Plots beside each other.
        size: Of a plot (width, height) [inch].
    """
    names = [name for name in titles if name in cases]
    lines = max(1, math.ceil(len(names) / columns))
    figure, grid = pyplot.subplots(
        lines, columns, figsize=(size[0] * columns, size[1] * lines), squeeze=False
    )
    x_title, y_title, pick = KINDS[kind]
    for axes in grid.flat:
        axes.set_axis_off()
    for number, (axes, name) in enumerate(zip(grid.flat, names)):
        axes.set_axis_on()
        for side, width in zip(SIDES, (5.0, 1.5)):
            x, y = pick(curves(cases[name], side))
            axes.plot(x, y, color=COLORS[side], linewidth=width, label=side.capitalize())
        axes.set_title(titles[name], fontsize=10)
        axes.tick_params(labelsize=8)
        if number % columns == 0:
            axes.set_ylabel(y_title, fontsize=9)
        if number >= len(names) - columns:
            axes.set_xlabel(x_title, fontsize=9)
        axes.grid(alpha=0.3)
        if kind == "paths":
            axes.set_aspect("equal", adjustable="datalim")
    grid.flat[0].legend(fontsize=9)
    figure.tight_layout()
    figure.savefig(file, dpi=80)
    pyplot.close(figure)


def draw_all(cases, folder):
    """Draws six robots for README and page, and all packages for the page of all paths."""
    folder, all_titles = pathlib.Path(folder), {name: name for name in cases}
    for kind in KINDS:
        six = folder / ("beside_gazebo.png" if kind == "paths" else f"beside_gazebo_{kind}.png")
        draw(cases, SIX, kind, six, 2, (2.8, 2.2))  # which a phone shows large enough
        draw(cases, all_titles, kind, folder / f"all_{kind}.png", 4, (2.8, 2.2))


HEAD = """# Paths beside Gazebo

The same commands drive unmodified packages in Gazebo Classic 11.1 and in Paddock. A phase is one
command of the drive.
**{alike} of {total} driven phases of {files} launch files from {addresses} public repositories are
alike**; in {varies} more Gazebo itself differs from run to run.

![Paths of six robots](images/beside_gazebo.png)

![Their speeds](images/beside_gazebo_speeds.png)

![Their yaw rates](images/beside_gazebo_yaw_rates.png)

*Orange: Gazebo, blue: Paddock. All paths begin at the same place and heading.
[All packages](all-paths.md)*

## What is counted

| | launch files | phases | alike | otherwise | Gazebo varies |
| --- | ---: | ---: | ---: | ---: | ---: |
"""
RULE = """
- **Driven**: Gazebo's robot moves faster than 2 cm/s or turns faster than 0.03 rad/s. A robot that
  stands, or that does not move in Gazebo when it is commanded, is counted apart.
- **Alike**: speed and yaw rate of the phase's second half are within 5 % of one run of Gazebo, or
  within 0.01 m/s and 0.015 rad/s.
- **Gazebo varies**: its own runs differ by more than 10 %. Where Paddock's alone do, the phase is
  not alike. {runs}
- **At rest**: the robot creeps at most 3 mm, or half as much again as in Gazebo.
- Robots without recorded paths that deviate, by [cause](gazebo-comparison.md#motion), are not in
  the table: {others}.
  Each counted as one phase: {alike} of {with_others}.

Commands come from a program outside and arrive at other steps each time. A path that depends on the
step of a command differs from run to run in both simulators.

## Where the packages are from

| package | robot | address | branch or commit | launch file |
| --- | --- | --- | --- | --- |
"""
# Robots that gazebo-comparison.md lists as deviating and that have no recorded path.
OTHERS = (
    *("skid_steer_bot", "multi_robot_scenario", "mp_500", "scout_mini", "my_robot"),
    *("ranger_mini_v3", "mapMyWorld"),
)
TABLE = """
## Each phase

| package | phase | Gazebo: m/s, rad/s | Paddock: m/s, rad/s | alike |
| --- | --- | --- | --- | --- |
"""
FOOT = """
At rest the two numbers are the way [mm] and the yaw rate; the runs of a simulator stand behind each
other.

## What cameras see

A world with a place for each feature of cameras (Gazebo's image on the left):

![Images](images/pictures_beside_gazebo.png)

## Record again

This page and its images are made by `./run exec python bench/paths_beside_gazebo.py` from recorded
paths (`bench/paths/recorded.json`, numbers alone). To record a package again, or another one, run
its launch file in Gazebo and then in Paddock, and beside each
`python3 bench/paths/record.py PLAN.json FOLDER/NAME.gazebo.json` (`.paddock.json`; further runs
`.gazebo.2.json`); its first lines say what PLAN.json has. Then
`bench/paths_beside_gazebo.py --update FOLDER`.
"""


def driven(compared):
    """Verdicts of the driven phases of public packages."""
    public = packages()
    phases = [one for name in compared if name in public for one in compared[name]]
    return [one.verdict for one in phases if one.is_driven]


def counted(compared):
    """Counts driven public phases: alike, total (without varies), varies, files, addresses."""
    verdicts, public = driven(compared), packages()
    moved = [n for n in compared if n in public and any(one.is_driven for one in compared[n])]
    varies = verdicts.count(VARIES)
    return {
        "alike": verdicts.count(ALIKE),
        "total": len(verdicts) - varies,
        "varies": varies,
        "files": len(moved),
        "addresses": len({public[name]["address"] for name in moved}),
    }


def _runs(compared):
    """Says how many runs there are."""
    public = packages()
    found = [one for name, phases in compared.items() if name in public for one in phases]
    numbers = [(len(one.gazebo), len(one.paddock)) for one in found]
    parts = (
        f"{min(each)} to {max(each)}" if min(each) < max(each) else f"{each[0]}"
        for each in zip(*(numbers or [(1, 1)]))
    )
    return "Runs of public packages: {} in Gazebo, {} in Paddock.".format(*parts)


def page(compared):
    """The page's text."""
    numbers = counted(compared)
    text = HEAD.format(**numbers)
    text += "".join(f"| {' | '.join(map(str, row))} |\n" for row in sums(compared))
    text += RULE.format(
        runs=_runs(compared),
        others=", ".join(OTHERS),
        alike=numbers["alike"],
        with_others=numbers["total"] + len(OTHERS),
    )
    for name, row in packages().items():
        address = re.sub("^https://github.com/", "", row["address"])
        text += f"| {name} | {row['robot']} | [{address}]({row['address']}) | "
        text += f"{row['branch']} | `{row['launch']}` |\n"
    text += TABLE
    for name, phases in compared.items():
        for one in phases:
            both = (
                "; ".join(
                    f"{1e3 * run.way:.1f} mm, {run.rate:.3f}"
                    if one.phase in RESTS
                    else f"{run.speed:.3f}, {run.rate:.3f}"
                    for run in runs
                )
                for runs in (one.gazebo, one.paddock)
            )
            text += f"| {name} | {one.phase} | {' | '.join(both)} | {one.verdict} |\n"
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
    draw_all(cases, ROOT / "docs" / "images")
    PAGE.write_text(page(compared), encoding="utf-8")
    print("{alike} of {total} driven phases alike".format(**counted(compared)))
    return 0


if __name__ == "__main__":
    sys.exit(main())

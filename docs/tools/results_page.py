"""Makes docs/results.md of bench/results/*.json, which ./run bench --save writes.

    ./run exec python docs/tools/results_page.py

README.md gets the number of worlds that are as fast as in Gazebo.
The page has a section for each file: what it says in a sentence, how it is measured, a table with
the spread, and a plot where there are many figures of one kind. Paces that were measured while
others used the machine are left out.
"""

from __future__ import annotations

import json
import pathlib
import re
import statistics
import sys
from typing import Callable, Iterable, NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "bench"))

import results  # noqa: E402
from others import SUBJECTS  # noqa: E402
from sections import SECTIONS  # noqa: E402

README, PAGE, IMAGES = ROOT / "README.md", ROOT / "docs" / "results.md", ROOT / "docs" / "images"
PACES = ROOT / "bench" / "worlds" / "gazebo_paces.json"
GAZEBO = "beside Gazebo, "  # before the names of worlds
HEAD = """# Results

Made by `docs/tools/results_page.py` from the files that `./run bench -- --save` writes to
`bench/results/`. A value is the median of its runs, the spread their least and greatest. A ratio
counts against a reference that ran in alternation with it, so it says more than a pace of one
machine. What limits what: [performance](performance.md).
"""
NONE = "\nNo results are recorded for this version yet.\n"
IDLE = 0.1  # processors that others may have beside a measurement
FIRST = ("beside_gazebo", "peers", "learning", "returns")  # then the others in the bench's order
WORDS = {  # in names of figures -> what the page says
    "free, ": "as fast as possible: ",
    "own time, ": "processor time of its stepping thread alone: ",
    "gym, ": "actions, ",
    "p50": "half within",
    "p99": "99 of 100 within",
    "imu": "IMU",
    "pids": "PIDs",
    "khz": "kHz",
    "hz": "Hz",
}
DISTURBED = ("x", "actions/s")  # units of what other processes disturb
ACTIONS = 15.0  # of the gym's car a simulated second


class Told(NamedTuple):
    """What the page says about a section.

    Attributes:
        title: Its heading.
        method: How it is measured, sentences.
        summary: Gives a sentence of its figures, {name: figure}; "" where they lack.
        plot: First words of the names of what is plotted; empty: nothing.
        unit: Of a ratio in the table.
        axis: Of the plot; empty: times the unit's reference.
    """

    title: str
    method: str
    summary: Callable[[dict], str] = lambda figures: ""
    plot: str = ""
    unit: str = "x"
    axis: str = ""


def named(figure: dict) -> str:
    """A figure's name in words."""
    name = figure["name"].strip()
    if name not in SUBJECTS and not any(subject in name for subject in SUBJECTS):
        name = name.replace("_", " ")
    for short, words in WORDS.items():
        end = "(?![a-z])" if short.isalnum() else ""
        name = re.sub(rf"(?<![a-z]){re.escape(short)}{end}", words, name)
    return name


def usable(found: dict) -> list[dict]:
    """The figures of a section without paces that were disturbed."""
    busy = found["others"] > IDLE
    return [each for each in found["figures"] if not (busy and each["unit"] in DISTURBED)]


def number(value: float) -> str:
    """A figure with three digits that count, without an exponent."""
    digits = 0 if abs(value) >= 100 else 1 if abs(value) >= 10 else 2 if abs(value) >= 1 else 3
    return f"{value:.{digits}f}"


def value_of(figures: dict, name: str) -> str:
    """A figure's value and unit as text; "" where it lacks."""
    if name not in figures:
        return ""
    return f"{number(figures[name]['value'])} {figures[name]['unit']}".rstrip()


def told_if(text: str, *names: str) -> Callable[[dict], str]:
    """A sentence with values in the places of {}; "" where one of them lacks."""

    def summary(figures: dict) -> str:
        values = [value_of(figures, name) for name in names]
        return text.format(*values) if all(values) else ""

    return summary


def beside_gazebo(figures: dict) -> str:
    """In how many worlds Paddock is as fast as Gazebo."""
    times = all_times_gazebo(figures.values())
    if not times:
        return ""
    return (
        f"Paddock is at least as fast as Gazebo in {as_fast(times)} worlds: "
        f"{number(min(times))} to {number(max(times))} times its pace, "
        f"{number(statistics.median(times))} in the median."
    )


def gym_and_ros(figures: dict) -> str:
    """How far laps over ROS are from those in the gym, at most."""
    more = [figure for name, figure in figures.items() if "over ROS longer" in name]
    if not more:
        return ""
    most = max(abs(value) for each in more for value in each["spread"] or (each["value"],))
    seen = ", ".join(f"`{each['name'].split(',')[0]}`" for each in more)
    return f"Over ROS a lap takes as long as in the gym within {number(most)} %: {seen}."


def all_times_gazebo(figures: Iterable[dict]) -> list[float]:
    """Paddock's pace over Gazebo's in the worlds where that was recorded."""
    return [quotient[0] for quotient in map(times_gazebo, figures) if quotient]


def as_fast(times: list[float]) -> str:
    """How many of some worlds have Gazebo's pace or more: "8 of 9"."""
    return f"{sum(value >= 1.0 for value in times)} of {len(times)}"


def times_gazebo(figure: dict) -> tuple[float, float, float] | None:
    """Paddock's pace over Gazebo's in a world: value, least, greatest; None: not recorded."""
    worlds = json.loads(PACES.read_text(encoding="utf-8"))["worlds"]
    its = worlds.get(figure["name"][len(GAZEBO) :])
    if its is None or not figure["name"].startswith(GAZEBO):
        return None
    least, greatest = figure["spread"] or (figure["value"],) * 2
    theirs = its["ratio"]["median"]
    return figure["value"] / theirs, least / theirs, greatest / theirs


def peers(figures: dict) -> str:
    """Paddock beside other gyms, and its actions a second."""
    compared = told_if(
        "With `state` Paddock makes {} times MuJoCo's car seconds a second of processor time, "
        "with a lidar {} times f1tenth_gym's and {} times racecar_gym's.",
        "paddock_state_1 over mujoco_1",
        "paddock_lidar_1 over f1tenth_1",
        "paddock_lidar_1 over racecar_1",
    )(figures)
    if not compared or "paddock_state_1" not in figures:
        return compared
    actions = ACTIONS * figures["paddock_state_1"]["value"]
    return f"{compared} With `state` that is {number(actions)} actions a second of a core."


TOLD = {
    "start": Told(
        "Start",
        "Wall time from `roslaunch` to the first message of each kind; files are in the cache.",
        told_if("All controllers of the car run {} after `roslaunch`.", "start to 7 controllers"),
    ),
    "efficiency": Told(
        "Efficiency of the node",
        "The node as fast as possible, over PyBullet's bare stepping of the same scene, in pairs. "
        "Own time counts the processor time of the stepping thread alone.",
        told_if("As launched the node has {} of bare stepping's pace.", "free, as_launched"),
    ),
    "driving": Told(
        "Driving in real time",
        "The car drives a circle with its camera on. `/clock` is late by what a subscriber in "
        "another process measures.",
        told_if("The real-time factor with camera is {}.", "real-time factor"),
    ),
    "camera": Told(
        "Images",
        "Images a second of the bare renderer, and as a subscriber receives them, over PyBullet's "
        "EGL renderer, in pairs. Without a GPU both are Mesa's software.",
        told_if(
            "At 640x480 pixels the renderer has {} times the pace of PyBullet's, a subscriber {}.",
            "images, plain 640x480",
            "images, received 640x480",
        ),
        "images, ",
        axis="images a second, times PyBullet's",
    ),
    "latency": Told(
        "Latency",
        "Wall time from a command to the joint states that show it, in real time. Joint states "
        "follow within their period.",
        told_if("Half of the commands to a hinge show within {}.", "latency hinge_camera, p50"),
    ),
    "navigation": Told(
        "Mapping and navigating",
        "At real time: the robot alone, then with gmapping, or with amcl and move_base. What it "
        "has needs `./run add navigation gmapping turtlebot3`.",
        told_if("TurtleBot3 maps at {} of real time.", "real-time factor, turtlebot3_maps"),
    ),
    "scale": Told(
        "Many cars",
        "Cars with a lidar of 360 rays each in one world, as fast as possible. Cars times pace "
        "counts against bare stepping of one car; equal ratios mean equal cost for each car.",
        told_if("A further car takes {} of memory.", "memory per car"),
        "cars x pace, ",
        axis="cars times pace, times one car's bare stepping",
    ),
    "learning": Told(
        "Learning",
        "Actions a second of the environments in one process, over bare stepping of the same car "
        "on the same circle, in pairs; eight worlds in one process over one environment. "
        "Trainings: seconds until ten of ten unseen starts are laps, evaluation included.",
        told_if(
            "With `state` eight worlds in one process make {} times the actions of one.",
            "gym, state, 8 worlds",
        ),
        "gym, ",
        axis="actions a second, times bare stepping, or one process",
    ),
    "actions": Told(
        "Actions a second",
        "`Paddock/Robot-v0` with the cart of the examples and `Paddock/DeepRacer-v1` by a constant "
        "action, one environment and eight side by side in threads: of wall time, and of a core, "
        "which is a second of processor time of all threads.",
        told_if(
            "By lidar `Robot-v0` takes {} in one world, {} in eight; by camera `DeepRacer-v1` {} "
            "and {}.",
            "Robot-v0, lidar of 24 rays, 1 world",
            "Robot-v0, lidar of 24 rays, 8 worlds",
            "DeepRacer-v1, camera of 160x120, 1 world",
            "DeepRacer-v1, camera of 160x120, 8 worlds",
        ),
    ),
    "returns": Told(
        "Returns",
        "`Paddock/DeepRacer-v1` as it is made by default, from 20 unseen starts each: actions by "
        "chance, pure pursuit at up to 1 and 2 m/s (from the true pose), and `./run train first` "
        "of five seeds, whose rows have the means of each seed. The reward is the way along the "
        "center line [m], and -3 for an end before the lap.",
        told_if(
            "By chance a run returns {}; pure pursuit at 2 m/s {} in {}, a policy that has learned "
            "from {} {} in {}.",
            "random, return",
            "fast_pursuit, return",
            "fast_pursuit, length",
            "trained, actions learned from",
            "trained, return",
            "trained, length",
        ),
    ),
    "gym_gap": Told(
        "Gym and ROS",
        "A lap from line to line after a standing start by the same policy, as `./run train` makes "
        "it, in the gym and over ROS: simulated time, at half of real time, with images a fifth.",
        gym_and_ros,
    ),
    "peers": Told(
        "Beside other gyms",
        "Each simulator drives cars round a circle by its own API, in rounds that alternate: "
        "simulated seconds, times cars, a second of processor time of all its threads. They "
        "simulate and return different things, as the table says. Ratios are of those that "
        "observe alike.",
        peers,
    ),
    "gym_steps": Told(
        "Physics steps of the gym",
        "The car with steps of 0.5 to 4 ms: steady circles, a slalom, a minute at rest, a lap by "
        "pure pursuit at 2 m/s from line to line; actions a second of processor time over those "
        "with 1 ms, in pairs.",
        told_if(
            "With 3 ms the slalom is {}, at {} times the pace; where tires slide, a circle of {} "
            "has {} with 2 ms.",
            "3 ms, slalom",
            "3 ms, pace",
            "1 ms, circle, tires sliding, radius",
            "2 ms, circle, tires sliding, radius",
        ),
    ),
    "solver": Told(
        "Solver",
        "Steps a second of the solver `ode` over those of `bullet` in the same scene, without "
        "ROS, in pairs. `ode` does Gazebo's work in each step, `bullet` less.",
        told_if(
            "`ode` makes {} times the steps of `bullet` with a car, {} times with 40 cans awake.",
            "ode, steps, a car",
            "ode, steps, a car, 40 cans awake",
        ),
        "ode, ",
        axis="steps a second of `ode`, times those of `bullet`",
    ),
    "beside_gazebo": Told(
        "Beside Gazebo",
        "Worlds with one cause of slowness each, as fast as possible. Both simulators are counted "
        "against the same bare stepping on their machine; the quotient of both is how many times "
        "Gazebo's pace Paddock reaches.",
        beside_gazebo,
        GAZEBO,
        "x bare stepping",
    ),
}


def row(figure: dict, unit: str) -> str:
    """A line of the table; worlds beside Gazebo have one column more."""
    spread = "" if figure["spread"] is None else " to ".join(map(number, figure["spread"]))
    value = f"{number(figure['value'])} {figure['unit'] or unit}".rstrip()
    name = named(figure)
    if name in SUBJECTS:
        name += f": {SUBJECTS[name][1]}"
    text = f"| {name} | {value} | {spread} | {figure['runs']} |"
    times = times_gazebo(figure)
    return text if times is None else f"{text} {number(times[0])} |"


def picture(name: str) -> str:
    """The file name of a section's plot."""
    return f"results_{name}.png"


def section(found: dict) -> str:
    """The text of a section.

    Args:
        found: A document of bench/results.py.
    """
    told, machine, figures = TOLD[found["name"]], found["machine"], usable(found)
    summary = told.summary({figure["name"]: figure for figure in figures})
    busy = ""
    if len(figures) < len(found["figures"]):
        busy = " Its paces were disturbed by other processes and are left out."
    text = f"\n## {told.title}\n\n" + (f"**{summary}** " if summary else "")
    text += (
        f"{told.method}\n\n*{machine['processor']}, {machine['cores']} cores, Python "
        f"{machine['python']}; commit {found['commit']}, {found['date'][:10]}.{busy}*\n\n"
    )
    if plotted(found):
        text += f"![{told.title}](images/{picture(found['name'])})\n\n"
    gazebo = any(map(times_gazebo, figures))
    text += f"| | value | spread | runs |{' times Gazebo |' if gazebo else ''}\n"
    text += "| --- |" + " --- |" * (4 if gazebo else 3) + "\n"
    return text + "".join(f"{row(figure, told.unit)}\n" for figure in figures)


def plotted(found: dict) -> list[dict]:
    """The figures of a section's plot."""
    first = TOLD[found["name"]].plot
    return [each for each in usable(found) if first and each["name"].startswith(first)]


def documents(folder: pathlib.Path) -> list[dict]:
    """The results that a folder has: FIRST, then the others in the bench's order."""
    names = [*FIRST, *(name for name in SECTIONS if name not in FIRST)]
    files = [folder / f"{name}.json" for name in names]
    return [results.check(path.read_text(encoding="utf-8")) for path in files if path.is_file()]


def page(folder: pathlib.Path = results.FOLDER) -> str:
    """The page's text.

    Args:
        folder: With files as bench/results.py writes them.
    """
    return HEAD + ("".join(map(section, documents(folder))) or NONE)


def readme(folder: pathlib.Path = results.FOLDER) -> str:
    """README.md with the number of worlds beside Gazebo that `page()` tells."""
    text = README.read_text(encoding="utf-8")
    for found in documents(folder):
        if found["name"] == "beside_gazebo":
            fast = as_fast(all_times_gazebo(found["figures"]))
            text = re.sub(r"\d+ of \d+(?= worlds of the bench)", fast, text)
    return text


def draw(found: dict, path: pathlib.Path) -> None:
    """Draws the figures of one kind of a section as bars with their spread.

    Args:
        found: A document of bench/results.py.
        path: Of the picture.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot, ticker

    told = TOLD[found["name"]]
    shown = plotted(found)[::-1]
    names = [named({"name": each["name"][len(told.plot) :]}) for each in shown]
    bars, of = [], told.axis or told.unit
    for each in shown:
        least, greatest = each["spread"] or (each["value"],) * 2
        bars.append(times_gazebo(each) or (each["value"], least, greatest))
    if any(map(times_gazebo, shown)):
        of = "times Gazebo's pace"
    figure, axes = pyplot.subplots(figsize=(9.0, 0.8 + 0.3 * len(shown)))
    errors = ([a - b for a, b, _ in bars], [c - a for a, _, c in bars])
    colors = ["#2f6f8f" if value >= 1.0 else "#b3541e" for value, *_ in bars]
    axes.barh(names, [value for value, *_ in bars], xerr=errors, color=colors, capsize=2)
    axes.axvline(1.0, color="black", linewidth=0.8)
    axes.set(xscale="log", xlabel=of)
    axes.xaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    axes.xaxis.set_minor_formatter(ticker.NullFormatter())
    axes.grid(axis="x", alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    pyplot.close(figure)


def main() -> None:
    """Writes the page and its plots; plots of sections that are gone go, too."""
    for old in IMAGES.glob(picture("*")):
        old.unlink()
    for found in documents(results.FOLDER):
        if plotted(found):
            draw(found, IMAGES / picture(found["name"]))
    PAGE.write_text(page(), encoding="utf-8")
    README.write_text(readme(), encoding="utf-8")
    print(PAGE)


if __name__ == "__main__":
    main()

"""Worlds with one cause of slowness each, over bare stepping, beside Gazebo's recorded figures.

Gazebo's were taken by pace_beside_gazebo.py in the same worlds, over the same bare stepping of its
machine, so that a quotient of both ratios says how many times Gazebo's pace is reached. Where a
camera is subscribed Gazebo drops images; so images per wall second are told, too.
"""

import json
import pathlib
import statistics
import tempfile

from figures import BenchError, Spread
from launching import Launch
from pairs import Round, alternate, matched, pairs_of
from report import Row
from worlds import causes

RECORD = pathlib.Path(__file__).resolve().parent.parent / "worlds" / "gazebo_paces.json"
SLOW = 0.5  # of the commanded speed: a robot that is slower does not do the same work


def measure(quick, log):
    """Each world in a launch of its own, in alternation with the bare car."""
    figures, errors = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for name in causes.CAUSES:
            file = causes.write(folder, name)
            launched = ("gazebo_ros", "empty_world.launch")
            arguments = [f"world_name:={file}", "gui:=false"]
            try:
                with Launch(log, arguments, launched) as launch:
                    observer = launch.observer("paces.world", name)
                    figures[name] = measure_world(observer, 1.5 if quick else 2.5, pairs_of(quick))
            except BenchError as error:
                errors[name] = str(error)
    return dict(figures, errors=errors)


def measure_world(observer, seconds, pairs):
    """Figures of a world that runs.

    Args:
        observer: Observer of paces.world.
        seconds: of a round, wall time.

    Raises:
        BenchError: the robot does not drive, or nothing comes on a topic.
    """
    observer.answer()

    def one_round(kind):
        answer = observer.ask(f"{kind} {seconds}")
        return Round(answer["pace"], answer)

    measured = alternate(lambda: one_round("bare"), {"world": lambda: one_round("world")}, pairs)
    rounds = measured["world"]
    found = [one.details for one in rounds.variant]
    speed = statistics.median(one["speed"] for one in found)
    if not speed > SLOW * causes.SPEED:
        raise BenchError(
            f"the robot drives at {speed:.3f} m/s, commanded are {causes.SPEED:.3f} m/s"
        )
    return {**rounds.figures(), "speed_m_s": speed, "messages_over_bare": _messages(rounds)}


def _messages(rounds):
    """Median of messages per wall second over the bare car's pace, of each topic."""
    found = {}
    for topic in rounds.variant[0].details["received"]:
        ratios = [
            mine.details["received"][topic] / its.value
            for its, mine in matched(rounds.reference, rounds.variant)
        ]
        found[topic] = statistics.median(ratios)
        if not found[topic]:
            raise BenchError(f"nothing came on {topic}")
    return found


def recorded():
    """Gazebo's figures: name of a world -> as measure_world gives them."""
    return json.loads(RECORD.read_text(encoding="utf-8"))["worlds"]


def rows(figures):
    """Over bare stepping, and how many times Gazebo's figure that is."""
    theirs = recorded()
    for name, row in figures.items():
        ratio = Spread.read(row["ratio"])
        text = f"{causes.CAUSES[name].text}: {ratio.text()} of bare stepping"
        if name in theirs:
            its = Spread.read(theirs[name]["ratio"])
            text += f"; in Gazebo {its.text()}: {ratio.median / its.median:.1f} times its pace"
            pictures = causes.CAUSES[name].pictures
            if pictures:
                mine, other = (
                    sum(one["messages_over_bare"][topic] for topic in pictures)
                    for one in (row, theirs[name])
                )
                text += f", {mine / other:.1f} times its images per second"
        yield Row(f"beside Gazebo, {name}", text, ratio)

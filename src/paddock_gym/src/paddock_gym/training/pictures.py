"""Pictures of a training: learning curve, where the runs ended."""

import csv
import os

import matplotlib
import numpy as np

matplotlib.use("Agg")

from matplotlib import pyplot  # noqa: E402

from paddock_gym.course.judge import LAP  # noqa: E402
from paddock_gym.evaluation.plots import draw_ground  # noqa: E402
from paddock_gym.training.watch import EPISODES, RECENT  # noqa: E402


def episodes(folder):
    """Rows of a training's log of runs: dicts of text."""
    with open(os.path.join(folder, EPISODES), newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def learning_curve(rows, path, good=LAP, word="laps"):
    """Draw progress, laps or other successes and their times over the steps.

    Args:
        rows: of episodes().
        path: of the PNG.
        good: end of a run that made it.
        word: for several of those.
    """
    steps = np.array([float(row["step"]) for row in rows])
    progress = np.array([float(row["progress"]) for row in rows])
    laps = np.array([row["end"] == good for row in rows])
    times = np.array([float(row["time"]) for row in rows])
    figure, (upper, lower) = pyplot.subplots(2, 1, sharex=True, figsize=(9, 6), dpi=110)
    upper.plot(steps, progress, ".", color="0.8", markersize=3, label="progress of a run [%]")
    if len(rows) >= RECENT:
        window = np.ones(RECENT) / RECENT
        upper.plot(
            steps[RECENT - 1 :],
            np.convolve(progress, window, "valid"),
            label=f"mean of {RECENT} runs",
        )
        upper.plot(
            steps[RECENT - 1 :],
            100.0 * np.convolve(laps, window, "valid"),
            label=f"{word} among them [%]",
        )
    upper.set_ylim(0, 102)
    upper.legend(loc="lower right")
    lower.plot(steps[laps], times[laps], ".", markersize=3)
    lower.set(xlabel="steps", ylabel=f"time of {word} [s]")
    figure.tight_layout()
    figure.savefig(path)
    pyplot.close(figure)


def heat_map(rows, track, path):
    """Draw where the runs ended before their lap, over the track; late ones are darker.

    Args:
        rows: of episodes().
        track: track_model.track.Track.
        path: of the PNG.
    """
    places = np.array(
        [(float(row["x"]), float(row["y"])) for row in rows if row["end"] != LAP]
    ).reshape(-1, 2)
    figure, axes = pyplot.subplots(figsize=(9, 6.5), dpi=110)
    draw_ground(axes, track)
    drawn = axes.scatter(
        places[:, 0], places[:, 1], c=np.arange(len(places)), cmap="autumn_r", s=14, zorder=3
    )
    if len(places):
        figure.colorbar(drawn, ax=axes, label="number of the run that ended there")
    axes.set_title(f"{len(places)} of {len(rows)} runs ended before their lap")
    figure.tight_layout()
    figure.savefig(path)
    pyplot.close(figure)

"""Monitors a training: log, plots."""

import csv
import os
import time
from collections import deque

import numpy as np
from matplotlib import pyplot
from stable_baselines3.common.callbacks import BaseCallback
from track_model.plots import draw_ground

from paddock_gym.course import LAP
from paddock_gym.errors import RewardError
from paddock_gym.evaluation import plots
from paddock_gym.training.checkpoint import FILE, save
from paddock_gym.training.examination import all_laps
from paddock_gym.training.worker import LOGGED_KEYS, LOST

RECENT = 40  # runs of a success rate
PROMISING = 1  # laps among them before the policy is examined
PRINT_PERIOD = 5.0  # [s] of wall time
CHECKPOINT_PERIOD = 30.0  # [s] of wall time
EPISODES, BEST = "episodes.csv", "best.npz"
COLUMNS = ("step", "wall_time", "reward", "length", *LOGGED_KEYS)


class TrainingMonitor(BaseCallback):
    """Logs a training and saves its checkpoints.

    Args:
        steps: at which it stops.
        log: function of one line.
        stop: function without arguments: whether a stop was requested.
        good: end of a successful run.
        noun: for several of those.
        examined: whether the training ends as soon as the policy makes laps from all unseen starts.

    Attributes:
        passed: whether it did.
        best: (laps or arrivals, -their mean time) of the best RECENT runs so far.
    """

    def __init__(self, folder, steps, log=print, stop=lambda: False, good=LAP, noun="laps",
                 examined=False):  # fmt: skip
        super().__init__()
        self._good, self._noun = good, noun
        self._steps, self._log, self._stop = steps, log, stop
        self._recent, self.best = deque(maxlen=RECENT), (0, 0.0)
        self._examined, self._next, self.passed = examined, 0, False
        self._path, self._best, self._checkpoint = (
            os.path.join(folder, name) for name in (EPISODES, BEST, FILE)
        )

    def _on_training_start(self):
        self._started_at = self._printed = self._saved = time.monotonic()
        self._first, self._logged = self.num_timesteps, False
        new = not os.path.exists(self._path)
        self._stream = open(self._path, "a", newline="", encoding="utf-8")
        self._writer = csv.writer(self._stream)
        if new:
            self._writer.writerow(COLUMNS)

    def _on_step(self):
        for info in self.locals["infos"]:
            if "error" in info:
                raise RewardError(info["error"])
            if info.get("end") == LOST:
                self._log("train: a worker died and was replaced; its run is lost")
            elif "episode" in info:
                self._record(info)
        now = time.monotonic()
        if now - self._printed > PRINT_PERIOD:
            self._log_line()
        return not (self.passed or self._stop())

    def _on_rollout_start(self):
        if not self._examined or self.score()[0] < PROMISING or self.num_timesteps < self._next:
            return
        model = self.model
        self.passed, taken = all_laps(model, model.env, self._stop)
        self._next = self.num_timesteps + taken  # training has at least half of the actions
        if self.passed:
            self._log(f"train: laps from all unseen starts after {self.num_timesteps} steps")
            if os.path.exists(self._best):
                os.remove(self._best)  # what has passed is to be kept
        model._last_obs = model.env.reset()  # stable-baselines3 has no other way to start runs anew
        model._last_episode_starts[:] = True

    def _log_line(self):
        self._printed, self._logged = time.monotonic(), True
        self._log(self.line())

    def _record(self, info):
        self._recent.append((info["end"], info["time"]))
        row = (info["episode"]["r"], info["episode"]["l"], *(info[key] for key in LOGGED_KEYS))
        wall = time.monotonic() - self._started_at
        self._writer.writerow([self.num_timesteps, f"{wall:.1f}", *row])

    def _on_rollout_end(self):
        self._stream.flush()
        if not self._logged:
            self._log_line()
        score = self.score()
        if len(self._recent) == RECENT and score > self.best:
            self.best = score
            save(self.model, self._best)
        if time.monotonic() - self._saved > CHECKPOINT_PERIOD:
            self._saved = time.monotonic()
            save(self.model, self._checkpoint)

    def _on_training_end(self):
        self._stream.close()

    def score(self):
        """(laps or arrivals, -their mean time) of the last RECENT runs."""
        laps = [seconds for end, seconds in self._recent if end == self._good]
        return len(laps), -sum(laps) / len(laps) if laps else 0.0

    def line(self):
        """One line of progress."""
        seconds = time.monotonic() - self._started_at
        rate = (self.num_timesteps - self._first) / max(seconds, 1e-3)
        left = max(0, self._steps - self.num_timesteps) / max(rate, 1e-3)
        laps, mean = self.score()
        text = f"{laps} {self._noun} in the last {len(self._recent)} runs"
        if laps:
            text += f" ({-mean:.1f} s)"
        return (
            f"train: {self.num_timesteps} of {self._steps} steps, {rate:.0f} a second, {text}, "
            f"{left // 60:.0f} min {left % 60:.0f} s left"
        )


def episodes(folder):
    """Rows of a training's log of runs: dicts of text."""
    with open(os.path.join(folder, EPISODES), newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def learning_curve(rows, path, good=LAP, noun="laps"):
    """Plot progress, laps or other successes and their times over the steps.

    Args:
        rows: of episodes().
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
            label=f"{noun} among them [%]",
        )
    upper.set_ylim(0, 102)
    upper.legend(loc="lower right")
    lower.plot(steps[laps], times[laps], ".", markersize=3)
    lower.set(xlabel="steps", ylabel=f"time of {noun} [s]")
    plots.write(figure, path)


def heat_map(rows, track, path):
    """Plot where the runs ended before their lap, over the track; late ones are darker.

    Args:
        rows: of episodes().
    """
    positions = np.array(
        [(float(row["x"]), float(row["y"])) for row in rows if row["end"] != LAP]
    ).reshape(-1, 2)
    figure, axes = pyplot.subplots(figsize=(9, 6.5), dpi=110)
    draw_ground(axes, track)
    points = axes.scatter(
        positions[:, 0],
        positions[:, 1],
        c=np.arange(len(positions)),
        cmap="autumn_r",
        s=14,
        zorder=3,
    )
    if len(positions):
        figure.colorbar(points, ax=axes, label="number of the run that ended there")
    axes.set_title(f"{len(positions)} of {len(rows)} runs ended before their lap")
    plots.write(figure, path)

"""What happens along a training: log, progress line, checkpoints, the best policy so far."""

import csv
import os
import time
from collections import deque

from stable_baselines3.common.callbacks import BaseCallback

from paddock_gym.course.judge import LAP
from paddock_gym.errors import RewardError
from paddock_gym.training.checkpoint import save
from paddock_gym.training.worker import KEPT, LOST

RECENT = 40  # runs of a success rate
PRINT_PERIOD = 5.0  # [s] of wall time
CHECKPOINT_PERIOD = 30.0  # [s] of wall time
EPISODES = "episodes.csv"
COLUMNS = ("step", "wall_time", "reward", "length", *KEPT)


class Watch(BaseCallback):
    """Watches a training.

    Args:
        folder: of the training.
        steps: at which it ends.
        say: function of one line.
        stop: function without arguments: whether the user asked to stop.
        good: end of a run that made it.
        word: for several of those.

    Attributes:
        best: (laps or arrivals, -their mean time) of the best RECENT runs so far.
    """

    def __init__(self, folder, steps, say=print, stop=lambda: False, good=LAP, word="laps"):
        super().__init__()
        self._good, self._word = good, word
        self._folder, self._steps, self._say, self._stop = folder, steps, say, stop
        self._recent, self.best = deque(maxlen=RECENT), (0, 0.0)
        self._path = os.path.join(folder, EPISODES)

    def _on_training_start(self):
        self._begin = self._printed = self._saved = time.monotonic()
        self._first, self._told = self.num_timesteps, False
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
                self._say("train: a worker died and was replaced; its run is lost")
            elif "episode" in info:
                self._note(info)
        now = time.monotonic()
        if now - self._printed > PRINT_PERIOD:
            self._tell()
        return not self._stop()

    def _tell(self):
        self._printed, self._told = time.monotonic(), True
        self._say(self.line())

    def _note(self, info):
        self._recent.append((info["end"], info["time"]))
        row = (info["episode"]["r"], info["episode"]["l"], *(info[key] for key in KEPT))
        wall = time.monotonic() - self._begin
        self._writer.writerow([self.num_timesteps, f"{wall:.1f}", *row])

    def _on_rollout_end(self):
        self._stream.flush()
        if not self._told:
            self._tell()
        score = self.score()
        if len(self._recent) == RECENT and score > self.best:
            self.best = score
            self.model.save(os.path.join(self._folder, "best.zip"))
        if time.monotonic() - self._saved > CHECKPOINT_PERIOD:
            self._saved = time.monotonic()
            save(self.model, self._folder)

    def _on_training_end(self):
        self._stream.close()

    def score(self):
        """(laps or arrivals, -their mean time) of the last RECENT runs."""
        laps = [seconds for end, seconds in self._recent if end == self._good]
        return len(laps), -sum(laps) / len(laps) if laps else 0.0

    def line(self):
        """One line about how far it is."""
        seconds = time.monotonic() - self._begin
        rate = (self.num_timesteps - self._first) / max(seconds, 1e-3)
        left = max(0, self._steps - self.num_timesteps) / max(rate, 1e-3)
        laps, mean = self.score()
        words = f"{laps} {self._word} in the last {len(self._recent)} runs"
        if laps:
            words += f" ({-mean:.1f} s)"
        return (
            f"train: {self.num_timesteps} of {self._steps} steps, {rate:.0f} a second, {words}, "
            f"{left // 60:.0f} min {left % 60:.0f} s left"
        )

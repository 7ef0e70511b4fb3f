"""Results of a run: recorded paths, their plots, result files."""

import csv
import json
import math
import os
import threading
from dataclasses import dataclass

import cv2
import numpy as np
from matplotlib.figure import Figure
from paddock_common.geometry import yaw_of
from track_model.plots import draw_ground


@dataclass(frozen=True)
class Sample:
    """One odometry message: time [s], position in the world [m], unwrapped heading [rad],
    forward speed [m/s] and yaw rate [rad/s] in the car's frame, name of the manoeuvre."""

    t: float
    x: float
    y: float
    yaw: float
    v: float
    yaw_rate: float
    phase: str


def along(start, end):
    """Returns the distance from start along the heading of start [m]."""
    return (end.x - start.x) * math.cos(start.yaw) + (end.y - start.y) * math.sin(start.yaw)


class Recorder:
    """Collects samples; the callback may come from another thread."""

    def __init__(self):
        self._lock = threading.Lock()
        self._samples = []
        self.phase = ""

    def callback(self, message):
        """Records a nav_msgs/Odometry with its twist in the child frame."""
        pose, twist = message.pose.pose, message.twist.twist
        yaw = yaw_of(pose.orientation)
        with self._lock:
            if self._samples:  # unwrapped: nearest to the last heading
                last = self._samples[-1].yaw
                yaw += 2.0 * math.pi * round((last - yaw) / (2.0 * math.pi))
            self._samples.append(
                Sample(
                    message.header.stamp.to_sec(),
                    pose.position.x,
                    pose.position.y,
                    yaw,
                    twist.linear.x,
                    twist.angular.z,
                    self.phase,
                )
            )

    @property
    def samples(self):
        """All samples so far, oldest first."""
        with self._lock:
            return list(self._samples)

    @property
    def last(self):
        """The newest sample, or None."""
        with self._lock:
            return self._samples[-1] if self._samples else None

    def since(self, t):
        """Returns the samples from ROS time t [s] on."""
        return [sample for sample in self.samples if sample.t >= t]

    def write_csv(self, path):
        """Writes t [s], x, y [m], yaw [rad], v [m/s] of every sample."""
        with open(path, "w", newline="", encoding="ascii") as stream:
            writer = csv.writer(stream)
            writer.writerow(["t", "x", "y", "yaw", "v"])
            rows = ((s.t, s.x, s.y, s.yaw, s.v) for s in self.samples)
            writer.writerows([f"{value:.6f}" for value in row] for row in rows)


COLORS = ("#28a0ff", "#ff5050")  # buttons, cruise


def path_figure(track, samples, names=("buttons", "cruise + slider")):
    """Returns a matplotlib Figure of track, path, start and end, axes in meters.

    Args:
        track: track_model.track.Track.
        samples: Recorder samples, at least one; phases that start with "cruise" get a second
            color.
        names: Labels of the path's colors; with one label the path has one color.
    """
    left, right, low, high = track.extent
    size = 12.0, 12.0 * (high - low) / (right - left) + 1.0
    figure = Figure(figsize=size, constrained_layout=True)
    axes = figure.subplots()
    draw_ground(axes, track)
    places = np.array([(sample.x, sample.y) for sample in samples])
    second = np.array([len(names) > 1 and sample.phase.startswith("cruise") for sample in samples])
    for name, color, of_color in zip(names, COLORS, (~second, second)):
        shown = of_color | np.append(of_color[1:], False)  # from the sample before
        line = np.where(shown[:, None], places, np.nan)
        axes.plot(*line.T, color=color, linewidth=3.0, label=name)
    yaw = samples[0].yaw
    arrow = (*places[0], np.cos(yaw), np.sin(yaw))
    axes.quiver(*arrow, color="#40c040", scale=25.0, width=0.006, zorder=3, label="start")
    axes.plot(*places[-1], "o", color="white", markeredgecolor="black", zorder=3, label="end")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.08), ncol=4)
    return figure


RESULT = "result.json"


def prepare(folder, files):
    """Creates the folder and removes the files of an earlier run.

    Args:
        files: Names of the run's files; result.json is always one of them.

    Raises:
        OSError: The folder cannot be created or written.
    """
    os.makedirs(folder, exist_ok=True)
    for name in (*files, RESULT):
        if os.path.exists(os.path.join(folder, name)):
            os.remove(os.path.join(folder, name))


def write_image(folder, name, image):
    """Writes an image.

    Args:
        folder, name: Folder and file name.
        image: (H, W, 3) uint8 BGR, or None for a missing one.

    Raises:
        OSError: It is None or cannot be written.
    """
    path = os.path.join(folder, name)
    if image is None or not cv2.imwrite(path, image):
        raise OSError(f"cannot write {path}")


def write_result(folder, result):
    """Writes a dict as result.json."""
    with open(os.path.join(folder, RESULT), "w", encoding="utf-8") as stream:
        json.dump(result, stream, indent=2)
        stream.write("\n")

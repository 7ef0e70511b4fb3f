"""Results of a run: recorded paths, views from above, result files."""

import csv
import json
import math
import os
import threading
from dataclasses import dataclass

import cv2
import numpy as np
from paddock_common.geometry import yaw_of


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
            for sample in self.samples:
                writer.writerow(
                    [
                        f"{value:.6f}"
                        for value in (sample.t, sample.x, sample.y, sample.yaw, sample.v)
                    ]
                )


MARGIN = 70  # around the track, for the axes [px]
COLORS = ((255, 160, 40), (80, 80, 255))  # BGR: buttons, cruise
FONT = cv2.FONT_HERSHEY_SIMPLEX


class View:
    """Maps meters to pixels: x to the right, y upwards."""

    def __init__(self, extent, width=1200):
        """Fits an extent (xmin, xmax, ymin, ymax) [m] into a width [px]."""
        self.xmin, self.xmax, self.ymin, self.ymax = extent
        self.scale = (width - 2 * MARGIN) / (self.xmax - self.xmin)
        self.shape = (round((self.ymax - self.ymin) * self.scale) + 2 * MARGIN, width, 3)

    def pixels(self, points):
        """Returns (N, 2) int32 pixels of (N, 2) meters."""
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        return np.round(
            np.column_stack(
                [
                    MARGIN + (points[:, 0] - self.xmin) * self.scale,
                    MARGIN + (self.ymax - points[:, 1]) * self.scale,
                ]
            )
        ).astype(np.int32)


def render(track, samples, width=1200, names=("buttons", "cruise + slider")):
    """Renders track, path, start, axes in meters and a scale bar.

    Args:
        track: track_model.track.Track: centreline, inner, outer, extent and texture.
        samples: Recorder samples, at least one; phases that start with "cruise" get a second
            color.
        width: Width of the image [px].
        names: Labels of the path's colors; with one label the path has one color.

    Returns:
        (H, W, 3) uint8 BGR.
    """
    view = View(track.extent, width)
    image = np.full(view.shape, 250, np.uint8)
    _draw_ground(image, view, track)
    _draw_axes(image, view)
    points = view.pixels([(sample.x, sample.y) for sample in samples])
    for first, second, sample in zip(points[:-1], points[1:], samples[1:]):
        color = COLORS[len(names) > 1 and sample.phase.startswith("cruise")]
        cv2.line(image, tuple(map(int, first)), tuple(map(int, second)), color, 3, cv2.LINE_AA)
    _draw_ends(image, view, samples)
    _draw_legend(image, view, names)
    return image


def _draw_ground(image, view, track):
    (left, top), (right, bottom) = view.pixels([(view.xmin, view.ymax), (view.xmax, view.ymin)])
    texture = cv2.imread(track.texture)
    if texture is not None:
        image[top:bottom, left:right] = cv2.resize(
            texture, (right - left, bottom - top), interpolation=cv2.INTER_AREA
        )
        return
    for line, color in (
        (track.outer, (90, 90, 90)),
        (track.inner, (90, 90, 90)),
        (track.centreline, (20, 140, 245)),
    ):
        cv2.polylines(image, [view.pixels(line)], True, color, 2, cv2.LINE_AA)


def _draw_axes(image, view):
    (left, top), (right, bottom) = view.pixels([(view.xmin, view.ymax), (view.xmax, view.ymin)])
    cv2.rectangle(image, (int(left), int(top)), (int(right), int(bottom)), (60, 60, 60), 1)
    for meter in range(int(np.ceil(view.xmin)), int(view.xmax) + 1):
        x = int(view.pixels([(meter, 0)])[0, 0])
        cv2.line(image, (x, bottom), (x, bottom + 6), (60, 60, 60), 1)
        _write(image, f"{meter}", (x, bottom + 22), centered=True)
    for meter in range(int(np.ceil(view.ymin)), int(view.ymax) + 1):
        y = int(view.pixels([(0, meter)])[0, 1])
        cv2.line(image, (left - 6, y), (left, y), (60, 60, 60), 1)
        _write(image, f"{meter}", (left - 22, y + 5), centered=True)
    _write(image, "x [m]", ((left + right) // 2, bottom + 46), centered=True)
    _write(image, "y [m]", (left - 40, top - 14))


def _draw_ends(image, view, samples):
    first, last = samples[0], samples[-1]
    start = view.pixels([(first.x, first.y)])[0]
    tip = view.pixels([(first.x + 0.35 * np.cos(first.yaw), first.y + 0.35 * np.sin(first.yaw))])[0]
    for color, width in (((0, 0, 0), 6), ((90, 230, 90), 3)):
        cv2.arrowedLine(
            image,
            tuple(map(int, start)),
            tuple(map(int, tip)),
            color,
            width,
            cv2.LINE_AA,
            tipLength=0.4,
        )
        cv2.circle(image, tuple(map(int, start)), 7 + width // 3, color, -1, cv2.LINE_AA)
    end = tuple(map(int, view.pixels([(last.x, last.y)])[0]))
    cv2.circle(image, end, 9, (0, 0, 0), -1, cv2.LINE_AA)
    cv2.circle(image, end, 6, (255, 255, 255), -1, cv2.LINE_AA)


def _draw_legend(image, view, names):
    left, top = MARGIN + 90, MARGIN - 40
    for label, color in (("start", (90, 230, 90)), *zip(names, COLORS), ("end", (0, 0, 0))):
        cv2.circle(image, (left, top + 8), 7, color, 1 if label == "end" else -1, cv2.LINE_AA)
        _write(image, label, (left + 14, top + 13))
        left += 40 + 10 * len(label)
    right = view.shape[1] - MARGIN
    start = right - round(view.scale)
    cv2.line(image, (start, top + 8), (right, top + 8), (0, 0, 0), 4)
    _write(image, "1 m", (start - 42, top + 13))


def _write(image, text, position, centered=False):
    (width, _), _ = cv2.getTextSize(text, FONT, 0.5, 1)
    x = int(position[0]) - (width // 2 if centered else 0)
    cv2.putText(image, text, (x, int(position[1])), FONT, 0.5, (40, 40, 40), 1, cv2.LINE_AA)


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

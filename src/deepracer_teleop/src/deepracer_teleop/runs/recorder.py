"""Records the ground truth of a drive: pose and speed over ROS time, from nav_msgs/Odometry."""

import csv
import math
import threading
from dataclasses import dataclass

from paddock_common.angles import yaw_of


@dataclass(frozen=True)
class Sample:
    """One odometry message: time [s], position in the world [m], unwrapped heading [rad],
    forward speed [m/s] and turning rate [rad/s] in the car's frame, name of the manoeuvre."""

    t: float
    x: float
    y: float
    yaw: float
    v: float
    yaw_rate: float
    phase: str


def along(start, end):
    """Returns how far one moved from start in the direction start was heading [m]."""
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

"""Records the ground truth of a drive: pose and speed over ROS time, from nav_msgs/Odometry."""

import csv
import math
import threading
from dataclasses import dataclass

import numpy as np


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


def yaw_of(quaternion):
    """Returns the heading [rad] of a quaternion with fields x, y, z, w (Z of Z-Y-X angles)."""
    q = quaternion
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


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


class Pursuit:
    """Steers along a closed centreline towards a point ahead (pure pursuit).

    Source: R. C. Coulter, "Implementation of the Pure Pursuit Path Tracking Algorithm",
    CMU-RI-TR-92-01: curvature = 2 y / d^2 for a goal at distance d, y to the left.
    """

    def __init__(self, centreline, ahead=0.45):
        """Stores the path.

        Args:
            centreline: (N, 2) evenly spaced closed curve [m], in driving direction.
            ahead: Distance of the goal point along the path [m].
        """
        self._line = np.asarray(centreline, dtype=float)
        self._spacing = float(np.linalg.norm(self._line[1] - self._line[0]))
        self._steps = max(1, round(ahead / self._spacing))

    def nearest(self, x, y):
        """Returns (index of the nearest point, distance to it [m])."""
        gaps = np.hypot(self._line[:, 0] - x, self._line[:, 1] - y)
        index = int(np.argmin(gaps))
        return index, float(gaps[index])

    def progress(self, start, end):
        """Returns the way along the path from index start to index end [m], forwards."""
        return ((end - start) % len(self._line)) * self._spacing

    def curvature(self, x, y, yaw):
        """Returns the curvature [1/m, left positive] from a rear-axle pose to the goal."""
        index, _ = self.nearest(x, y)
        goal = self._line[(index + self._steps) % len(self._line)]
        dx, dy = goal[0] - x, goal[1] - y
        left = -math.sin(yaw) * dx + math.cos(yaw) * dy
        return 2.0 * left / max(dx * dx + dy * dy, 1e-6)

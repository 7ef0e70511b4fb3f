"""The referee's CSV file: one row per odometry message."""

import csv
import os

COLUMNS = (
    "t",
    "x",
    "y",
    "yaw",
    "speed",
    "arc_length",
    "lateral_error",
    "progress",
    "laps",
    "lap_time",
    "penalty",
    "wheels_off",
    "events",
)


class Log:
    """Writes the CSV file.

    Args:
        path: the file; missing folders are created. Empty: nothing is written.

    Raises:
        OSError: it cannot be written.
    """

    def __init__(self, path):
        self._stream = self._writer = None
        if path:
            os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
            self._stream = open(path, "w", newline="", encoding="utf-8")
            self._writer = csv.writer(self._stream)
            self._writer.writerow(COLUMNS)

    def add(self, pose, status, events):
        """Write one row.

        Args:
            pose: (x, y, yaw) [m], [rad].
            status: referee.Status; wheels_off becomes letters such as FL (front left).
            events: list of words.
        """
        if self._writer is None:
            return
        names = ("FL", "FR", "RL", "RR")
        off = " ".join(name for name, gone in zip(names, status.wheels_off) if gone)
        numbers = (
            status.time,
            *pose,
            status.speed,
            status.arc_length,
            status.lateral_error,
            status.progress,
        )
        self._writer.writerow(
            [
                *(f"{number:.6f}" for number in numbers),
                status.laps,
                f"{status.lap_time:.6f}",
                f"{status.penalty:g}",
                off,
                " ".join(events),
            ]
        )

    def close(self):
        """Finish the file."""
        if self._stream is not None:
            self._stream.close()
            self._stream = self._writer = None

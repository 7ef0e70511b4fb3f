"""The referee's CSV file: one row per odometry message."""

import contextlib
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
        on_error: called with one line of text if a later row cannot be written (the disk is full);
            the log ends there.

    Raises:
        OSError: it cannot be opened.
    """

    def __init__(self, path, on_error=lambda text: None):
        self._stream = self._writer = None
        self._path, self._on_error = path, on_error
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
        self._try(
            self._writer.writerow,
            [
                *(f"{number:.6f}" for number in numbers),
                status.laps,
                f"{status.lap_time:.6f}",
                f"{status.penalty:g}",
                off,
                " ".join(events),
            ],
        )

    def close(self):
        """Finish the file."""
        if self._stream is not None:
            self._try(self._stream.close)
            self._stream = self._writer = None

    def _try(self, write, *arguments):
        """Write; an error ends the log and is said once."""
        try:
            write(*arguments)
        except OSError as error:
            stream, self._stream, self._writer = self._stream, None, None
            with contextlib.suppress(OSError):
                stream.close()  # what is buffered cannot be written either
            self._on_error(f"{self._path} cannot be written: {error.strerror}; it ends here")

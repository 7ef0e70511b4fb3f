"""Films as MP4 files in H.264, which browsers play."""

from __future__ import annotations

import os
import threading
from fractions import Fraction
from typing import Any

import av
import numpy as np
import numpy.typing as npt

CODEC = "libx264"
OPTIONS = {"preset": "veryfast", "crf": "21"}  # fast; a smaller crf gives a better quality
CLOCK = Fraction(1, 90000)  # unit of the frames' time stamps [s]
ERRORS = (OSError, av.error.FFmpegError)  # the codec takes at most 16384 pixels a side


class FrameTimes:
    """Selects the frames of a film from a stream that may be faster than its rate [Hz]."""

    def __init__(self, rate: float) -> None:
        self._period = 1.0 / rate
        self._next: float | None = None

    def due(self, time: float) -> bool:
        """Returns whether a frame of a time [s] is due; the first is, and one after a jump back."""
        due = self._next
        if due is not None and due - 1.0 < time < due - 1e-6:
            return False
        if due is None or not time - self._period < due <= time:
            due = time
        self._next = due + self._period
        return True


class FilmWriter:
    """Writes one film; the first image sets its size. Another thread may close it.

    Args:
        rate: Frames per second of the film; each lasts 1 / rate.

    Raises:
        ValueError: The rate is not above 0.
    """

    def __init__(self, path: str | os.PathLike[str], rate: float) -> None:
        if not rate > 0.0:
            raise ValueError(f"film rate is {rate!r}; it must be above 0 Hz")
        self.path, self._rate = str(path), Fraction(rate).limit_denominator(1000)
        self._container: Any = None
        self._stream: Any = None
        self._shape: tuple[int, ...] | None = None
        self._lock, self._closed = threading.Lock(), False
        self.frames = 0

    def add(self, image: npt.NDArray[Any]) -> bool:
        """Adds an image.

        Args:
            image: (H, W, 3) uint8 BGR, of the first one's size; other sizes are skipped.

        Returns:
            Whether it was added; False if the film is closed.

        Raises:
            OSError: The file cannot be written.
        """
        with self._lock:
            return not self._closed and self._add(image)

    def _add(self, image: npt.NDArray[Any]) -> bool:
        if self._container is None:
            self._open(image.shape)
        if image.shape != self._shape:
            return False
        frame = av.VideoFrame.from_ndarray(even(image), format="bgr24")
        frame.pts = round(self.frames / self._rate / CLOCK)
        frame.time_base = CLOCK
        self._write(frame, self._container)
        self.frames += 1
        return True

    def close(self) -> None:
        """Finishes the file; a second call does nothing.

        Raises:
            OSError: The file cannot be written.
        """
        with self._lock:
            self._closed = True
            container, self._container = self._container, None
            if container is None:
                return
            try:
                self._write(None, container)
            finally:
                container.close()

    def _open(self, shape: tuple[int, ...]) -> None:
        options = {"movflags": "+faststart"}
        try:
            container = av.open(self.path, "w", format="mp4", options=options)
            self._stream = container.add_stream(CODEC, rate=self._rate, options=OPTIONS)
            self._stream.height, self._stream.width = (side + side % 2 for side in shape[:2])
            self._stream.pix_fmt = "yuv420p"  # what every player supports
            self._stream.codec_context.time_base = CLOCK
            self._stream.codec_context.thread_count = 1
            container.start_encoding()
        except ERRORS as error:
            size = f"{shape[1]} x {shape[0]} pixels"
            raise OSError(f"{self.path} cannot be written: {error.strerror} ({size})") from None
        self._container, self._shape = container, shape

    def _write(self, frame: Any, container: Any) -> None:
        try:
            for packet in self._stream.encode(frame):
                container.mux(packet)
        except ERRORS as error:
            raise OSError(f"{self.path} cannot be written: {error.strerror}") from None


def even(image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Repeats the last row or column of an image of odd size: yuv420p needs even sizes."""
    height, width = image.shape[:2]
    if height % 2 or width % 2:
        image = np.pad(image, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    return np.ascontiguousarray(image)

"""The film of a lap: camera frames with the window's overlay and the referee's figures."""

import threading

import cv2

from deepracer_teleop.window.camera_view import FrameRate, draw_frame_rate, draw_words

CODEC = "mp4v"


class Film:
    """Writes an mp4; the first frame sets the size.

    Args:
        path: Of the file.
        rate: Frames per second of the film; frames that come faster in ROS time are left out.

    Raises:
        ValueError: The rate is not above 0.
    """

    def __init__(self, path, rate=15.0):
        if not rate > 0.0:
            raise ValueError(f"film rate is {rate!r}; it must be above 0 Hz")
        self.path, self._rate = path, rate
        self._writer = self._size = None
        self._next = None
        self._frame_rate = FrameRate()
        self._lock, self._closed = threading.Lock(), False
        self.frames = 0

    def add(self, time, picture, words):
        """Adds a frame if it is due.

        Args:
            time: Stamp [s].
            picture: (H, W, 3) uint8 BGR; not changed.
            words: Text at the bottom.

        Returns:
            The frame as filmed, or None: not due, or the film is closed.

        Raises:
            OSError: The file cannot be written.
        """
        with self._lock:
            return None if self._closed else self._add(time, picture, words)

    def _add(self, time, picture, words):
        rate = self._frame_rate.update(time)
        if self._next is not None and self._next - 1.0 < time < self._next - 1e-6:
            return None
        self._next = (
            time
            if self._next is None or time - self._next > 1.0 or time < self._next
            else self._next
        ) + 1.0 / self._rate
        frame = draw_frame_rate(picture.copy(), rate)
        height, width = frame.shape[:2]
        scale = max(0.35, width / 900.0)
        draw_words(frame, words, (int(14 * scale), height - int(16 * scale)), scale)
        if self._writer is None:
            self._size = (width, height)
            self._writer = cv2.VideoWriter(
                self.path, cv2.VideoWriter_fourcc(*CODEC), self._rate, self._size
            )
            if not self._writer.isOpened():
                raise OSError(f"{self.path} cannot be written")
        if (width, height) == self._size:
            self._writer.write(frame)
            self.frames += 1
        return frame

    def close(self):
        """Finishes the file; frames that come later are left out."""
        with self._lock:
            self._closed = True
            if self._writer is not None:
                self._writer.release()
                self._writer = None

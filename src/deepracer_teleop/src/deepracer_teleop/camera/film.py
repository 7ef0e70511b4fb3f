"""A film of camera frames, with the frame rate and a line of text in them."""

from paddock_common.films.writer import FilmWriter, FrameTimes

from deepracer_teleop.camera.view import FrameRate, draw_frame_rate, draw_words


class Film:
    """Writes an mp4 (H.264); the first frame sets the size.

    Args:
        path: Of the file.
        rate: Frames per second of the film; frames that come faster in ROS time are left out.

    Raises:
        ValueError: The rate is not above 0.
    """

    def __init__(self, path, rate=15.0):
        self._writer = FilmWriter(path, rate)
        self.path, self._times = path, FrameTimes(rate)
        self._frame_rate = FrameRate()

    @property
    def frames(self):
        """Number of frames so far."""
        return self._writer.frames

    def add(self, time, picture, words):
        """Adds a frame if it is due.

        Args:
            time: Stamp [s].
            picture: (H, W, 3) uint8 BGR; not changed.
            words: Text at the bottom.

        Returns:
            The frame as filmed, or None: not due, of another size, or the film is closed.

        Raises:
            OSError: The file cannot be written.
        """
        rate = self._frame_rate.update(time)
        if not self._times.due(time):
            return None
        frame = draw_frame_rate(picture.copy(), rate)
        height, width = frame.shape[:2]
        scale = max(0.35, width / 900.0)
        draw_words(frame, words, (int(14 * scale), height - int(16 * scale)), scale)
        return frame if self._writer.add(frame) else None

    def close(self):
        """Finishes the file; frames that come later are left out."""
        self._writer.close()

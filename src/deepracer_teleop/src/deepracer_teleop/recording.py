"""Recordings of drives: films, bags, and the button of the window."""

import os
import re
import signal
import subprocess
import threading
import time

import rospy
from cv_bridge import CvBridge, CvBridgeError
from deepracer_control.topics import CAMERA_TOPIC
from paddock_common.films import FilmWriter, FrameTimes
from PyQt5.QtCore import QObject, pyqtSignal
from roslib.packages import find_node
from sensor_msgs.msg import Image

from deepracer_teleop.camera import FrameRate, draw_frame_rate, draw_text


class Film:
    """Writes an mp4 (H.264); the first frame sets the size.

    Args:
        rate: Frames per second of the film; frames that arrive faster in ROS time are skipped.

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

    def add(self, time, image, text):
        """Adds a frame if it is due.

        Args:
            time: Time stamp [s].
            image: (H, W, 3) uint8 BGR; not changed.
            text: Text at the bottom.

        Returns:
            The frame as written, or None: not due, of another size, or the film is closed.

        Raises:
            OSError: The file cannot be written.
        """
        rate = self._frame_rate.update(time)
        if not self._times.due(time):
            return None
        frame = draw_frame_rate(image.copy(), rate)
        height, width = frame.shape[:2]
        scale = max(0.35, width / 900.0)
        draw_text(frame, text, (int(14 * scale), height - int(16 * scale)), scale)
        return frame if self._writer.add(frame) else None

    def close(self):
        """Finishes the file; later frames are skipped."""
        self._writer.close()


IMAGE_TYPES = ("sensor_msgs/Image", "sensor_msgs/CompressedImage", "sensor_msgs/PointCloud2")
# Not in the bag: the clock (rosbag play --clock makes one), the simulator's own topics (up to
# 1,000 messages a second), and images (the film has them).
EXCLUDED = ("/clock", "/gazebo/.*", ".*/compressed.*", ".*/theora.*")
FILM_RATE = 15.0  # [Hz] of ROS time
STOP_TIMEOUT = 10.0  # longest wait for the bag to be complete [s]


def excluded(topics):
    """Returns a regular expression of topics that do not go into the bag.

    Args:
        topics: Pairs (name, type) of what is published now.
    """
    names = [re.escape(name) for name, message_type in topics if message_type in IMAGE_TYPES]
    return "|".join((*EXCLUDED, *names))


def size_text(size):
    """Returns a file's size as text, from bytes."""
    return f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{size / 1e3:.0f} kB"


class Recording:
    """One recording, from start() to stop().

    Args:
        folder: Target folder; created if it is missing.

    Attributes:
        stem: Path of bag and film without their suffixes.
        problem: Error message, or "".
    """

    def __init__(self, folder):
        name = time.strftime("drive-%Y%m%d-%H%M%S")
        self.folder = os.path.abspath(os.path.expanduser(folder))
        self.stem = os.path.join(self.folder, name)
        self.problem = ""
        self._film, self._bridge = Film(f"{self.stem}.mp4", FILM_RATE), CvBridge()
        self._bag = self._subscriber = None
        self._since = time.monotonic()

    def start(self):
        """Starts bag and film.

        Raises:
            OSError: The folder cannot be written, or there is no rosbag.
        """
        os.makedirs(self.folder, exist_ok=True)
        if not os.access(self.folder, os.W_OK):
            raise OSError(f"{self.folder} cannot be written")
        programs = find_node("rosbag", "record")
        if not programs:
            raise OSError("rosbag's record is not installed (Debian: python3-rosbag)")
        self._since = time.monotonic()
        self._bag = subprocess.Popen(
            [
                programs[0],
                *("-a", "-q", "-O", f"{self.stem}.bag", "-x", excluded(topics())),
                f"__name:=record_{os.getpid()}_{int(self._since)}",
            ],
            stdin=subprocess.DEVNULL,
        )
        self._subscriber = rospy.Subscriber(
            CAMERA_TOPIC, Image, self.callback, queue_size=2, buff_size=2**24
        )

    def callback(self, message):
        """Adds a camera frame to the film; runs in the subscriber's thread."""
        stamp = message.header.stamp.to_sec() or rospy.get_time()
        try:
            image = self._bridge.imgmsg_to_cv2(message, "bgr8")
            self._film.add(stamp, image, f"{stamp:.1f} s")
        except (CvBridgeError, OSError) as error:
            self.problem = f"no film: {error}"

    def text(self):
        """Returns the text that the window shows during the recording."""
        if self._bag.poll() is not None and not self.problem:
            self.problem = (
                f"the bag has stopped (exit status {self._bag.returncode}); is the disk full?"
            )
        if self.problem:
            return f"Recording: {self.problem}"
        seconds = int(time.monotonic() - self._since)
        return (
            f"Recording {seconds // 60}:{seconds % 60:02d} to {self.stem}.bag "
            f"({size_text(self._bag_size())}) and .mp4 ({self._film.frames} images)"
        )

    def stop(self):
        """Stops bag and film.

        Returns:
            The text that the window shows then.
        """
        if self._subscriber is not None:
            self._subscriber.unregister()
        try:
            self._film.close()
        except OSError as error:
            self.problem = f"no film: {error}"
        self._stop_bag()
        if self.problem:
            return f"Recording: {self.problem}"
        film = f"{self._film.frames} images" if self._film.frames else "none: no image received"
        bag = size_text(self._bag_size())
        return f"Recorded {self.stem}.bag ({bag}) and .mp4 ({film})"

    def _stop_bag(self):
        if self._bag is None:
            return
        if self._bag.poll() is None:
            self._bag.send_signal(signal.SIGINT)
        try:
            self._bag.wait(STOP_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._bag.kill()
            self._bag.wait()
            self.problem = (
                f"the bag did not stop within {STOP_TIMEOUT:g} s; see {self.stem}.bag.active"
            )

    def _bag_size(self):
        for path in (f"{self.stem}.bag", f"{self.stem}.bag.active"):
            try:
                return os.path.getsize(path)
            except OSError:  # not there, or renamed just now
                continue
        return 0


def topics():
    """Returns pairs (name, type) of what is published; empty without a ROS master."""
    try:
        return rospy.get_published_topics()
    except (OSError, rospy.ROSException):
        return []


class RecordButton(QObject):
    """Starts and stops recordings by a checkable button and shows them in a label.

    Args:
        label: QLabel, hidden while it is empty.
    """

    finished = pyqtSignal(str)  # from the thread that stops a recording to Qt's

    def __init__(self, button, label, folder):
        super().__init__(button)
        self._button, self._label, self._folder = button, label, folder
        self._recording = self._stopping = None
        button.toggled.connect(self._toggle)
        self.finished.connect(self._on_finished)

    @property
    def recording(self):
        """The running Recording, or None."""
        return self._recording

    def check(self):
        """Shows the state of the recording."""
        if self._recording is not None:
            self._show(self._recording.text())

    def finish(self):
        """Stops a running recording and waits for its files."""
        self._button.setChecked(False)
        if self._stopping is not None:
            self._stopping.join()

    def _toggle(self, on):
        if on:
            self._start()
        elif self._recording is not None:
            self._button.setEnabled(False)  # until the files are complete
            recording, self._recording = self._recording, None
            self._stopping = threading.Thread(
                target=lambda: self._stop(recording), name="record-stop", daemon=True
            )
            self._stopping.start()
        self._button.setText("Record" if self._recording is None else "Stop recording")

    def _start(self):
        recording = Recording(self._folder)
        try:
            recording.start()
        except OSError as error:
            self._show(f"Recording: {error}")
            self._button.setChecked(False)
            return
        self._recording = recording
        self.check()

    def _stop(self, recording):
        """Stops a recording without blocking the window; runs in a separate thread."""
        text = recording.stop()
        print(f"teleop: {text}", flush=True)
        try:
            self.finished.emit(text)
        except RuntimeError:  # the Qt object is deleted already
            pass

    def _on_finished(self, text):
        self._button.setEnabled(True)
        self._show(text)

    def _show(self, text):
        if text != self._label.text():
            self._label.setText(text)
        self._label.show()

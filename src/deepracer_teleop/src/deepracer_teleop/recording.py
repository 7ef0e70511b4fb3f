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

from deepracer_teleop.camera import FrameRate, draw_frame_rate, draw_words


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


PICTURES = ("sensor_msgs/Image", "sensor_msgs/CompressedImage", "sensor_msgs/PointCloud2")
# Not in the bag: the clock (rosbag play --clock makes one), the simulator's own topics (up to
# 1,000 messages a second), and pictures (the film has them).
LEFT_OUT = ("/clock", "/gazebo/.*", ".*/compressed.*", ".*/theora.*")
FILM_RATE = 15.0  # [Hz] of ROS time
END = 10.0  # longest wait for the end of the bag [s]


def excluded(topics):
    """Returns a regular expression of topics that do not go into the bag.

    Args:
        topics: Pairs (name, type) of what is published now.
    """
    names = [re.escape(name) for name, kind in topics if kind in PICTURES]
    return "|".join((*LEFT_OUT, *names))


def size_words(size):
    """Returns a file's size in words, from bytes."""
    return f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{size / 1e3:.0f} kB"


class Recording:
    """One recording, from start() to stop().

    Attributes:
        stem: Path of bag and film without their suffixes.
        problem: What went wrong, or "".
    """

    def __init__(self, folder):
        """Chooses the name; nothing is written yet.

        Args:
            folder: Where to; made if it is missing.
        """
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
            picture = self._bridge.imgmsg_to_cv2(message, "bgr8")
            self._film.add(stamp, picture, f"{stamp:.1f} s")
        except (CvBridgeError, OSError) as error:
            self.problem = f"no film: {error}"

    def words(self):
        """Returns what the window shows meanwhile."""
        if self._bag.poll() is not None and not self.problem:
            self.problem = f"the bag has ended (status {self._bag.returncode}); is the disk full?"
        if self.problem:
            return f"Recording: {self.problem}"
        seconds = int(time.monotonic() - self._since)
        return (
            f"Recording {seconds // 60}:{seconds % 60:02d} to {self.stem}.bag "
            f"({size_words(self._bag_size())}) and .mp4 ({self._film.frames} pictures)"
        )

    def stop(self):
        """Ends bag and film.

        Returns:
            What the window shows then.
        """
        if self._subscriber is not None:
            self._subscriber.unregister()
        try:
            self._film.close()
        except OSError as error:
            self.problem = f"no film: {error}"
        self._end_bag()
        if self.problem:
            return f"Recording: {self.problem}"
        film = f"{self._film.frames} pictures" if self._film.frames else "none: no picture came"
        bag = size_words(self._bag_size())
        return f"Recorded {self.stem}.bag ({bag}) and .mp4 ({film})"

    def _end_bag(self):
        if self._bag is None:
            return
        if self._bag.poll() is None:
            self._bag.send_signal(signal.SIGINT)
        try:
            self._bag.wait(END)
        except subprocess.TimeoutExpired:
            self._bag.kill()
            self._bag.wait()
            self.problem = f"the bag did not end within {END:g} s; see {self.stem}.bag.active"

    def _bag_size(self):
        for path in (f"{self.stem}.bag", f"{self.stem}.bag.active"):
            try:
                return os.path.getsize(path)
            except OSError:  # not there, or renamed just now
                continue
        return 0


def topics():
    """Returns pairs (name, type) of what is published, or nothing if the master is lost."""
    try:
        return rospy.get_published_topics()
    except (OSError, rospy.ROSException):
        return []


class RecordButton(QObject):
    """Starts and ends recordings by a checkable button and shows them in a label.

    Args:
        button: QPushButton.
        label: QLabel, hidden until there is something to say.
        folder: For the recordings.
    """

    ended = pyqtSignal(str)  # from the thread that ends a recording to Qt's

    def __init__(self, button, label, folder):
        super().__init__(button)
        self._button, self._label, self._folder = button, label, folder
        self._recording = self._ending = None
        button.toggled.connect(self._toggle)
        self.ended.connect(self._show_end)

    @property
    def recording(self):
        """The running Recording, or None."""
        return self._recording

    def check(self):
        """Shows how far the recording is."""
        if self._recording is not None:
            self._show(self._recording.words())

    def finish(self):
        """Ends a running recording and waits for its files."""
        self._button.setChecked(False)
        if self._ending is not None:
            self._ending.join()

    def _toggle(self, on):
        if on:
            self._start()
        elif self._recording is not None:
            self._button.setEnabled(False)  # until the files are complete
            recording, self._recording = self._recording, None
            self._ending = threading.Thread(
                target=lambda: self._end(recording), name="record-end", daemon=True
            )
            self._ending.start()
        self._button.setText("Record" if self._recording is None else "End recording")

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

    def _end(self, recording):
        """Ends a recording without holding up the window; runs in a thread of its own."""
        words = recording.stop()
        print(f"teleop: {words}", flush=True)
        try:
            self.ended.emit(words)
        except RuntimeError:  # the Qt object is deleted already
            pass

    def _show_end(self, words):
        self._button.setEnabled(True)
        self._show(words)

    def _show(self, words):
        if words != self._label.text():
            self._label.setText(words)
        self._label.show()

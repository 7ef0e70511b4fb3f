"""Record: a bag and a film of the camera beside each other, under one name."""

import os
import re
import signal
import subprocess
import time

import rospy
from cv_bridge import CvBridge, CvBridgeError
from deepracer_control.topics import CAMERA_TOPIC
from roslib.packages import find_node
from sensor_msgs.msg import Image

from deepracer_teleop.camera.film import Film

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

"""Camera frames from the subscriber's thread to the window, and the check that they come."""

import time

import cv2
import rospy
from cv_bridge import CvBridge, CvBridgeError
from deepracer_control.topics import CAMERA_TOPIC
from PyQt5.QtCore import QObject, Qt, pyqtSignal
from sensor_msgs.msg import Image

from deepracer_teleop.camera.latest import LatestValue
from deepracer_teleop.camera.view import FrameRate, draw_frame_rate, to_pixmap


class CameraFeed(QObject):
    """Shows the frames of CAMERA_TOPIC in a CameraView, or a message when none come.

    Attributes:
        picture: The newest frame as it came, (H, W, 3) uint8 BGR, or None.
        time: ROS time [s] at which it was shown, or None.
    """

    arrived = pyqtSignal()  # from the subscriber's thread to Qt's

    def __init__(self, view, timeout):
        """Prepares the feed; start() subscribes.

        Args:
            view: CameraView.
            timeout: Wall time without a picture after which the camera counts as stopped [s].
        """
        super().__init__(view)
        self._view, self._timeout = view, timeout
        self._bridge, self._latest_frame, self._frame_rate = CvBridge(), LatestValue(), FrameRate()
        self.picture = self.time = None
        self._shown = None  # (wall time, words for the ROS time) of the newest frame
        self._started, self._subscriber, self._stopped = time.monotonic(), None, False
        self.arrived.connect(self._show, Qt.QueuedConnection)

    def start(self):
        """Subscribes."""
        self._started = time.monotonic()
        self._subscriber = rospy.Subscriber(
            CAMERA_TOPIC, Image, self.callback, queue_size=1, buff_size=2**24
        )

    def stop(self):
        """Unsubscribes; frames that come later are not shown."""
        self._stopped = True
        if self._subscriber is not None:
            self._subscriber.unregister()

    def callback(self, message):
        """Stores a camera frame; runs in the subscriber's thread, so it changes no widget."""
        if self._latest_frame.put(message):
            self.arrived.emit()

    def _show(self):
        message = self._latest_frame.take()
        if message is None or self._stopped:
            return
        now = rospy.get_time()
        self.time = now
        self._shown = (time.monotonic(), f"{now:.1f} s ({time.strftime('%H:%M:%S')})")
        rate = self._frame_rate.update(message.header.stamp.to_sec() or now)
        try:
            self.picture = self._bridge.imgmsg_to_cv2(message, "bgr8")
            shown = draw_frame_rate(self.picture.copy(), rate)
            self._view.show_picture(to_pixmap(shown, *self._view.room()))
        except (CvBridgeError, cv2.error, ValueError, TypeError) as error:
            self._view.show_message(
                f"A picture on {CAMERA_TOPIC} cannot be shown (encoding {message.encoding!r}, "
                f"{message.width}x{message.height}): {error}"
            )

    def check(self):
        """Shows a message when no picture has come yet, or none for too long."""
        now = time.monotonic()
        if self._shown is None:
            if now - self._started > self._timeout:
                self._view.show_message(
                    f"No camera: nothing has come on {CAMERA_TOPIC}.\n"
                    "Does the simulator (or the car) run?"
                )
            else:
                self._view.show_message(f"Waiting for {CAMERA_TOPIC} ...")
        elif now - self._shown[0] > self._timeout:
            paused = abs(rospy.get_time() - self.time) < 0.1
            self._view.show_message(
                f"The camera has stopped: no picture since "
                f"{self._shown[1]}." + ("\nThe clock stands still, too." if paused else "")
            )

"""The camera image in the window: received, counted, painted."""

import threading
import time

import cv2
import rospy
from cv_bridge import CvBridge, CvBridgeError
from deepracer_control.topics import CAMERA_TOPIC
from PyQt5.QtCore import QObject, QPoint, QRect, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QImage, QPainter, QPixmap
from PyQt5.QtWidgets import QLabel, QSizePolicy
from sensor_msgs.msg import Image


class LatestValue:
    """Stores the latest value set by another thread; older ones are dropped."""

    def __init__(self):
        self._lock = threading.Lock()
        self._item = None

    def put(self, item):
        """Stores an item; returns whether there was none (the owner then has to be notified)."""
        with self._lock:
            empty, self._item = self._item is None, item
            return empty

    def take(self):
        """Returns the latest item and removes it; None if there is none."""
        with self._lock:
            item, self._item = self._item, None
            return item


class FrameRate:
    """Frames per second from the stamps of two frames in a row."""

    def __init__(self):
        self._last = None

    def update(self, stamp):
        """Updates with the next frame's stamp.

        Args:
            stamp: Time of the frame [s].

        Returns:
            1 / time between the frames [Hz], or None for the first frame, a repeated stamp or a
            clock that went backwards.
        """
        last, self._last = self._last, stamp
        if last is None or stamp <= last:
            return None
        return 1.0 / (stamp - last)


def frame_rate_text(rate):
    """Returns the text drawn into the picture, from a rate [Hz] or None."""
    if rate is None:
        return "Image Framerate: --"
    return f"Image Framerate: {rate:.0f}" if rate >= 9.95 else f"Image Framerate: {rate:.1f}"


def draw_frame_rate(picture, rate):
    """Writes the frame rate into a picture, in its upper left corner.

    Args:
        picture: (H, W, 3) uint8 BGR; changed in place.
        rate: Frame rate [Hz] or None.

    Returns:
        The picture.
    """
    scale = max(0.4, picture.shape[1] / 640.0)
    place = (int(12 * scale), int(32 * scale))
    draw_words(picture, frame_rate_text(rate), place, scale)
    return picture


def draw_words(picture, words, place, scale):
    """Writes white words with a black rim into a picture.

    Args:
        picture: (H, W, 3) uint8 BGR; changed in place.
        words: A line.
        place: (x, y) of its lower left corner [px].
        scale: Of the font.
    """
    for colour, width in (((0, 0, 0), 4), ((255, 255, 255), 2)):
        thickness = max(1, round(width * scale))
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(picture, words, place, font, scale, colour, thickness, cv2.LINE_AA)


def to_pixmap(picture, size, ratio=1.0):
    """Turns an OpenCV picture into one for a label.

    Args:
        picture: (H, W, 3) uint8 BGR.
        size: QSize.
        ratio: Pixels of the screen to one of the size (high-DPI screens).

    Returns:
        QPixmap, as large as fits the size, aspect kept.
    """
    rgb = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
    height, width, channels = rgb.shape
    image = QImage(rgb.data, width, height, channels * width, QImage.Format_RGB888)
    return scaled(QPixmap.fromImage(image), size, ratio)


def scaled(pixmap, size, ratio):
    """Returns a QPixmap fitted into a size as to_pixmap does."""
    fitted = pixmap.scaled(size * ratio, Qt.KeepAspectRatio, Qt.SmoothTransformation)
    fitted.setDevicePixelRatio(ratio)
    return fitted


class CameraView(QLabel):
    """A label that shows a picture as large as fits, aspect kept, and a message over it."""

    def __init__(self, width=320, height=240, parent=None):
        """Starts without a picture.

        Args:
            width: Smallest and preferred width [px].
            height: Smallest and preferred height [px].
            parent: Qt parent.
        """
        super().__init__(parent)
        self._size = QSize(width, height)
        self._picture = None
        self.message = ""
        self.setObjectName("camera")
        self.setAlignment(Qt.AlignCenter)
        self.setWordWrap(True)
        self.setMinimumSize(self._size)
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)
        self.setStyleSheet("#camera { background: #20242a; color: #e8eaed; border-radius: 6px; }")

    def sizeHint(self):
        """Returns the preferred size, whatever picture is shown."""
        return self._size

    def room(self):
        """Returns the QSize for a picture, and the pixels of the screen to one of it."""
        return self.contentsRect().size(), self.devicePixelRatioF()

    def show_picture(self, pixmap):
        """Shows a new picture (QPixmap of any size) and drops the message."""
        self._picture, self.message = pixmap, ""
        self._refresh()

    def show_message(self, words):
        """Shows a message, over the darkened last picture if there is one."""
        if words != self.message:
            self.message = words
            self._refresh()

    def resizeEvent(self, event):
        """Fits the picture into the new size."""
        super().resizeEvent(event)
        self._refresh()

    def _refresh(self):
        if self._picture is None or self._picture.isNull():
            self.setText(self.message)
            return
        shown = scaled(self._picture, *self.room())
        self.setPixmap(self._with_message(shown) if self.message else shown)

    def _with_message(self, shown):
        shown = QPixmap(shown)
        box = QRect(QPoint(), shown.size() / shown.devicePixelRatioF())
        painter = QPainter(shown)
        painter.fillRect(box, QColor(20, 22, 26, 190))
        painter.setPen(QColor("#ffd166"))
        painter.drawText(
            box.adjusted(12, 12, -12, -12),
            Qt.AlignCenter | Qt.TextWordWrap,
            self.message,
        )
        painter.end()
        return shown


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

"""The camera image in the window: received, counted, rendered."""

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
        """Updates with the next frame's stamp [s].

        Returns:
            1 / time between the frames [Hz], or None for the first frame, a repeated stamp or a
            clock that went backwards.
        """
        last, self._last = self._last, stamp
        if last is None or stamp <= last:
            return None
        return 1.0 / (stamp - last)


def frame_rate_text(rate):
    """Returns the text rendered into the image, from a rate [Hz] or None."""
    if rate is None:
        return "Image Framerate: --"
    return f"Image Framerate: {rate:.0f}" if rate >= 9.95 else f"Image Framerate: {rate:.1f}"


def draw_frame_rate(image, rate):
    """Renders the frame rate into an image, in its upper left corner.

    Args:
        image: (H, W, 3) uint8 BGR; changed in place.
        rate: Frame rate [Hz] or None.
    """
    scale = max(0.4, image.shape[1] / 640.0)
    position = (int(12 * scale), int(32 * scale))
    draw_text(image, frame_rate_text(rate), position, scale)
    return image


def draw_text(image, text, position, scale):
    """Renders white text with a black outline into an image.

    Args:
        image: (H, W, 3) uint8 BGR; changed in place.
        position: (x, y) of its lower left corner [px].
        scale: Scale of the font.
    """
    for color, width in (((0, 0, 0), 4), ((255, 255, 255), 2)):
        thickness = max(1, round(width * scale))
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(image, text, position, font, scale, color, thickness, cv2.LINE_AA)


def to_pixmap(image, size: QSize, ratio=1.0):
    """Converts an OpenCV image to a pixmap for a label.

    Args:
        image: (H, W, 3) uint8 BGR.
        ratio: Device pixel ratio of the screen.

    Returns:
        QPixmap, the largest that fits the size, with its aspect ratio.
    """
    rgb = cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
    height, width, channels = rgb.shape
    converted = QImage(rgb.data, width, height, channels * width, QImage.Format_RGB888)
    return scaled(QPixmap.fromImage(converted), size, ratio)


def scaled(pixmap, size, ratio):
    """Returns a QPixmap fitted into a size as to_pixmap does."""
    fitted = pixmap.scaled(size * ratio, Qt.KeepAspectRatio, Qt.SmoothTransformation)
    fitted.setDevicePixelRatio(ratio)
    return fitted


class CameraView(QLabel):
    """A label with an image, scaled to fit with its aspect ratio, and a message over it.

    Args:
        width, height: Minimum and preferred size [px].
    """

    def __init__(self, width=320, height=240, parent=None):
        super().__init__(parent)
        self._size = QSize(width, height)
        self._pixmap = None
        self.message = ""
        self.setObjectName("camera")
        self.setAlignment(Qt.AlignCenter)
        self.setWordWrap(True)
        self.setMinimumSize(self._size)
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)
        self.setStyleSheet("#camera { background: #20242a; color: #e8eaed; border-radius: 6px; }")

    def sizeHint(self):
        """Returns the preferred size, independent of the image."""
        return self._size

    def available_size(self):
        """Returns the QSize for an image, and the device pixel ratio."""
        return self.contentsRect().size(), self.devicePixelRatioF()

    def show_image(self, pixmap):
        """Shows a new image (QPixmap of any size) and removes the message."""
        self._pixmap, self.message = pixmap, ""
        self._refresh()

    def show_message(self, text):
        """Shows a message, over the darkened last image if there is one."""
        if text != self.message:
            self.message = text
            self._refresh()

    def resizeEvent(self, event):
        """Fits the image to the new size."""
        super().resizeEvent(event)
        self._refresh()

    def _refresh(self):
        if self._pixmap is None or self._pixmap.isNull():
            self.setText(self.message)
            return
        fitted = scaled(self._pixmap, *self.available_size())
        self.setPixmap(self._with_message(fitted) if self.message else fitted)

    def _with_message(self, pixmap):
        pixmap = QPixmap(pixmap)
        box = QRect(QPoint(), pixmap.size() / pixmap.devicePixelRatioF())
        painter = QPainter(pixmap)
        painter.fillRect(box, QColor(20, 22, 26, 190))
        painter.setPen(QColor("#ffd166"))
        painter.drawText(
            box.adjusted(12, 12, -12, -12),
            Qt.AlignCenter | Qt.TextWordWrap,
            self.message,
        )
        painter.end()
        return pixmap


class CameraFeed(QObject):
    """Shows the frames of CAMERA_TOPIC in a CameraView, or a message when there are none.

    Args:
        timeout: Wall time without an image after which the camera counts as stopped [s].

    Attributes:
        image: The newest frame as received, (H, W, 3) uint8 BGR, or None.
        time: ROS time [s] at which it was shown, or None.
    """

    arrived = pyqtSignal()  # from the subscriber's thread to Qt's

    def __init__(self, view: CameraView, timeout):
        super().__init__(view)
        self._view, self._timeout = view, timeout
        self._bridge, self._latest_frame, self._frame_rate = CvBridge(), LatestValue(), FrameRate()
        self.image = self.time = None
        self._newest = None  # (wall time, text of the ROS time) of the newest frame
        self._started, self._subscriber, self._stopped = time.monotonic(), None, False
        self.arrived.connect(self._show, Qt.QueuedConnection)

    def start(self):
        """Subscribes."""
        self._started = time.monotonic()
        self._subscriber = rospy.Subscriber(
            CAMERA_TOPIC, Image, self.callback, queue_size=1, buff_size=2**24
        )

    def stop(self):
        """Unsubscribes; later frames are not shown."""
        self._stopped = True
        if self._subscriber is not None:
            self._subscriber.unregister()

    def callback(self, message):
        """Stores a camera frame; runs in the subscriber's thread, so it does not change widgets."""
        if self._latest_frame.put(message):
            self.arrived.emit()

    def _show(self):
        message = self._latest_frame.take()
        if message is None or self._stopped:
            return
        now = rospy.get_time()
        self.time = now
        self._newest = (time.monotonic(), f"{now:.1f} s ({time.strftime('%H:%M:%S')})")
        rate = self._frame_rate.update(message.header.stamp.to_sec() or now)
        try:
            self.image = self._bridge.imgmsg_to_cv2(message, "bgr8")
            rendered = draw_frame_rate(self.image.copy(), rate)
            self._view.show_image(to_pixmap(rendered, *self._view.available_size()))
        except (CvBridgeError, cv2.error, ValueError, TypeError) as error:
            self._view.show_message(
                f"An image on {CAMERA_TOPIC} cannot be shown (encoding {message.encoding!r}, "
                f"{message.width}x{message.height}): {error}"
            )

    def check(self):
        """Shows a message when no image was received yet, or none for too long."""
        now = time.monotonic()
        if self._newest is None:
            if now - self._started > self._timeout:
                self._view.show_message(
                    f"No camera: nothing received on {CAMERA_TOPIC}.\n"
                    "Does the simulator (or the car) run?"
                )
            else:
                self._view.show_message(f"Waiting for {CAMERA_TOPIC} ...")
        elif now - self._newest[0] > self._timeout:
            paused = abs(rospy.get_time() - self.time) < 0.1
            self._view.show_message(
                f"The camera has stopped: no image since "
                f"{self._newest[1]}." + ("\nThe clock is paused, too." if paused else "")
            )

"""Camera images, lidar scans and point clouds for pages: subscribed while a page wants them."""

from __future__ import annotations

import math
import struct
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import cv2
import numpy as np
import rospy
from bullet_sim.pose import Array
from cv_bridge import CvBridge, CvBridgeError
from sensor_msgs.msg import Image, LaserScan, PointCloud2, PointField, Range

from bullet_web.messages import json_of

IMAGE_RATE = 15.0  # images a second of wall time, at most
POINTS_RATE = 10.0
MAX_POINTS = 20000  # of a cloud on a page
CONE_RAYS = 9  # that stand for the cone of a sensor_msgs/Range
BUFFER = 1 << 24  # [B] of a subscription: a whole image
MAX_WIDTH, MAX_HEIGHT = 640, 65500  # [px] of an image on a page; JPEG has no more
JPEG = [int(cv2.IMWRITE_JPEG_QUALITY), 75]
COLORLESS = ("mono8", "8UC1", "8UC3")  # shown as they are: 8UC3 is taken for BGR
_BRIDGE = CvBridge()


def packed(head: dict[str, Any], payload: bytes) -> bytes:
    """Binary message for pages: length of the head (uint32), head as JSON, payload.

    The head is padded so that the payload's numbers are aligned in the message.
    """
    text = json_of(head).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<I", len(text)) + text + payload


def picture(message: Any) -> Array:
    """(H, W) or (H, W, 3) uint8, gray or BGR, of a sensor_msgs/Image; distances as gray.

    Raises:
        ValueError: the encoding is not known, or the data is too short.
    """
    try:
        kind, channels = _BRIDGE.encoding_to_dtype_with_channels(message.encoding)
    except (CvBridgeError, KeyError):
        valid = "one of sensor_msgs/image_encodings.h"
        raise ValueError(f"encoding is {message.encoding!r}, must be {valid}") from None
    height, width, step = message.height, message.width, message.step
    wide = np.dtype(kind).itemsize
    row = width * channels * wide
    if not height or not width or step < row or len(message.data) < height * step:
        raise ValueError(
            f"the image has {len(message.data)} bytes, {height} rows of {step}, a width of {width}"
        )
    if step != row:  # cv_bridge takes what is behind a row's pixels for some of the next row
        rows = np.frombuffer(message.data, np.uint8, height * step).reshape(height, step)
        tight = {"step": row, "data": rows[:, :row].tobytes(), "is_bigendian": message.is_bigendian}
        message = Image(height=height, width=width, encoding=message.encoding, **tight)
    if channels == 1 and wide > 1:
        return stretched(_BRIDGE.imgmsg_to_cv2(message))
    return _BRIDGE.imgmsg_to_cv2(message, *(() if message.encoding in COLORLESS else ("bgr8",)))


def stretched(values: Array) -> Array:
    """(H, W) uint8 of numbers: the least is black, the greatest finite one white."""
    numbers = values.astype(float)
    finite = np.isfinite(numbers)
    if not finite.any():
        return np.zeros(values.shape, np.uint8)
    low, high = numbers[finite].min(), numbers[finite].max()
    scaled = (np.where(finite, numbers, high) - low) * (255.0 / max(high - low, 1e-9))
    return scaled.astype(np.uint8)


def jpeg(message: Any) -> bytes:
    """JPEG of a sensor_msgs/Image, at most MAX_WIDTH wide and MAX_HEIGHT high.

    Raises:
        ValueError: it is none that is known.
    """
    pixels = picture(message)
    height, width = pixels.shape[:2]
    scale = min(MAX_WIDTH / width, MAX_HEIGHT / height)
    if scale < 1.0:
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    done, data = cv2.imencode(".jpg", pixels, JPEG)
    if not done:
        raise ValueError(f"the image of {width} x {height} cannot be encoded")
    return data.tobytes()


def ends(ranges: Array, angles: Array, low: float, high: float) -> tuple[Array, Array]:
    """Ends of a plane's rays in the sensor's frame.

    Args:
        ranges: (n,) [m].
        angles: (n,) [rad], counter-clockwise from x.
        low, high: bounds of ranges with an echo [m].

    Returns:
        (k, 3) float32 [m] where rays have an echo, and (m, 3) at `high` where they have none; a
        range below `low` or that is no number is in neither.
    """
    hit = np.isfinite(ranges) & (ranges >= low) & (ranges <= high)
    miss = (ranges > high) & np.isfinite(high)
    directions = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
    hits = ranges[hit, np.newaxis] * directions[hit]
    return hits.astype(np.float32), (high * directions[miss]).astype(np.float32)


def scan_ends(message: Any) -> tuple[Array, Array]:
    """As ends(), of a sensor_msgs/LaserScan.

    Raises:
        ValueError: its angles are no numbers.
    """
    if not math.isfinite(message.angle_min) or not math.isfinite(message.angle_increment):
        raise ValueError(f"angles are {message.angle_min}, {message.angle_increment}")
    ranges = np.asarray(message.ranges, np.float32)
    angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
    return ends(ranges, angles, message.range_min, message.range_max)


def cone_ends(message: Any) -> tuple[Array, Array]:
    """As ends(), of a sensor_msgs/Range: rays across its field of view.

    Raises:
        ValueError: the field of view is no number.
    """
    if not math.isfinite(message.field_of_view):
        raise ValueError(f"field_of_view is {message.field_of_view}")
    angles = np.linspace(-0.5, 0.5, CONE_RAYS) * message.field_of_view
    ranges = np.full(CONE_RAYS, message.range, np.float32)
    return ends(ranges, angles, message.min_range, message.max_range)


def cloud_ends(message: Any) -> tuple[Array, Array]:
    """As ends(), of a sensor_msgs/PointCloud2, which has no rays without an echo.

    Raises:
        ValueError: it has no float32 x, y and z, or too few bytes.
    """
    offsets = {f.name: f.offset for f in message.fields if f.datatype == PointField.FLOAT32}
    if not {"x", "y", "z"} <= offsets.keys():
        raise ValueError(f"the cloud has float32 fields {sorted(offsets)}, must have x, y and z")
    step, width, height = message.point_step, message.width, message.height
    row = message.row_step or step * width
    last = max(offsets[name] for name in "xyz") + 4
    if step < last or row < step * width or len(message.data) < row * height:
        raise ValueError(
            f"the cloud has {len(message.data)} bytes, {height} rows of {row} and {width} points "
            f"of {step}"
        )
    table = np.frombuffer(message.data, np.uint8, row * height).reshape(height, row)
    order = ">" if message.is_bigendian else "<"
    kind = np.dtype(
        {
            "names": ["x", "y", "z"],
            "formats": [f"{order}f4"] * 3,
            "offsets": [offsets[name] for name in "xyz"],
            "itemsize": step,
        }
    )
    rows = np.ascontiguousarray(table[:, : step * width]).view(kind).ravel()
    points = np.column_stack([rows["x"], rows["y"], rows["z"]]).astype(np.float32)
    points = points[np.isfinite(points).all(axis=1)]
    return points[:: max(1, -(-len(points) // MAX_POINTS))], np.zeros((0, 3), np.float32)


def image_message(message: Any) -> bytes:
    """What pages get of an image."""
    return packed({"type": "image"}, jpeg(message))


def points_message(message: Any, find: Callable[[Any], tuple[Array, Array]]) -> bytes:
    """What pages get of ends of rays: first those with an echo, which are `hits`, then the others.

    `frame` is the link, without its model.
    """
    hits, misses = find(message)
    frame = message.header.frame_id.rpartition("/")[2]
    head = {"type": "points", "frame": frame, "hits": len(hits)}
    return packed(head, hits.tobytes() + misses.tobytes())


TYPES: dict[str, tuple[str, Any, float, Callable[[Any], bytes]]] = {
    # type of a topic -> (kind of message, class, most a second, conversion)
    "sensor_msgs/Image": ("image", Image, IMAGE_RATE, image_message),
    "sensor_msgs/LaserScan": (
        "points",
        LaserScan,
        POINTS_RATE,
        partial(points_message, find=scan_ends),
    ),
    "sensor_msgs/PointCloud2": (
        "points",
        PointCloud2,
        POINTS_RATE,
        partial(points_message, find=cloud_ends),
    ),
    "sensor_msgs/Range": ("points", Range, POINTS_RATE, partial(points_message, find=cone_ends)),
}


class Subscription:
    """One topic that pages want, converted once for all of them.

    Attributes:
        last: kind and message that were delivered last; None: nothing.
    """

    def __init__(self, topic: str, kind: str, deliver: Callable[[str, str, bytes], object]) -> None:
        self.topic = topic
        self._deliver = deliver
        self._kind, message, rate, self._convert = TYPES[kind]
        self._period, self._last = 1.0 / rate, -math.inf
        self._problem = ""
        self.last: tuple[str, bytes] | None = None
        self._subscriber = rospy.Subscriber(
            topic, message, self._receive, queue_size=1, buff_size=BUFFER
        )

    def _receive(self, message: Any) -> None:
        now = time.monotonic()
        if now - self._last < self._period:
            return
        self._last = now
        try:
            self.last = self._kind, self._convert(message)
            self._deliver(self._kind, self.topic, self.last[1])
        except ValueError as error:
            if str(error) != self._problem:  # once
                self._problem = str(error)
                rospy.logwarn("%s cannot be shown: %s", self.topic, error)

    def close(self) -> None:
        """Unsubscribe; a message that has come may still be delivered."""
        self._subscriber.unregister()


class Sensors:
    """Subscribes to what pages want.

    Args:
        deliver: called with kind, topic and message, in threads of rospy.
    """

    def __init__(self, deliver: Callable[[str, str, bytes], object]) -> None:
        self._deliver = deliver
        self._subscriptions: dict[tuple[str, str], Subscription] = {}
        self._lock = threading.Lock()

    def set_wanted(self, wanted: set[tuple[str, str]]) -> None:
        """Subscribe to these (type, topic), and to nothing else."""
        with self._lock:
            for key in set(self._subscriptions) - wanted:
                self._subscriptions.pop(key).close()
            for kind, topic in sorted(wanted - set(self._subscriptions)):
                self._subscriptions[kind, topic] = Subscription(topic, kind, self._deliver)

    def last(self, topic: str) -> tuple[str, bytes] | None:
        """Kind and message that were delivered last of a topic."""
        with self._lock:
            items = list(self._subscriptions.items())
        return next((one.last for (_, name), one in items if name == topic), None)

    def close(self) -> None:
        """Subscribe to nothing."""
        self.set_wanted(set())

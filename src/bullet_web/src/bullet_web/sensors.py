"""Camera images and lidar scans for pages: subscribed while a page wants them."""

import json
import math
import struct
import threading
import time
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import rospy
from bullet_sim.pose import Array
from sensor_msgs.msg import Image, LaserScan

IMAGE_RATE = 15.0  # images a second of wall time, at most
SCAN_RATE = 10.0
BUFFER = 1 << 24  # [B] of a subscription: a whole image
MAX_WIDTH = 640  # [px] of an image on a page
JPEG = [int(cv2.IMWRITE_JPEG_QUALITY), 75]
CHANNELS = {  # encoding -> (type, channels, conversion to BGR)
    "rgb8": (np.uint8, 3, cv2.COLOR_RGB2BGR),
    "bgr8": (np.uint8, 3, None),
    "rgba8": (np.uint8, 4, cv2.COLOR_RGBA2BGR),
    "bgra8": (np.uint8, 4, cv2.COLOR_BGRA2BGR),
    "mono8": (np.uint8, 1, None),
    "8UC1": (np.uint8, 1, None),
    "8UC3": (np.uint8, 3, None),
    "mono16": (np.uint16, 1, None),
    "16UC1": (np.uint16, 1, None),
    "32FC1": (np.float32, 1, None),
    "32SC1": (np.int32, 1, None),
}


def packed(head: dict[str, Any], payload: bytes) -> bytes:
    """Binary message for pages: length of the head (uint32), head as JSON, payload.

    The head is padded so that the payload's numbers are aligned in the message.
    """
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<I", len(text)) + text + payload


def picture(message: Any) -> Array:
    """(H, W) or (H, W, 3) uint8, gray or BGR, of a sensor_msgs/Image; distances as gray.

    Raises:
        ValueError: the encoding is not known, or the data is too short.
    """
    if message.encoding not in CHANNELS:
        raise ValueError(f"encoding is {message.encoding!r}, must be one of {', '.join(CHANNELS)}")
    kind, channels, conversion = CHANNELS[message.encoding]
    dtype = np.dtype(kind).newbyteorder(">" if message.is_bigendian else "<")
    height, width = message.height, message.width
    row = width * channels * dtype.itemsize
    if not height or not width or message.step < row or len(message.data) < height * message.step:
        raise ValueError(
            f"the image has {len(message.data)} bytes, {height} rows of {message.step} and a width "
            f"of {width}"
        )
    rows = np.frombuffer(message.data, np.uint8, height * message.step).reshape(height, -1)
    pixels = np.ascontiguousarray(rows[:, :row]).view(dtype).reshape(height, width, channels)
    if dtype.itemsize > 1:
        return stretched(pixels[:, :, 0])
    if conversion is not None:
        return cv2.cvtColor(pixels, conversion)
    return pixels[:, :, 0] if channels == 1 else pixels


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
    """JPEG of a sensor_msgs/Image, at most MAX_WIDTH wide.

    Raises:
        ValueError: it is none that is known.
    """
    pixels = picture(message)
    height, width = pixels.shape[:2]
    if width > MAX_WIDTH:
        size = (MAX_WIDTH, max(1, round(height * MAX_WIDTH / width)))
        pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    done, data = cv2.imencode(".jpg", pixels, JPEG)
    if not done:
        raise ValueError(f"the image of {width} x {height} cannot be encoded")
    return data.tobytes()


def points(message: Any) -> Array:
    """(n, 3) float32 [m] of a sensor_msgs/LaserScan in its frame, where rays have an echo."""
    ranges = np.asarray(message.ranges, np.float32)
    angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
    hit = np.isfinite(ranges) & (ranges >= message.range_min) & (ranges <= message.range_max)
    found = np.zeros((int(hit.sum()), 3), np.float32)
    found[:, 0] = ranges[hit] * np.cos(angles[hit])
    found[:, 1] = ranges[hit] * np.sin(angles[hit])
    return found


def image_message(message: Any) -> bytes:
    """What pages get of an image."""
    return packed({"type": "image"}, jpeg(message))


def scan_message(message: Any) -> bytes:
    """What pages get of a scan; `frame` is the link, without its model."""
    frame = message.header.frame_id.rpartition("/")[2]
    if not math.isfinite(message.angle_min) or not math.isfinite(message.angle_increment):
        raise ValueError(f"angles are {message.angle_min}, {message.angle_increment}")
    return packed({"type": "points", "frame": frame}, points(message).tobytes())


TYPES = {  # what a page wants -> (kind of message, type, most a second, conversion)
    "camera": ("image", Image, IMAGE_RATE, image_message),
    "lidar": ("points", LaserScan, SCAN_RATE, scan_message),
}


class Subscription:
    """One topic that pages want, converted once for all of them."""

    def __init__(self, topic: str, want: str, deliver: Callable[[str, str, bytes], object]) -> None:
        self.topic = topic
        self._deliver = deliver
        self._kind, message, rate, self._convert = TYPES[want]
        self._period, self._last = 1.0 / rate, -math.inf
        self._problem = ""
        self._converting, self._closed = threading.Lock(), False
        self._subscriber = rospy.Subscriber(
            topic, message, self._receive, queue_size=1, buff_size=BUFFER
        )

    def _receive(self, message: Any) -> None:
        now = time.monotonic()
        if now - self._last < self._period:
            return
        self._last = now
        try:
            with self._converting:
                if self._closed:
                    return
                converted = self._convert(message)
            self._deliver(self._kind, self.topic, converted)
        except ValueError as error:
            if str(error) != self._problem:  # once
                self._problem = str(error)
                rospy.logwarn("%s cannot be shown: %s", self.topic, error)

    def close(self) -> None:
        """Unsubscribe; no message is being converted afterwards."""
        self._subscriber.unregister()
        with self._converting:
            self._closed = True


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
        """Subscribe to these (camera or lidar, topic), and to nothing else."""
        with self._lock:
            for key in set(self._subscriptions) - wanted:
                self._subscriptions.pop(key).close()
            for want, topic in sorted(wanted - set(self._subscriptions)):
                self._subscriptions[want, topic] = Subscription(topic, want, self._deliver)

    def close(self) -> None:
        """Subscribe to nothing; no message is being converted afterwards."""
        self.set_wanted(set())

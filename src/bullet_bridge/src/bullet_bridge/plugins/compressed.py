"""Images compressed as JPEG or PNG: the topic that image_transport has beside an image, and the
files of a camera's <save>."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import rospy
from bullet_sim.pose import Array
from paddock_common.reconfigure import describe
from sensor_msgs.msg import CompressedImage

from bullet_bridge.transport import conversions

if TYPE_CHECKING:
    from bullet_bridge.plugins.base import RosPart

_COLORS = {  # of encodings of sensor_msgs: how they become OpenCV's order
    "rgb8": cv2.COLOR_RGB2BGR,
    "rgb16": cv2.COLOR_RGB2BGR,
    "bgr8": None,
}
JPEG, PNG = "jpeg", "png"
CONFIG = describe(  # compressed_image_transport/CompressedPublisher.cfg
    [
        ("format", "str", JPEG, "", "", "Compression format: jpeg or png."),
        ("jpeg_progressive", "bool", False, False, True, "Progressive JPEG."),
        ("jpeg_quality", "int", 80, 1, 100, "JPEG quality percentile."),
        ("jpeg_optimize", "bool", False, False, True, "Optimized Huffman tables of JPEG."),
        ("jpeg_restart_interval", "int", 0, 0, 65535, "JPEG restart interval; 0: none."),
        ("png_level", "int", 9, 1, 9, "PNG compression level."),
    ]
)


def compress(pixels: Array, encoding: str, config: Any) -> tuple[str, bytes]:
    """An image as compressed_image_transport compresses it.

    Args:
        pixels: (H, W) or (H, W, 3), in the encoding.
        encoding: of sensor_msgs.
        config: values of CONFIG by their names.

    Returns:
        Its format, such as "rgb8; jpeg compressed bgr8", and the file.
    """
    is_color, is_png = encoding in _COLORS, config["format"] == PNG
    if _COLORS.get(encoding) is not None:
        pixels = cv2.cvtColor(pixels, _COLORS[encoding])
    if pixels.dtype != np.uint8 and not is_png:  # which JPEG does not have
        pixels = (pixels >> 8).astype(np.uint8)
    if is_png:
        file, options = ".png", [cv2.IMWRITE_PNG_COMPRESSION, config["png_level"]]
    else:
        file = ".jpg"
        options = [
            *(cv2.IMWRITE_JPEG_QUALITY, config["jpeg_quality"]),
            *(cv2.IMWRITE_JPEG_PROGRESSIVE, int(config["jpeg_progressive"])),
            *(cv2.IMWRITE_JPEG_OPTIMIZE, int(config["jpeg_optimize"])),
            *(cv2.IMWRITE_JPEG_RST_INTERVAL, config["jpeg_restart_interval"]),
        ]
    kind = f"bgr{8 * pixels.itemsize}" if is_color else ""
    _, data = cv2.imencode(file, pixels, options)
    return f"{encoding}; {PNG if is_png else JPEG} compressed {kind}", data.tobytes()


class CompressedImages:
    """TOPIC/compressed of an image's topic, with its parameters by dynamic_reconfigure.

    Args:
        part: whose topic it is; it closes this one, too.
    """

    def __init__(self, part: RosPart, topic: str, frame: str, encoding: str) -> None:
        self._frame, self._encoding = frame, encoding
        self._config: dict[str, Any] = dict(CONFIG.defaults)
        name = f"{topic}/compressed"
        self._publisher = part.publisher(name, CompressedImage, relayed=False)
        part.reconfigure(name, CONFIG, self._config, self._on_config)

    def _on_config(self, config: Any, _level: int) -> Any:
        if config["format"] not in (JPEG, PNG):
            rospy.logwarn("format is %r, must be jpeg or png; it stays", config["format"])
            config["format"] = self._config["format"]
        self._config = {name: config[name] for name in CONFIG.defaults}
        return config

    def publish(self, time: float, pixels: Array) -> None:
        """Publish an image in the encoding, of a simulated time [s], if there are subscribers."""
        if self._publisher.get_num_connections() > 0:
            kind, data = compress(pixels, self._encoding, self._config)
            header = conversions.header(time, self._frame)
            self._publisher.publish(CompressedImage(header=header, format=kind, data=data))


JPEG_QUALITY = 75  # of saved images, as FreeImage has it by default


class SavedImages:
    """Writes a camera's images to numbered files, as Gazebo's Camera does.

    Args:
        folder: made when the first image is written; relative to the node's working directory.
        name: of the files, before their number.
    """

    def __init__(self, folder: str, name: str) -> None:
        self._folder, self._name, self._count = folder, name, 0

    def write(self, rgb: Array) -> None:
        """Write one (H, W, 3) uint8 RGB; what cannot be written is an error in the log."""
        path = os.path.join(self._folder, f"{self._name}-{self._count:04d}.jpg")
        self._count += 1
        try:
            os.makedirs(self._folder, exist_ok=True)
            quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
            data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), quality)[1]
            with open(path, "wb") as file:
                file.write(data.tobytes())
        except OSError as error:
            rospy.logerr_throttle(60.0, f"image '{path}' of <save> cannot be written: {error}")

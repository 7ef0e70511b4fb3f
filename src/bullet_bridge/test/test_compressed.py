"""Compressed images, as compressed_image_transport makes them."""

import cv2
import numpy as np
import pytest
from bullet_bridge.plugins.compressed import CONFIG, CompressedImages, compress
from bullet_sim.sensors import camera
from fake_impl import FakeServer, Topic

RGB = np.zeros((24, 32, 3), np.uint8)
RGB[:, :16], RGB[:, 16:] = (200, 40, 10), (10, 90, 220)


@pytest.mark.parametrize(
    "encoding, config, name",
    [
        ("rgb8", {}, "rgb8; jpeg compressed bgr8"),
        ("bgr8", {}, "bgr8; jpeg compressed bgr8"),
        ("rgb16", {}, "rgb16; jpeg compressed bgr8"),
        ("mono8", {}, "mono8; jpeg compressed "),
        ("mono16", {}, "mono16; jpeg compressed "),
        ("bayer_rggb8", {}, "bayer_rggb8; jpeg compressed "),
        ("rgb8", {"format": "png"}, "rgb8; png compressed bgr8"),
        ("rgb16", {"format": "png"}, "rgb16; png compressed bgr16"),
        ("mono16", {"format": "png", "png_level": 1}, "mono16; png compressed "),
    ],
)
def test_formats(encoding, config, name):
    pixels = camera.pixels(RGB, encoding)
    kind, data = compress(pixels, encoding, {**CONFIG.defaults, **config})
    assert kind == name
    seen = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if "color" in name or "bgr" in name.split("compressed ")[1]:
        scale = 257.0 if seen.dtype == np.uint16 else 1.0
        assert seen[12, 4] == pytest.approx(np.array((10, 40, 200)) * scale, abs=12 * scale)
    else:
        assert seen.ndim == 2 and seen.shape == pixels.shape


def test_a_lower_quality_is_smaller():
    noise = np.random.default_rng(1).integers(0, 256, (48, 64, 3), np.uint8)
    sizes = [
        len(compress(noise, "rgb8", {**CONFIG.defaults, "jpeg_quality": quality})[1])
        for quality in (10, 80, 100)
    ]
    assert sizes == sorted(sizes) and sizes[0] < sizes[2] / 3


class Part:
    """Stands in for a camera's plugin."""

    def publisher(self, name, kind, relayed):
        assert not relayed
        self.topic = Topic(name, kind)
        return self.topic

    def reconfigure(self, namespace, config, values, callback):
        self.server = FakeServer(config, values, callback, namespace)
        self.callback = callback


def test_it_is_made_for_subscribers_alone_with_the_image_s_header():
    part = Part()
    images = CompressedImages(part, "/cam/image_raw", "eye", "rgb8")
    part.topic.subscribers = 0
    images.publish(1.5, RGB)
    assert part.topic.messages == [] and part.topic.name == "/cam/image_raw/compressed"
    part.topic.subscribers = 1
    images.publish(1.5, RGB)
    (message,) = part.topic.messages
    assert message.header.frame_id == "eye" and message.header.stamp.to_sec() == 1.5
    assert bytes(message.data[:3]) == b"\xff\xd8\xff"
    part.callback(dict(CONFIG.defaults, format="png"), 1)
    images.publish(1.6, RGB)
    assert bytes(part.topic.messages[-1].data[1:4]) == b"PNG"
    changed = part.callback(dict(CONFIG.defaults, format="tiff"), 1)
    assert changed["format"] == "png", "one that is not there changes nothing"

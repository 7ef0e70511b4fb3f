"""Camera images and scans as pages get them."""

import json
import struct

import cv2
import numpy as np
import pytest
from bullet_web.sensors import image_message, jpeg, packed, picture, points, scan_message
from sensor_msgs.msg import Image, LaserScan


def image(encoding, values, step=None):
    """A message of an array (H, W, ...)."""
    height, width = values.shape[:2]
    row = values.nbytes // height
    step = step or row
    padded = np.zeros((height, step), np.uint8)
    padded[:, :row] = values.reshape(height, -1).view(np.uint8)
    return Image(height=height, width=width, encoding=encoding, step=step, data=padded.tobytes())


def unpacked(message):
    """Head and payload of a binary message."""
    (length,) = struct.unpack_from("<I", message)
    assert length % 4 == 0
    return json.loads(message[4 : 4 + length]), message[4 + length :]


def test_colors_come_out_as_blue_green_red():
    values = np.zeros((4, 6, 3), np.uint8)
    values[:, :, 0] = 200
    assert picture(image("rgb8", values))[0, 0].tolist() == [0, 0, 200]
    assert picture(image("bgr8", values, step=32))[3, 5].tolist() == [200, 0, 0]
    four = np.dstack([values, np.full((4, 6), 255, np.uint8)])
    assert picture(image("rgba8", four))[0, 0].tolist() == [0, 0, 200]
    assert picture(image("mono8", values[:, :, 0]))[1, 1] == 200


def test_distances_become_gray():
    values = np.array([[1.0, 3.0], [np.nan, np.inf]], np.float32)
    gray = picture(image("32FC1", values))
    assert gray.dtype == np.uint8
    assert gray[0].tolist() == [0, 255]
    assert picture(image("32FC1", np.full((2, 2), np.nan, np.float32))).max() == 0


def test_a_wide_image_is_made_smaller():
    head, data = unpacked(image_message(image("rgb8", np.full((480, 1280, 3), 90, np.uint8))))
    assert head == {"type": "image"}
    decoded = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert decoded.shape == (240, 640, 3)
    assert abs(int(decoded.mean()) - 90) <= 2


@pytest.mark.parametrize(
    "message, reason",
    [
        (Image(encoding="yuv9"), "encoding is 'yuv9', must be one of rgb8, bgr8"),
        (
            Image(encoding="rgb8", height=2, width=2, step=6, data=bytes(11)),
            "the image has 11 bytes",
        ),
        (Image(encoding="rgb8", height=2, width=2, step=5, data=bytes(12)), "2 rows of 5"),
        (Image(encoding="rgb8"), "the image has 0 bytes"),
    ],
)
def test_images_that_cannot_be_shown(message, reason):
    with pytest.raises(ValueError, match=reason):
        jpeg(message)


def test_points_lie_where_the_rays_end():
    scan = LaserScan(
        angle_min=0.0,
        angle_increment=np.pi / 2,
        range_min=0.1,
        range_max=10.0,
        ranges=[2.0, 3.0, np.inf, 0.05, np.nan, 11.0],
    )
    scan.header.frame_id = "racecar/laser"
    assert points(scan) == pytest.approx(np.array([[2, 0, 0], [0, 3, 0]]), abs=1e-6)
    head, data = unpacked(scan_message(scan))
    assert head == {"type": "points", "frame": "laser"}
    assert len(data) == 2 * 3 * 4


def test_scans_without_angles_are_refused():
    with pytest.raises(ValueError, match="angles are nan"):
        scan_message(LaserScan(angle_min=np.nan))


@pytest.mark.parametrize("frame", ["a", "abcde", "ü"])
def test_numbers_are_aligned_behind_any_head(frame):
    head, data = unpacked(packed({"frame": frame}, b"1234"))
    assert (head, data) == ({"frame": frame}, b"1234")

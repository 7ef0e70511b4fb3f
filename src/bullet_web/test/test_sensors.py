"""Camera images and scans as pages get them."""

import json
import struct

import cv2
import numpy as np
import pytest
from bullet_web.sensors import (
    CONE_RAYS,
    MAX_POINTS,
    cloud_ends,
    cone_ends,
    image_message,
    jpeg,
    packed,
    picture,
    points_message,
    scan_ends,
)
from sensor_msgs.msg import Image, LaserScan, PointCloud2, PointField, Range


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
    assert picture(image("rgb16", values.astype(np.uint16) * 257))[0, 0].tolist() == [0, 0, 200]


@pytest.mark.parametrize("order", ["rggb", "bggr", "gbrg", "grbg"])
def test_a_bayer_pattern_becomes_a_color(order):
    color = dict(r=200, g=100, b=50)
    mosaic = np.tile(np.array([color[c] for c in order], np.uint8).reshape(2, 2), (4, 4))
    assert picture(image(f"bayer_{order}8", mosaic))[4, 4].tolist() == [50, 100, 200]


def test_distances_become_gray():
    values = np.array([[1.0, 3.0], [np.nan, np.inf]], np.float32)
    gray = picture(image("32FC1", values))
    assert gray.dtype == np.uint8
    assert gray[0].tolist() == [0, 255]
    assert picture(image("32FC1", np.full((2, 2), np.nan, np.float32))).max() == 0


@pytest.mark.parametrize(
    "size, shown",
    [((480, 1280), (240, 640)), ((1, 70_000), (1, 640)), ((131_000, 2), (65_500, 1))],
)
def test_an_image_is_at_most_as_large_as_a_page_and_jpeg_take(size, shown):
    head, data = unpacked(image_message(image("rgb8", np.full((*size, 3), 90, np.uint8))))
    assert head == {"type": "image"}
    decoded = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert decoded.shape == (*shown, 3)
    assert abs(int(decoded.mean()) - 90) <= 2


@pytest.mark.parametrize(
    "message, reason",
    [
        (Image(encoding="yuv9"), "encoding is 'yuv9', must be one of sensor_msgs"),
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


def test_rays_end_at_their_echo_or_at_the_largest_range():
    scan = LaserScan(
        angle_min=0.0,
        angle_increment=np.pi / 2,
        range_min=0.1,
        range_max=10.0,
        ranges=[2.0, 3.0, np.inf, 0.05, np.nan, 11.0],
    )
    scan.header.frame_id = "racecar/laser"
    hits, misses = scan_ends(scan)
    assert hits == pytest.approx(np.array([[2, 0, 0], [0, 3, 0]]), abs=1e-6)
    assert misses == pytest.approx(np.array([[-10, 0, 0], [0, 10, 0]]), abs=1e-5)
    head, data = unpacked(points_message(scan, scan_ends))
    assert head == {"type": "points", "frame": "laser", "hits": 2}
    assert np.frombuffer(data, "<f4").reshape(4, 3) == pytest.approx(np.vstack([hits, misses]))
    scan.range_max = np.inf
    assert len(scan_ends(scan)[1]) == 0


def test_scans_without_angles_are_refused():
    with pytest.raises(ValueError, match="angles are nan"):
        scan_ends(LaserScan(angle_min=np.nan))


def test_a_sonar_is_a_fan_of_rays():
    sonar = Range(field_of_view=np.pi / 2, min_range=0.1, max_range=4.0, range=2.0)
    hits, misses = cone_ends(sonar)
    assert (len(hits), len(misses)) == (CONE_RAYS, 0)
    assert np.hypot(hits[:, 0], hits[:, 1]) == pytest.approx(2.0)
    assert hits[0] == pytest.approx([np.sqrt(2), -np.sqrt(2), 0], abs=1e-6)
    sonar.range = np.inf
    hits, misses = cone_ends(sonar)
    assert len(hits) == 0 and misses[CONE_RAYS // 2] == pytest.approx([4, 0, 0])
    with pytest.raises(ValueError, match="field_of_view is nan"):
        cone_ends(Range(field_of_view=np.nan))


def cloud(values, names=("intensity", "x", "y", "z"), big=False, padding=4):
    """A PointCloud2 of rows (n, fields), as one row of points with bytes after each."""
    step = 4 * len(names) + padding
    table = np.zeros((len(values), step), np.uint8)
    order = ">f4" if big else "<f4"
    numbers = np.ascontiguousarray(np.asarray(values, order))
    table[:, : 4 * len(names)] = numbers.view(np.uint8).reshape(len(values), -1)
    fields = [PointField(name, 4 * k, PointField.FLOAT32, 1) for k, name in enumerate(names)]
    return PointCloud2(
        height=1,
        width=len(values),
        fields=fields,
        is_bigendian=big,
        point_step=step,
        row_step=step * len(values),
        data=table.tobytes(),
    )


@pytest.mark.parametrize("big", [False, True])
def test_a_cloud_keeps_its_finite_points(big):
    hits, misses = cloud_ends(cloud([(9, 1, 2, 3), (9, np.nan, 0, 0), (9, 4, 5, 6)], big=big))
    assert hits.tolist() == [[1, 2, 3], [4, 5, 6]] and len(misses) == 0
    assert hits.dtype == np.float32


def test_a_large_cloud_is_thinned():
    hits, _ = cloud_ends(cloud(np.ones((3 * MAX_POINTS + 1, 4))))
    assert MAX_POINTS / 2 < len(hits) <= MAX_POINTS


def test_clouds_that_cannot_be_shown():
    with pytest.raises(ValueError, match="must have x, y and z"):
        cloud_ends(cloud([(1, 2)], names=("x", "y")))
    short = cloud([(9, 1, 2, 3), (9, 4, 5, 6)])
    short.data = short.data[:-1]
    with pytest.raises(ValueError, match="the cloud has 39 bytes, 1 rows of 40 and 2 points of 20"):
        cloud_ends(short)
    narrow = cloud([(9, 1, 2, 3)])
    narrow.point_step = 4
    with pytest.raises(ValueError, match="points of 4"):
        cloud_ends(narrow)


@pytest.mark.parametrize("frame", ["a", "abcde", "ü"])
def test_numbers_are_aligned_behind_any_head(frame):
    head, data = unpacked(packed({"frame": frame}, b"1234"))
    assert (head, data) == ({"frame": frame}, b"1234")

"""A pinhole camera: intrinsics, OpenGL matrices and pixel noise.

Frames: the camera frame is Gazebo's (x along the view, y left, z up); the optical frame is
REP 103's (x right, y down, z along the view). Both have the same origin.

Pixels: integer coordinates are pixel centers, (0, 0) is the center of the top left pixel, as
in OpenCV and image_geometry. OpenGL puts the optical axis at the center of the image, which
is ((width - 1) / 2, (height - 1) / 2) in these coordinates. camera_info has what Gazebo's plugins
write there, ((width + 1) / 2, (height + 1) / 2), one pixel off the image.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from bullet_sim.pose import Array, Vector

FAR_DEPTH = np.float32(0.9999998)  # depth buffer value at and beyond which nothing was rendered
MAX_SIDE, MAX_PIXELS = 16384, 2**26  # of an image: what OpenGL takes, and 200 MB


def check(width: int, height: int, horizontal_fov: float, near: float, far: float) -> None:
    """Raise ValueError, naming the value, when no image could be rendered with these.

    Args:
        width, height: [px].
        horizontal_fov: [rad].
        near, far: clip distances [m].
    """
    if int(width) != width or int(height) != height or width < 1 or height < 1:
        raise ValueError(f"camera size {width}x{height}: whole numbers >= 1 are expected")
    if max(width, height) > MAX_SIDE or width * height > MAX_PIXELS:
        raise ValueError(
            f"camera size {width}x{height}: at most {MAX_SIDE} a side and {MAX_PIXELS} pixels "
            "are expected"
        )
    if not 0.0 < horizontal_fov < math.pi:
        raise ValueError(f"horizontal_fov {horizontal_fov}: 0 < horizontal_fov < pi rad expected")
    if not 0.0 < near < far < math.inf:
        raise ValueError(f"clip near {near}, far {far}: 0 < near < far m is expected")


def intrinsics(width: int, height: int, horizontal_fov: float) -> Array:
    """Pinhole matrix K in the optical frame, square pixels.

    fx = width / (2 tan(horizontal_fov / 2)), fy = fx (sensor_msgs/CameraInfo's K).

    Args:
        width, height: [px].
        horizontal_fov: between the left and the right edge of the image [rad].

    Returns:
        K (3, 3) float64 [px].
    """
    focal = width / (2.0 * math.tan(horizontal_fov / 2.0))
    return np.array(
        [[focal, 0.0, (width - 1) / 2.0], [0.0, focal, (height - 1) / 2.0], [0.0, 0.0, 1.0]]
    )


def shown_intrinsics(width: int, height: int, horizontal_fov: float, given: Any = None) -> Array:
    """What an image shows, from its upper left corner [px], which is half a pixel off K.

    Args:
        width, height: [px].
        horizontal_fov: [rad].
        given: plugins.cameras.Intrinsics that replace the angle; None: none do.

    Returns:
        (2, 3): column and row of (x/z, y/z, 1) of the optical frame.
    """
    if given is not None:
        return np.array([[given.fx, -given.s, given.cx], [0.0, given.fy, given.cy]])
    focal = width / (2.0 * math.tan(horizontal_fov / 2.0))
    return np.array([[focal, 0.0, width / 2.0], [0.0, focal, height / 2.0]])


def camera_info_arrays(
    width: int,
    height: int,
    horizontal_fov: float,
    distortion: Sequence[float] = (),
    focal_length: float = 0.0,
    center: tuple[float, float] = (0.0, 0.0),
) -> tuple[Array, Array, Array, Array]:
    """D, K, R and P of a sensor_msgs/CameraInfo ('plumb_bob').

    Args:
        width, height: [px].
        horizontal_fov: [rad].
        distortion: (k1, k2, p1, p2, k3) of the lens; (): zeros.
        focal_length, center: [px]; 0: that of the pinhole, half the image's size and half a pixel.

    Returns:
        (D (5,), K (9,), R (9,), P (12,)) float64, row-major.
    """
    k = intrinsics(width, height, horizontal_fov)
    k[0, 0] = k[1, 1] = focal_length or k[0, 0]
    k[0, 2], k[1, 2] = center[0] or (width + 1) / 2.0, center[1] or (height + 1) / 2.0
    p = np.hstack([k, np.zeros((3, 1))])
    d = np.array(distortion, float) if distortion else np.zeros(5)
    return d, k.ravel(), np.eye(3).ravel(), p.ravel()


def view_matrix(position: Vector, rotation: Array) -> tuple[float, ...]:
    """OpenGL view matrix of a camera that looks along its +x with +z up.

    Args:
        position: (3,) [m], camera in the world.
        rotation: (3, 3), camera frame in the world.

    Returns:
        16 floats, column-major: world -> eye (x right, y up, looking along -z).
    """
    forward, left, up = np.asarray(rotation, dtype=float).T
    view = np.eye(4)
    view[:3, :3] = -left, up, -forward
    view[:3, 3] = -view[:3, :3] @ np.asarray(position, dtype=float)
    return tuple(view.T.ravel())


def projection_matrix(
    horizontal_fov: float,
    aspect: float,
    near: float,
    far: float,
    shift: tuple[float, float] = (0.0, 0.0),
    shown: Array | None = None,
) -> tuple[float, ...]:
    """OpenGL perspective matrix (glFrustum's).

    Args:
        horizontal_fov: [rad].
        aspect: width / height.
        near, far: clip distances along the optical axis [m].
        shift: moves the image right and down, in widths and heights of the image.
        shown: (2, 3) as shown_intrinsics, in widths and heights; None: what the angle shows.

    Returns:
        16 floats, column-major.
    """
    x = 1.0 / math.tan(horizontal_fov / 2.0)
    depth = near - far
    skew = 0.0
    y, right, down = x * aspect, -2.0 * shift[0], 2.0 * shift[1]
    if shown is not None:
        (x, skew, center_x), (_, y, center_y) = (2.0 * np.asarray(shown)).tolist()
        skew = -skew  # the eye has y up
        right, down = right + 1.0 - center_x, down + center_y - 1.0
    return (
        *(x, 0.0, 0.0, 0.0),
        *(skew, y, 0.0, 0.0),
        *(right, down, (far + near) / depth, -1.0),
        *(0.0, 0.0, 2.0 * far * near / depth, 0.0),
    )


def meters_from_buffer(buffer: Array, near: float, far: float) -> Array:
    """Distances along the optical axis of an OpenGL depth buffer.

    The inverse of projection_matrix: d = (1/near - 1/z) / (1/near - 1/far).

    Args:
        buffer: (H, W) float32, 0 at the near plane ... 1 at the far plane.
        near, far: clip distances [m].

    Returns:
        (H, W) float32 [m]; far where nothing was rendered.
    """
    wide = np.asarray(buffer, dtype=np.float64)
    distance = near * far / (far - wide * (far - near))
    return np.where(wide >= FAR_DEPTH, far, distance).astype(np.float32)


def points(depth: Array, k: Array, out: Array | None = None) -> Array:
    """Points of a depth image in the optical frame.

    Args:
        depth: (H, W) float32 [m] along the optical axis; NaN stays NaN.
        k: (3, 3) [px].
        out: where they are written.

    Returns:
        (H, W, 3) float32 [m].
    """
    height, width = depth.shape
    right = (np.arange(width, dtype=np.float32) - np.float32(k[0, 2])) / np.float32(k[0, 0])
    down = (np.arange(height, dtype=np.float32) - np.float32(k[1, 2])) / np.float32(k[1, 1])
    if out is None:
        out = np.empty((height, width, 3), np.float32)
    np.multiply(right, depth, out=out[..., 0])
    np.multiply(down[:, None], depth, out=out[..., 1])
    out[..., 2] = depth
    return out


def within(depth: Array, low: float, high: float) -> Array:
    """A depth image with NaN where it is not low < depth < high [m]."""
    return np.where((depth > low) & (depth < high), depth, np.float32(np.nan))


def add_noise(rgb: Array, stddev: float, rng: Any, mean: float = 0.0) -> Array:
    """Gaussian noise, as in Gazebo the same on all channels of a pixel, cut off at 0 and 255.

    Args:
        rgb: (H, W, 3) uint8.
        stddev: of the full scale, 0.007 is 1.8 gray levels (Gazebo's unit); 0 = no noise.
        rng: numpy.random.Generator, or None when stddev is 0.
        mean: of the noise, of the full scale.

    Returns:
        (H, W, 3) uint8; `rgb` itself without noise.
    """
    if stddev <= 0.0 and not mean:
        return rgb
    noise = np.zeros((*rgb.shape[:2], 1), np.float32)
    if stddev > 0.0:
        noise = rng.standard_normal(noise.shape, dtype=np.float32)
        noise *= np.float32(stddev * 255.0)
    noise += np.float32(mean * 255.0)
    noisy = rgb + noise
    np.rint(noisy, out=noisy)
    np.clip(noisy, 0, 255, out=noisy)
    return noisy.astype(np.uint8)


SIXTEEN_BITS = 257  # 65535 / 255


def pixels(rgb: Array, encoding: str) -> Array:
    """An (H, W, 3) uint8 RGB array in an encoding of sensor_msgs, contiguous.

    Args:
        encoding: rgb8, bgr8, mono8 or 8UC1 (Rec. 601 luma), mono16 and rgb16 (from 0 to 65535), or
            bayer_rggb8 and so on (one color a pixel: those of the first two rows and columns).
    """
    if encoding == "bgr8":
        return cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)
    if encoding.startswith("bayer_"):
        mosaic = np.empty(rgb.shape[:2], np.uint8)
        for place, color in enumerate(encoding[6:10]):
            of_color = np.s_[place // 2 :: 2, place % 2 :: 2]
            mosaic[of_color] = rgb[..., "rgb".index(color)][of_color]
        return mosaic
    if encoding in ("mono8", "8UC1", "mono16"):
        luma = rgb @ np.array((0.299, 0.587, 0.114))
        if encoding == "mono16":
            return np.rint(luma * SIXTEEN_BITS).astype("<u2")
        rgb = np.rint(luma).astype(np.uint8)
    if encoding == "rgb16":
        return rgb.astype("<u2") * np.uint16(SIXTEEN_BITS)
    return np.ascontiguousarray(rgb)


def depth_pixels(depth: Array, millimeters: bool) -> Array:
    """Depths (H, W) float32 [m], NaN: unknown, as an image's: 32FC1 [m], or 16UC1.

    Args:
        millimeters: 16UC1 [mm] and 0 for unknown; as in Gazebo parts of a millimeter are cut off.
    """
    if not millimeters:
        return depth.astype("<f4")
    data = np.nan_to_num(depth.astype(float) * 1000.0, nan=0.0, posinf=0.0, neginf=0.0)
    return np.clip(data, 0, 65535).astype("<u2")

"""Detects the dashed center line in a camera image and projects it onto the ground.

In a hairpin the line leaves the image; its position is then computed from the lane's white
border, half a lane away.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from paddock_common.settings import Checked, Number, number, read

from deepracer_control.drivers.pursuit import arc_curvature

MAX_RANGE = 1.6  # of the points from the rear axle [m]
RINGS = 0.09  # spacing of the rings in which the line is searched [m]
WINDOW = 0.22  # maximum distance of a line's point from its expected position [m]
MIN_PIXELS = 6  # in a ring for a detection
WHITE_LOW, WHITE_HIGH = np.array((0, 0, 170), np.uint8), np.array((180, 50, 255), np.uint8)


@dataclass(frozen=True)
class Mount(Checked, prefix="camera_"):
    """Pose of the camera, from the ground under the rear axle's center; x ahead.

    Attributes:
        ahead, height: [m].
        pitch: Downward tilt of the optical axis [rad].
    """

    # The DeepRacer's mast and lens; its chassis rests nose up by 0.024 rad.
    ahead: float = number(0.227, unit="m")
    height: float = number(0.127, above=0.0, unit="m")
    pitch: float = number(0.2375, above=-1.5, below=1.5, unit="rad")


def ground_points(width, height, matrix, mount: Mount, scale=1):
    """Projects pixel centers onto the ground.

    Args:
        width, height: Size of the image [px].
        matrix: Nine numbers K of CameraInfo, row by row.
        scale: Use only every scale-th pixel in both directions.

    Returns:
        (H, W, 2) x ahead of the rear axle, y to the left [m]; nan at and above the horizon.
    """
    fx, cx, fy, cy = matrix[0], matrix[2], matrix[4], matrix[5]
    u, v = np.meshgrid(
        np.arange(0, width, scale) + 0.5 * scale, np.arange(0, height, scale) + 0.5 * scale
    )
    right, down = (u - cx) / fx, (v - cy) / fy
    cosine, sine = math.cos(mount.pitch), math.sin(mount.pitch)
    descent = sine + down * cosine  # of the ray, per unit along the optical axis
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(descent > 1e-3, mount.height / descent, np.nan)
    return np.stack([mount.ahead + depth * (cosine - down * sine), -depth * right], axis=2)


def ring_chain(points, expected, lookahead, first=0.15):
    """Follows a line outwards, ring by ring around the rear axle.

    Args:
        points: (N, 2) ground points that have the line's color [m].
        expected: Function radius [m] -> expected point (2,) of the first ring.
        lookahead: Where to stop [m].
        first: Added to the window of the first ring [m].

    Returns:
        List of (2,) means of the line's points, from near to far; empty: no detection.
    """
    distance = np.hypot(points[:, 0], points[:, 1])
    chain = []
    for radius in np.arange(0.36, MAX_RANGE, RINGS):
        if not chain:
            position = expected(radius)
        else:  # straight ahead along the detected points
            step = chain[-1] - chain[-2] if len(chain) > 1 else chain[-1]
            gap = radius - np.hypot(*chain[-1])
            position = chain[-1] + step / max(np.hypot(*step), 1e-6) * gap
        near = points[np.abs(distance - radius) < RINGS / 2.0]
        near = near[np.hypot(*(near - position).T) < WINDOW + (0.0 if chain else first)]
        if len(near) >= MIN_PIXELS:
            chain.append(near.mean(axis=0))
            if np.hypot(*chain[-1]) >= lookahead:
                break
        elif chain and radius - np.hypot(*chain[-1]) > 0.35:
            break
    return chain


def on_arc(radius, curvature):
    """Returns the point (2,) at a distance [m] on the arc that is driven with a curvature."""
    angle = math.asin(max(-0.99, min(0.99, curvature * radius / 2.0)))
    return radius * np.array((math.cos(angle), math.sin(angle)))


class LineVision:
    """Detects the goal point on the line.

    Args:
        hue, saturation, value: (low, high) of the line's color in OpenCV's HSV: 0..180, 0..255.
        lookahead: Distance of the goal from the rear axle [m].
        half_lane: Line to border [m], until both have been detected together.
    """

    def __init__(
        self,
        mount: Mount = Mount(),
        hue=(8, 25),
        saturation=(120, 255),
        value=(90, 255),
        lookahead=0.55,
        half_lane=0.365,
    ):
        Number(min=0.4, max=MAX_RANGE, unit="m").check("lookahead", lookahead)
        self._mount, self._lookahead, self._first_half = mount, lookahead, half_lane
        self._low, self._high = (
            np.array(limits, np.uint8) for limits in zip(hue, saturation, value)
        )
        self._ground = self._key = None
        self.restart()

    def restart(self):
        """Resets the tracked line."""
        self._side = 0.0  # of the line at the nearest ring in the last image [m]
        self._curvature = 0.0  # of the arc to the last goal [1/m]
        self._half = self._first_half

    def find_goal(self, image, matrix):
        """Detects the line.

        Args:
            image: (H, W, 3) uint8 BGR.
            matrix: K of CameraInfo.

        Returns:
            (x ahead, y left) of the goal point from the rear axle [m], or None: neither line nor
            border detected.
        """
        height, width = image.shape[:2]
        scale = 2 if width >= 480 else 1
        key = (width, height, tuple(matrix))
        if key != self._key:
            ground = ground_points(width, height, matrix, self._mount, scale)
            rows = np.nonzero(
                np.nanmin(np.where(np.isnan(ground[:, :, 0]), np.inf, ground[:, :, 0]), axis=1)
                < MAX_RANGE
            )[0]
            self._top = int(rows[0]) if len(rows) else 0
            self._ground, self._key = ground[self._top :], key
        hsv = cv2.cvtColor(image[::scale, ::scale][self._top :], cv2.COLOR_BGR2HSV)
        goal = self._goal(
            self._points(cv2.inRange(hsv, self._low, self._high)),
            self._points(cv2.inRange(hsv, WHITE_LOW, WHITE_HIGH)),
        )
        if goal is None:
            return None
        self._curvature = arc_curvature(*goal)
        return tuple(map(float, goal))

    def _points(self, mask):
        points = self._ground[mask > 0]
        return points[np.isfinite(points).all(axis=1)]

    def _goal(self, orange, white):
        def start(radius):
            side = max(-radius, min(radius, self._side))
            return np.array((math.sqrt(radius**2 - side**2), side))

        chain = ring_chain(orange, start, self._lookahead)
        borders = [self._border(white, side) for side in (1.0, -1.0)]
        if chain:
            self._side = float(chain[0][1])
            self._update_half_width(chain, borders)
            return chain[-1]
        goals = [
            goal
            for border, side in zip(borders, (1.0, -1.0))
            if (goal := self._line_from_border(border, side)) is not None
        ]
        if not goals:
            return None
        self._side = 0.0
        return max(goals, key=lambda goal: goal[0])[1]

    def _border(self, white, side):
        """Returns the chain of the border left (side 1) or right (-1) of the driven arc."""
        bearing = np.arctan2(white[:, 1], white[:, 0])
        arc = np.arcsin(np.clip(self._curvature * np.hypot(*white.T) / 2.0, -0.99, 0.99))
        points = white[side * (bearing - arc) > 0.0]

        def start(radius):
            return on_arc(radius, self._curvature) + side * np.array((0.0, self._half))

        return ring_chain(points, start, self._lookahead + 0.3, 0.3)

    def _line_from_border(self, border, side):
        """Returns (number of rings, point half a lane from a border at the lookahead) or None."""
        if len(border) < 2:
            return None
        border = np.array(border)
        ahead = np.gradient(border, axis=0)
        ahead /= np.maximum(np.linalg.norm(ahead, axis=1), 1e-6)[:, None]
        line = border - side * self._half * ahead[:, ::-1] * (-1.0, 1.0)
        line = line[line[:, 0] > 0.1]
        if not len(line):
            return None
        best = int(np.argmin(np.abs(np.hypot(*line.T) - self._lookahead)))
        return len(border) + 1e-6 * best, line[best]

    def _update_half_width(self, chain, borders):
        """Updates the lane's half width from line and border in the same image."""
        for border in borders:
            if len(border) > 2 and len(chain) > 2:
                gap = np.linalg.norm(np.array(border)[:, None] - np.array(chain)[None], axis=2)
                width = float(np.median(gap.min(axis=0)))
                if 0.15 < width < 1.5:
                    self._half += 0.1 * (width - self._half)


def vision_from(get, lookahead):
    """Returns the LineVision for a node's private parameters camera_* and lookahead.

    Args:
        get: rospy.get_param or a function like it: (name, default) -> value.
        lookahead: Default distance of the goal from the rear axle [m].

    Raises:
        ValueError: A parameter is not valid; the message has its name.
    """
    mount = read(Mount, get, "~camera_")
    return LineVision(mount, lookahead=get("~lookahead", lookahead))

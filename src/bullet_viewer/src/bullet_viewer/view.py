"""The view of a world: camera orbit, images, overlays."""

import math
import time
from collections import deque
from dataclasses import dataclass

import numpy as np
from bullet_sim.pose import matrix_from_rpy
from bullet_sim.sensors.views import Contacts, LinkFrames
from PyQt5.QtCore import QLineF, QPointF, QRectF, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QImage, QPainter, QPen
from PyQt5.QtWidgets import QSizePolicy, QWidget

FACTOR_WINDOW = 1.0  # wall time over which it is taken [s]


class RealTimeFactor:
    """Simulated seconds per second of wall time, over the last PACE_WINDOW."""

    def __init__(self, clock=time.monotonic):
        self._clock, self._samples = clock, deque()

    def update(self, simulated):
        """Update with the simulated time [s]; returns the factor or None while unknown."""
        samples, now = self._samples, self._clock()
        if samples and simulated < samples[-1][1]:  # a reset
            samples.clear()
        samples.append((now, simulated))
        while len(samples) > 2 and now - samples[1][0] >= FACTOR_WINDOW:
            samples.popleft()
        span = now - samples[0][0]
        return (simulated - samples[0][1]) / span if span >= 0.5 * FACTOR_WINDOW else None


RADIANS_PER_PIXEL = 0.006
ZOOM_PER_NOTCH = 0.85
MIN_DISTANCE, MAX_DISTANCE = 0.05, 500.0  # [m] from the target
MAX_PITCH = math.radians(89.0)


class OrbitCamera:
    """Looks at `target` from `distance`.

    Attributes:
        target: (3,) [m], world frame.
        distance: [m].
        yaw: heading of the view [rad], 0 looks along the world's x.
        pitch: downward tilt of the view [rad].
        horizontal_fov: [rad].
    """

    def __init__(
        self,
        target=(0.0, 0.0, 0.0),
        distance=4.0,
        yaw=math.radians(35.0),
        pitch=math.radians(30.0),
        horizontal_fov=math.radians(60.0),
    ):
        self.target = np.array(target, float)
        self.distance, self.yaw, self.pitch = distance, yaw, pitch
        self.horizontal_fov = horizontal_fov

    @property
    def rotation(self):
        """(3, 3): camera frame (x along the view, y left, z up) in the world."""
        return matrix_from_rpy((0.0, self.pitch, self.yaw))

    @property
    def position(self):
        """(3,) [m], world frame."""
        return self.target - self.distance * self.rotation[:, 0]

    @property
    def pose(self):
        """(xyz [m], rpy [rad]) of the camera frame in the world, as tuples of floats."""
        return (tuple(self.position.tolist()), (0.0, float(self.pitch), float(self.yaw)))

    @property
    def clip(self):
        """(near, far) [m]."""
        return max(0.01, 0.02 * self.distance), max(200.0, 20.0 * self.distance)

    def orbit(self, right, down):
        """Orbit the target as if the pointer dragged the scene by so many pixels."""
        self.yaw = math.remainder(self.yaw - RADIANS_PER_PIXEL * right, 2.0 * math.pi)
        pitch = self.pitch + RADIANS_PER_PIXEL * down
        self.pitch = min(MAX_PITCH, max(-MAX_PITCH, pitch))

    def pan(self, right, down, width):
        """Shift so that a point at the target's distance follows the pointer.

        Args:
            right, down: drag [px].
            width: of the image [px].
        """
        metres = 2.0 * self.distance * math.tan(self.horizontal_fov / 2.0) / width
        _, left, up = self.rotation.T
        self.target = self.target + metres * (right * left + down * up)

    def zoom(self, notches):
        """Move closer by so many notches of the wheel."""
        self.distance = min(
            MAX_DISTANCE, max(MIN_DISTANCE, self.distance * ZOOM_PER_NOTCH**notches)
        )


def project(points, pose, horizontal_fov, width, height):
    """Project points into a camera's image.

    Args:
        points: (n, 3) [m], world frame.
        pose: (xyz [m], rpy [rad]) of the camera.
        horizontal_fov: [rad].
        width, height: of the image [px].

    Returns:
        (n, 2) [px] right and down from the upper left corner, and (n,) depth along the view [m];
        pixels of points whose depth is not positive are meaningless.
    """
    xyz, rpy = pose
    in_camera = (np.asarray(points, float) - xyz) @ matrix_from_rpy(rpy)
    depth = in_camera[:, 0]
    focal = width / (2.0 * math.tan(horizontal_fov / 2.0))
    scale = focal / np.where(depth > 0.0, depth, np.inf)
    return np.column_stack(
        [width / 2.0 - scale * in_camera[:, 1], height / 2.0 - scale * in_camera[:, 2]]
    ), depth


def project_rays(origin, ends, pose, horizontal_fov, width, height, near=0.01):
    """Project rays into lines; the part behind the camera is clipped.

    Args:
        origin: (3,) [m], world frame.
        ends: (n, 3) [m], world frame.
        pose, horizontal_fov, width, height: as in project.
        near: depth at which lines are clipped [m].

    Returns:
        (m, 4) [px]: x, y of the start and of the end; m <= n.
    """
    ends = np.asarray(ends, float)
    starts = np.broadcast_to(np.asarray(origin, float), ends.shape)
    forward = matrix_from_rpy(pose[1])[:, 0]
    first, last = (starts - pose[0]) @ forward, (ends - pose[0]) @ forward
    in_front = (first > near) | (last > near)
    starts, ends, first, last = starts[in_front], ends[in_front], first[in_front], last[in_front]
    run = np.where(first == last, 1.0, last - first)
    cut = starts + ((near - first) / run)[:, None] * (ends - starts)
    starts = np.where((first < near)[:, None], cut, starts)
    ends = np.where((last < near)[:, None], cut, ends)
    view = (pose, horizontal_fov, width, height)
    return np.hstack([project(starts, *view)[0], project(ends, *view)[0]])


RAY_COLOR = QColor(40, 120, 255, 90)
CONTACT_COLOR = QColor(255, 170, 0)
AXIS_COLORS = QColor(230, 40, 40), QColor(40, 190, 40), QColor(50, 90, 255)  # x, y, z as in rviz
NAME_COLOR = QColor(255, 255, 255)
AXIS_LENGTH = 0.06  # of the distance to the camera
NORMAL_LENGTH = 0.05  # of the distance to the camera
DOT = 3.0  # radius of a contact point [px]


@dataclass(frozen=True)
class Overlay:
    """What to paint: tuple of Rays, Contacts or None, LinkFrames or None."""

    rays: tuple = ()
    contacts: Contacts | None = None
    frames: LinkFrames | None = None


class OverlayPainter:
    """Paints with a QPainter over the image of a camera.

    Args:
        pose: (xyz [m], rpy [rad]) of the camera.
        horizontal_fov: [rad].
        width, height: of the painted image [px].
    """

    def __init__(self, painter, pose, horizontal_fov, width, height):
        self._painter, self._view = painter, (pose, horizontal_fov, width, height)
        self._eye = np.array(pose[0])

    def paint(self, overlay):
        for rays in overlay.rays:
            self._lines(rays.origin, rays.ends, RAY_COLOR, 1.0)
        if overlay.contacts is not None:
            self._paint_contacts(overlay.contacts)
        if overlay.frames is not None:
            self._paint_frames(overlay.frames)

    def _lines(self, origin, ends, color, width):
        self._painter.setPen(QPen(color, width))
        lines = project_rays(origin, ends, *self._view)
        self._painter.drawLines([QLineF(*line) for line in lines.tolist()])

    def _length(self, points, fraction):
        """Lengths (n, 1) [m] of equal size in the image at each of the points (n, 3)."""
        return fraction * np.linalg.norm(points - self._eye, axis=1, keepdims=True)

    def _visible(self, points):
        """Indices and pixels of the points (n, 3) that are in front of the camera."""
        pixels, depth = project(points, *self._view)
        return [(index, pixels[index]) for index in np.flatnonzero(depth > 0.0)]

    def _paint_contacts(self, contacts):
        ends = contacts.places + contacts.normals * self._length(contacts.places, NORMAL_LENGTH)
        for point, end in zip(contacts.places, ends):
            self._lines(point, end[None], CONTACT_COLOR, 1.5)
        self._painter.setBrush(CONTACT_COLOR)
        for _, (x, y) in self._visible(contacts.places):
            self._painter.drawEllipse(QPointF(x, y), DOT, DOT)

    def _paint_frames(self, frames):
        lengths = self._length(frames.origins, AXIS_LENGTH)
        for axis, color in enumerate(AXIS_COLORS):
            ends = frames.origins + lengths * frames.rotations[:, :, axis]
            for origin, end in zip(frames.origins, ends):
                self._lines(origin, end[None], color, 2.0)
        self._painter.setPen(NAME_COLOR)
        for index, (x, y) in self._visible(frames.origins):
            self._painter.drawText(QPointF(x + 6.0, y - 4.0), frames.names[index])


CLICK_SLACK = 4  # a press that moves less is a click [px]
WHEEL_NOTCH = 120.0  # Qt's angle of one notch of a mouse wheel


class View(QWidget):
    """Shows an image; has the camera.

    Left drag: orbit the target. Right or middle drag: shift. Wheel: closer, farther. Left click:
    select.
    """

    moved = pyqtSignal()  # the user moved the camera
    clicked = pyqtSignal(float, float)  # right and down, as fractions of the width and the height

    def __init__(self, parent=None):
        super().__init__(parent)
        self.camera = OrbitCamera()
        self.message = ""
        self._image = None
        self._bytes = None
        self._overlay, self._pose, self._fov = Overlay(), None, None
        self._last, self._pressed = None, None
        self.setMinimumSize(160, 120)
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)

    def sizeHint(self):
        return QSize(960, 600)

    def show_image(self, rgb, overlay, pose, horizontal_fov):
        """Show a rendered image.

        Args:
            rgb: (H, W, 3) uint8.
            overlay: Overlay to paint over it.
            pose, horizontal_fov: of the camera that rendered it.
        """
        height, width, _ = rgb.shape
        self._bytes = rgb.tobytes()  # QImage does not copy them
        self._image = QImage(self._bytes, width, height, 3 * width, QImage.Format_RGB888)
        self._overlay, self._pose, self._fov = overlay, pose, horizontal_fov
        self.update()

    def show_message(self, text):
        """Show a message at the lower edge; empty: none."""
        if text != self.message:
            self.message = text
            self.update()

    def paintEvent(self, _):
        """Paint image, overlay and message."""
        painter = QPainter(self)
        if self._image is None:
            painter.fillRect(self.rect(), QColor("#20242a"))
        else:
            painter.setRenderHint(QPainter.SmoothPixmapTransform)
            painter.drawImage(QRectF(self.rect()), self._image)
            view = self._pose, self._fov, self.width(), self.height()
            OverlayPainter(painter, *view).paint(self._overlay)
        if self.message:
            band = QRectF(0, self.height() - 28, self.width(), 28)
            painter.fillRect(band, QColor(20, 22, 26, 190))
            painter.setPen(QColor("#ffd166"))
            painter.drawText(band, Qt.AlignCenter, self.message)
        painter.end()

    def mousePressEvent(self, event):
        """A drag or a click starts."""
        self._last = event.localPos()
        alone = event.button() == Qt.LeftButton == event.buttons()
        self._pressed = event.localPos() if alone else None

    def mouseMoveEvent(self, event):
        """A drag continues."""
        if self._last is None:
            return
        if self._is_click(event):
            return
        if self._pressed is not None:
            self._pressed = None  # a drag
        drag = event.localPos() - self._last
        self._last = event.localPos()
        if event.buttons() & Qt.LeftButton:
            self.camera.orbit(drag.x(), drag.y())
        elif event.buttons() & (Qt.RightButton | Qt.MiddleButton):
            self.camera.pan(drag.x(), drag.y(), self.width())
        else:
            return
        self.moved.emit()

    def mouseReleaseEvent(self, event):
        """A drag ends with the last button; a click selects."""
        if self._is_click(event):
            pixel = event.localPos()
            self.clicked.emit(pixel.x() / self.width(), pixel.y() / self.height())
        self._pressed = None
        if not event.buttons():
            self._last = None

    def _is_click(self, event):
        """Whether the left button was pressed alone and the pointer has hardly moved since."""
        if self._pressed is None:
            return False
        return QPointF(event.localPos() - self._pressed).manhattanLength() < CLICK_SLACK

    def wheelEvent(self, event):
        self.camera.zoom(event.angleDelta().y() / WHEEL_NOTCH)
        self.moved.emit()
        event.accept()

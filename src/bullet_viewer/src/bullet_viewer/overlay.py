"""What is painted over a picture: lidar rays, contact points, frames of links."""

from dataclasses import dataclass

import numpy as np
from bullet_sim.sensors.views import Contacts, LinkFrames
from PyQt5.QtCore import QLineF, QPointF
from PyQt5.QtGui import QColor, QPen

from bullet_viewer.orbit import project, project_rays

RAY_COLOR = QColor(40, 120, 255, 90)
CONTACT_COLOR = QColor(255, 170, 0)
AXIS_COLORS = QColor(230, 40, 40), QColor(40, 190, 40), QColor(50, 90, 255)  # x, y, z as in rviz
NAME_COLOR = QColor(255, 255, 255)
AXIS_LENGTH = 0.06  # of the distance to the camera
NORMAL_LENGTH = 0.05  # of the distance to the camera
DOT = 3.0  # radius of a contact point [px]


@dataclass(frozen=True)
class Overlay:
    """What to paint: Rays, Contacts or None, LinkFrames or None."""

    rays: tuple = ()
    contacts: Contacts | None = None
    frames: LinkFrames | None = None


class OverlayPainter:
    """Paints with a QPainter over the picture of a camera.

    Args:
        painter: QPainter.
        pose: (xyz [m], rpy [rad]) of the camera.
        horizontal_fov: [rad].
        width, height: of the painted picture [px].
    """

    def __init__(self, painter, pose, horizontal_fov, width, height):
        self._painter, self._view = painter, (pose, horizontal_fov, width, height)
        self._eye = np.array(pose[0])

    def paint(self, overlay):
        """Paint an Overlay."""
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

    def _length(self, points, share):
        """Lengths (n, 1) [m] that look alike at each of the points (n, 3)."""
        return share * np.linalg.norm(points - self._eye, axis=1, keepdims=True)

    def _visible(self, points):
        """Numbers and places [px] of the points (n, 3) that are in front of the camera."""
        places, depth = project(points, *self._view)
        return [(number, places[number]) for number in np.flatnonzero(depth > 0.0)]

    def _paint_contacts(self, contacts):
        ends = contacts.places + contacts.normals * self._length(contacts.places, NORMAL_LENGTH)
        for place, end in zip(contacts.places, ends):
            self._lines(place, end[None], CONTACT_COLOR, 1.5)
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
        for number, (x, y) in self._visible(frames.origins):
            self._painter.drawText(QPointF(x + 6.0, y - 4.0), frames.names[number])

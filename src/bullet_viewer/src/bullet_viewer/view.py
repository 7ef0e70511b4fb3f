"""The picture, lidar rays drawn over it, and the mouse that moves the camera."""

from PyQt5.QtCore import QLineF, QRectF, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QImage, QPainter, QPen
from PyQt5.QtWidgets import QSizePolicy, QWidget

from bullet_viewer.orbit import OrbitCamera, project_rays

RAY_COLOR = QColor(40, 120, 255, 90)
WHEEL_NOTCH = 120.0  # Qt's angle of one notch of a mouse wheel


class View(QWidget):
    """Shows a picture and keeps the camera.

    Left drag: circle the target. Right or middle drag: shift. Wheel: nearer, farther.

    Attributes:
        camera: OrbitCamera.
    """

    moved = pyqtSignal()  # the user moved the camera

    def __init__(self, parent=None):
        super().__init__(parent)
        self.camera = OrbitCamera()
        self.message = ""
        self._picture = None
        self._bytes = None
        self._rays, self._pose, self._fov = (), None, None
        self._last = None
        self.setMinimumSize(160, 120)
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)

    def sizeHint(self):
        """Preferred size."""
        return QSize(960, 600)

    def show_picture(self, rgb, rays, pose, horizontal_fov):
        """Show a finished picture.

        Args:
            rgb: (H, W, 3) uint8.
            rays: Rays to draw over it.
            pose, horizontal_fov: of the camera it was drawn with.
        """
        height, width, _ = rgb.shape
        self._bytes = rgb.tobytes()  # QImage does not keep them
        self._picture = QImage(self._bytes, width, height, 3 * width, QImage.Format_RGB888)
        self._rays, self._pose, self._fov = rays, pose, horizontal_fov
        self.update()

    def show_message(self, text):
        """Show a message at the lower edge; empty: none."""
        if text != self.message:
            self.message = text
            self.update()

    def paintEvent(self, _):
        """Paint picture, rays and message."""
        painter = QPainter(self)
        if self._picture is None:
            painter.fillRect(self.rect(), QColor("#20242a"))
        else:
            painter.setRenderHint(QPainter.SmoothPixmapTransform)
            painter.drawImage(QRectF(self.rect()), self._picture)
            self._paint_rays(painter)
        if self.message:
            band = QRectF(0, self.height() - 28, self.width(), 28)
            painter.fillRect(band, QColor(20, 22, 26, 190))
            painter.setPen(QColor("#ffd166"))
            painter.drawText(band, Qt.AlignCenter, self.message)
        painter.end()

    def _paint_rays(self, painter):
        painter.setPen(QPen(RAY_COLOR, 1.0))
        for rays in self._rays:
            lines = project_rays(
                rays.origin, rays.ends, self._pose, self._fov, self.width(), self.height()
            )
            painter.drawLines([QLineF(*line) for line in lines.tolist()])

    def mousePressEvent(self, event):
        """A drag begins."""
        self._last = event.localPos()

    def mouseMoveEvent(self, event):
        """A drag goes on."""
        if self._last is None:
            return
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
        """A drag ends with the last button."""
        if not event.buttons():
            self._last = None

    def wheelEvent(self, event):
        """Zoom."""
        self.camera.zoom(event.angleDelta().y() / WHEEL_NOTCH)
        self.moved.emit()
        event.accept()

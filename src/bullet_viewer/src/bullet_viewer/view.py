"""The picture, the overlay painted over it, and the mouse that moves the camera or selects."""

from PyQt5.QtCore import QPointF, QRectF, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QImage, QPainter
from PyQt5.QtWidgets import QSizePolicy, QWidget

from bullet_viewer.orbit import OrbitCamera
from bullet_viewer.overlay import Overlay, OverlayPainter

CLICK_SLACK = 4  # a press that moves less is a click [px]
WHEEL_NOTCH = 120.0  # Qt's angle of one notch of a mouse wheel


class View(QWidget):
    """Shows a picture and keeps the camera.

    Left drag: circle the target. Right or middle drag: shift. Wheel: nearer, farther. Left click:
    select.

    Attributes:
        camera: OrbitCamera.
    """

    moved = pyqtSignal()  # the user moved the camera
    clicked = pyqtSignal(float, float)  # right and down, as shares of the width and the height

    def __init__(self, parent=None):
        super().__init__(parent)
        self.camera = OrbitCamera()
        self.message = ""
        self._picture = None
        self._bytes = None
        self._overlay, self._pose, self._fov = Overlay(), None, None
        self._last, self._pressed = None, None
        self.setMinimumSize(160, 120)
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)

    def sizeHint(self):
        """Preferred size."""
        return QSize(960, 600)

    def show_picture(self, rgb, overlay, pose, horizontal_fov):
        """Show a finished picture.

        Args:
            rgb: (H, W, 3) uint8.
            overlay: Overlay to paint over it.
            pose, horizontal_fov: of the camera it was drawn with.
        """
        height, width, _ = rgb.shape
        self._bytes = rgb.tobytes()  # QImage does not keep them
        self._picture = QImage(self._bytes, width, height, 3 * width, QImage.Format_RGB888)
        self._overlay, self._pose, self._fov = overlay, pose, horizontal_fov
        self.update()

    def show_message(self, text):
        """Show a message at the lower edge; empty: none."""
        if text != self.message:
            self.message = text
            self.update()

    def paintEvent(self, _):
        """Paint picture, overlay and message."""
        painter = QPainter(self)
        if self._picture is None:
            painter.fillRect(self.rect(), QColor("#20242a"))
        else:
            painter.setRenderHint(QPainter.SmoothPixmapTransform)
            painter.drawImage(QRectF(self.rect()), self._picture)
            view = self._pose, self._fov, self.width(), self.height()
            OverlayPainter(painter, *view).paint(self._overlay)
        if self.message:
            band = QRectF(0, self.height() - 28, self.width(), 28)
            painter.fillRect(band, QColor(20, 22, 26, 190))
            painter.setPen(QColor("#ffd166"))
            painter.drawText(band, Qt.AlignCenter, self.message)
        painter.end()

    def mousePressEvent(self, event):
        """A drag or a click begins."""
        self._last = event.localPos()
        alone = event.button() == Qt.LeftButton == event.buttons()
        self._pressed = event.localPos() if alone else None

    def mouseMoveEvent(self, event):
        """A drag goes on."""
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
            place = event.localPos()
            self.clicked.emit(place.x() / self.width(), place.y() / self.height())
        self._pressed = None
        if not event.buttons():
            self._last = None

    def _is_click(self, event):
        """Whether the left button was pressed alone and has hardly moved since."""
        if self._pressed is None:
            return False
        return QPointF(event.localPos() - self._pressed).manhattanLength() < CLICK_SLACK

    def wheelEvent(self, event):
        """Zoom."""
        self.camera.zoom(event.angleDelta().y() / WHEEL_NOTCH)
        self.moved.emit()
        event.accept()

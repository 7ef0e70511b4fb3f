"""The window's settings, and its stored position and size."""

from dataclasses import dataclass

from paddock_common.settings import check, choice, number, text
from PyQt5.QtCore import QByteArray, QSettings
from PyQt5.QtGui import QGuiApplication

DEFAULT_SPEED = 10.0
DEFAULT_ANGULAR_SPEED = 5.0
LINEAR_WAIT = 1.0
RECT_ANGLE_TURN_WAIT = 0.8


@dataclass(frozen=True)
class Settings:
    """Values of one window.

    Attributes:
        default_speed: linear.x of Forward and of cruise, in the driver's unit (wheel rad/s in the
            original mode, m/s in ackermann mode).
        default_angular_speed: Size of angular.z of Left and Right, in the driver's unit.
        linear_wait: ROS time that Forward and Backwards last [s].
        turn_wait: ROS time that Left and Right last [s].
        slider_limit: The slider goes from minus this to this; a whole number.
        slider_scale: angular.z is the slider's value divided by this.
        angular_sign: 1: positive angular.z steers right (the original). -1: left (REP-103).
        repeat_rate: How often a moving car's command is repeated, in ROS time [Hz].
        camera_timeout: Wall time without an image after which the camera counts as stopped [s].
        key_steering: Fraction of default_angular_speed for a held key or a full stick.
        record_dir: Folder for recordings; ~ is the user's home.
        master_timeout: Wall time without a response after which the master is unavailable [s].
    """

    default_speed: float = number(DEFAULT_SPEED, above=0.0)
    default_angular_speed: float = number(DEFAULT_ANGULAR_SPEED, above=0.0)
    linear_wait: float = number(LINEAR_WAIT, above=0.0, unit="s")
    turn_wait: float = number(RECT_ANGLE_TURN_WAIT, above=0.0, unit="s")
    slider_limit: float = number(50, above=0.0)
    slider_scale: float = number(10.0, above=0.0)
    angular_sign: float = choice(1, (1, -1), "1 (positive is right) or -1 (positive is left)")
    repeat_rate: float = number(10.0, above=0.0, unit="Hz")
    camera_timeout: float = number(2.0, above=0.0, unit="s")
    key_steering: float = number(0.5, above=0.0, max=1.0)
    record_dir: str = text("~/paddock-recordings")
    master_timeout: float = number(3.0, above=0.0, unit="s")

    def __post_init__(self):
        check(self)
        if self.slider_limit != int(self.slider_limit):
            raise ValueError(f"slider_limit is {self.slider_limit!r}; it must be a whole number")

    def slider_to_angular(self, value):
        """Returns angular.z for a slider value (positive is right in the window)."""
        return self.angular_sign * value / self.slider_scale


KEY = "window/geometry"


class WindowGeometry:
    """Stores position and size in the user's settings (~/.config/paddock/teleop.ini)."""

    def __init__(self, path=None):
        self._path = path

    def _settings(self):
        """Made for each use: PyQt has called one deleted that outlived other objects of Qt's."""
        if self._path is None:
            return QSettings(QSettings.IniFormat, QSettings.UserScope, "paddock", "teleop")
        return QSettings(str(self._path), QSettings.IniFormat)

    def restore(self, window):
        """Restores position and size of a window; one outside of all screens is moved onto one.

        Returns:
            Whether there was a stored position and size.
        """
        geometry = self._settings().value(KEY)
        return isinstance(geometry, QByteArray) and window.restoreGeometry(geometry)

    def save(self, window):
        """Stores position and size of a window, as the window system has them by now.

        Qt learns of a move by an event. One that is still under way is waited for.
        """
        QGuiApplication.sync()
        settings = self._settings()
        settings.setValue(KEY, window.saveGeometry())
        settings.sync()

"""Where the window was and how large: kept from one start to the next."""

from PyQt5.QtCore import QByteArray, QSettings

KEY = "window/geometry"


class Memory:
    """Keeps place and size in the user's settings (~/.config/paddock/teleop.ini).

    Args:
        path: Of another file.
    """

    def __init__(self, path=None):
        self._settings = (
            QSettings(QSettings.IniFormat, QSettings.UserScope, "paddock", "teleop")
            if path is None
            else QSettings(str(path), QSettings.IniFormat)
        )

    def restore(self, window):
        """Puts a window where it was; one that would lie outside of all screens is moved in.

        Returns:
            Whether there was something to restore.
        """
        geometry = self._settings.value(KEY)
        return isinstance(geometry, QByteArray) and window.restoreGeometry(geometry)

    def keep(self, window):
        """Remembers place and size of a window."""
        self._settings.setValue(KEY, window.saveGeometry())
        self._settings.sync()

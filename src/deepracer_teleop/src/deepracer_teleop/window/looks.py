"""What of the window depends on the screen: its scale, and a light or a dark palette."""

from PyQt5.QtCore import QCoreApplication, Qt
from PyQt5.QtGui import QColor, QGuiApplication, QPalette

RED = {"light": "#b3261e", "dark": "#ff8a80"}  # of letters on a button
RECORDING = {"light": "#9a1c14", "dark": "#ff8a80"}  # of letters on the window


def prepare_scaling():
    """Lets Qt follow the screen's scale; call it before the QApplication is made.

    From a scale of 1.75 on everything doubles; below, letters alone grow and widgets with them.
    """
    QCoreApplication.setAttribute(Qt.AA_EnableHighDpiScaling)
    QCoreApplication.setAttribute(Qt.AA_UseHighDpiPixmaps)
    QGuiApplication.setHighDpiScaleFactorRoundingPolicy(
        Qt.HighDpiScaleFactorRoundingPolicy.RoundPreferFloor
    )


def shade(palette):
    """Returns "dark" if a QPalette's windows are darker than their letters, else "light"."""
    window, letters = (palette.color(role) for role in (QPalette.Window, QPalette.WindowText))
    return "dark" if window.lightness() < letters.lightness() else "light"


def outlined(name):
    """Returns a QPalette of slider and checkbox: Fusion draws ticks and rims darker than Window."""
    palette = QPalette()
    if name == "dark":
        palette.setColor(QPalette.Window, QColor("#a0a0a0"))
    return palette

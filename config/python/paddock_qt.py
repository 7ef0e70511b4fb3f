"""Floating-point numbers where Qt's methods take whole ones, which PyQt5 let be until Python 3.9.

Windows for Noetic, whose Python is 3.8, count on it: slider.setValue(50 * x). Since Python 3.10
this is a TypeError. A call that fails so is made again with the numbers cut off, as they were then.
None of these methods is virtual: Qt's own calls do not come by here.
"""

import functools

_RANGE = ("setValue", "setRange", "setMinimum", "setMaximum")
_SIZE = [f"set{which}{what}" for which in ("Fixed", "Minimum", "Maximum")
         for what in ("Size", "Width", "Height")]  # fmt: skip
# Module -> class -> methods
METHODS = {
    "PyQt5.QtCore": {"QTimer": ("start", "setInterval")},
    "PyQt5.QtGui": {
        "QFont": ("setPixelSize", "setPointSize", "setWeight"),
        "QImage": ("pixel", "pixelColor", "scaled", "scaledToHeight", "scaledToWidth", "setPixel"),
        "QPainter": (
            *("drawArc", "drawChord", "drawEllipse", "drawImage", "drawLine", "drawPie"),
            *("drawPixmap", "drawPoint", "drawRect", "drawRoundedRect", "drawText", "eraseRect"),
            *("fillRect", "setClipRect", "setViewport", "setWindow"),
        ),
        "QPen": ("setWidth",),
        "QPixmap": ("scaled", "scaledToHeight", "scaledToWidth"),
    },
    "PyQt5.QtWidgets": {
        "QAbstractSlider": (*_RANGE, "setPageStep", "setSingleStep", "setSliderPosition"),
        "QProgressBar": _RANGE,
        "QSpinBox": (*_RANGE, "setSingleStep"),
        "QWidget": ("move", "resize", "setContentsMargins", "setGeometry", *_SIZE),
    },
}


def install(module):
    """Wraps the methods of one of PyQt5's modules."""
    for name, methods in METHODS[module.__name__].items():
        found = getattr(module, name)
        for method in methods:
            setattr(found, method, cutting(getattr(found, method)))


def cutting(method):
    """Returns a method that takes floating-point numbers for whole ones, too."""

    @functools.wraps(method)
    def call(*arguments, **named):
        try:
            return method(*arguments, **named)
        except TypeError:
            if not any(isinstance(value, float) for value in (*arguments, *named.values())):
                raise
        whole = [_cut(value) for value in arguments]
        return method(*whole, **{name: _cut(value) for name, value in named.items()})

    return call


def _cut(value):
    return int(value) if isinstance(value, float) else value

"""Pictures received over bare getCameraImage, at rates that the renderer cannot keep."""

from curves import bars
from figures import BenchError
from launching import Launch
from pairs import alternate, pairs_of
from report import Row, ratio_row, spent_text
from usage import Watch

# Renderer, width and height [px], rate that is asked for [Hz], whether a quick run takes it.
CAMERAS = (
    ("egl", 640, 480, 100, True),
    ("egl", 320, 240, 300, False),
    ("egl", 160, 120, 1000, False),
    ("egl", 1280, 720, 50, False),
    ("tiny", 640, 480, 100, False),
    ("tiny", 160, 120, 1000, False),
)


def measure(quick, log):
    """Each camera in a launch of its own, in turns with getCameraImage."""
    figures, errors = {}, {}
    for renderer, width, height, rate, short in CAMERAS:
        if quick and not short:
            continue
        name = f"{renderer}_{width}x{height}"
        try:
            figures[name] = _measure(renderer, width, height, rate, pairs_of(quick), log)
        except BenchError as error:
            errors[name] = str(error)
    return dict(figures, errors=errors)


def _measure(renderer, width, height, rate, pairs, log):
    with Launch(
        log,
        [
            f"camera_width:={width}",
            f"camera_height:={height}",
            f"camera_rate:={rate}",
            f"renderer:={renderer}",
            "lidar:=false",
        ],
    ) as launch:
        observer = launch.observer("frames", renderer)
        observer.answer()

        def turn(kind):
            return observer.ask(f"{kind} 1.5")["rate"]

        measured = alternate(
            lambda: turn("bare"),
            {"received": lambda: turn("received")},
            pairs,
            Watch(launch.roles()),
        )
    return dict(measured["received"].figures(), asked_hz=rate)


def rows(figures):
    """One a camera."""
    for name, row in figures.items():
        yield ratio_row(f"pictures, {name}", row, "bare getCameraImage", "Hz")
        yield Row("  processors", spent_text(row["spent"]))


def draw(figures, folder):
    """Bars of the ratios."""
    bars(
        {name: row["ratio"] for name, row in figures.items()},
        folder / "camera.png",
        "received pictures per s / bare getCameraImage per s",
    )

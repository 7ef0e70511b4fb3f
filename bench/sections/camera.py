"""Pictures of the bare renderer and received ones, over PyBullet's EGL renderer as the reference.

Bare: in one process, without ROS, of the car's world, driving on: each picture of a snapshot of its
own. Received: by a subscriber, at rates that the renderer cannot keep.
"""

from functools import partial

from curves import bars
from figures import BenchError
from launching import Launch
from pairs import alternate, pairs_of
from report import Row, ratio_row, spent_text
from usage import Watch

# Width and height [px], rate that is asked for [Hz], whether a quick run takes it.
CAMERAS = (
    (640, 480, 250, True),
    (160, 120, 1000, True),
    (320, 240, 500, False),
    (1280, 720, 100, False),
    (1920, 1080, 50, False),
)
# Bare renderers beside the reference: shadows and antialiasing.
BARE = {
    "plain": ("false", "false"),
    "antialias": ("false", "true"),
    "shadows": ("true", "false"),
    "both": ("true", "true"),
}


def measure(quick, log):
    """Each size in a launch of its own, in turns with the reference."""
    figures, errors = {}, {}
    for width, height, rate, short in CAMERAS:
        if quick and not short:
            continue
        name = f"{width}x{height}"
        try:
            figures.update(_measure(name, width, height, rate, pairs_of(quick), log))
        except BenchError as error:
            errors[name] = str(error)
    return dict(figures, errors=errors)


def _measure(name, width, height, rate, pairs, log):
    with Launch(
        log,
        [
            f"camera_width:={width}",
            f"camera_height:={height}",
            f"camera_rate:={rate}",
            "real_time_factor:=0",
            "lidar:=false",
        ],
    ) as launch:
        observer = launch.observer("frames")
        observer.answer()

        def turn(kind):
            return observer.ask(f"{kind} 1.0")["rate"]

        measured = alternate(
            lambda: turn("egl"),
            {"received": lambda: turn("received")}
            | {name: partial(turn, "/".join(quality)) for name, quality in BARE.items()},
            pairs,
            Watch(launch.roles()),
        )
    return {f"{kind} {name}": dict(found.figures()) for kind, found in measured.items()}


def rows(figures):
    """One a kind and size."""
    for name, row in figures.items():
        yield ratio_row(f"pictures, {name}", row, "PyBullet's EGL, bare", "Hz")
        yield Row("  processors", spent_text(row["spent"]))


def draw(figures, folder):
    """Bars of the ratios."""
    bars(
        {name: row["ratio"] for name, row in figures.items()},
        folder / "camera.png",
        "pictures per s / those of PyBullet's EGL renderer per s",
    )

"""Pictures of the bare renderer and received ones, over PyBullet's EGL renderer as the reference.

Bare: in one process, without ROS, of the car's world, driving on: each image of a snapshot of its
own. Received: by a subscriber, at rates that the renderer cannot keep.
"""

from functools import partial

from figures import BenchError
from launching import Launch
from pairs import alternate, pairs_of
from report import Row, ratio_row, spent_text
from usage import Monitor

# Width and height [px], rate that is asked for [Hz], whether a quick run takes it.
CAMERAS = (
    (640, 480, 250, True),
    (160, 120, 1000, True),
    (1280, 720, 100, False),
)
# Bare renderers beside the reference: shadows and antialiasing.
BARE = {
    "plain": ("false", "false"),
    "antialias": ("false", "true"),
    "shadows": ("true", "false"),
    "both": ("true", "true"),
}


def measure(quick, log):
    """Each size in a launch of its own, in alternation with the reference."""
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
        observers = {}
        for kind in ("received", "egl", "gl"):  # PyBullet's renderer bears no other beside it
            observers[kind] = launch.observer("frames.frames", kind)
            observers[kind].answer()

        def one_round(kind, quality=""):
            return observers[kind].ask(f"1.0 {quality}")["rate"]

        measured = alternate(
            lambda: one_round("egl"),
            {
                "received": lambda: one_round("received"),
                **{name: partial(one_round, "gl", "/".join(each)) for name, each in BARE.items()},
            },
            pairs,
            Monitor(launch.roles()),
        )
    return {f"{kind} {name}": dict(found.figures()) for kind, found in measured.items()}


def rows(figures):
    """One a kind and size."""
    for name, row in figures.items():
        yield ratio_row(f"images, {name}", row, "PyBullet's EGL, bare", "Hz")
        yield Row("  processors", spent_text(row["spent"]))

"""roslaunch to the first joint state, the first image and all controllers, warm."""

import time

from figures import Spread
from launching import Launch
from report import Row

LAUNCHES = 5
NAMES = {
    "first_joint_state": "first joint state",
    "first_image": "first image",
    "controllers": "7 controllers",
}


def measure(quick, log):
    """Launches one after the other; the first of them only fills the file cache."""
    found = []
    for number in range(2 if quick else LAUNCHES + 1):
        begin = time.monotonic()
        with Launch(log) as launch:
            answer = launch.observer("timing.start", begin).answer()
        if number:
            found.append(answer)
    return {
        "launches": len(found),
        **{f"{name}_s": Spread.of(item[name] for item in found).figures() for name in NAMES},
    }


def rows(figures):
    """One a first sign of life."""
    for name, text in NAMES.items():
        spread = Spread.read(figures[f"{name}_s"])
        yield Row(
            f"start to {text}", f"{spread.text()} s, {figures['launches']} launches", spread, "s"
        )

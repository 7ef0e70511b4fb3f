"""Lenses that see more than a pinhole can, as SDF's <lens> describes them."""

import math
from dataclasses import dataclass

FUNCTIONS = ("tan", "sin", "id")
# Names of <type> -> (c1, c2, function).
TYPES = {
    "gnomonical": (1.0, 1.0, "tan"),
    "stereographic": (2.0, 2.0, "tan"),
    "equidistant": (1.0, 1.0, "id"),
    "equisolid_angle": (2.0, 2.0, "sin"),
    "orthographic": (1.0, 1.0, "sin"),
}


@dataclass(frozen=True)
class Lens:
    """r = c1 f function(theta / c2 + c3), with r = 1 at half the picture's width.

    Attributes:
        fov: horizontal angle of the picture [rad], up to a whole turn.
        function: 'tan', 'sin' or 'id'.
        scaled: f is chosen such that `fov` fills the width.
        cutoff: nothing is seen further from the axis [rad].
    """

    fov: float
    c1: float = 1.0
    c2: float = 1.0
    c3: float = 0.0
    f: float = 1.0
    function: str = "id"
    scaled: bool = True
    cutoff: float = math.pi

"""Colours of Gazebo's standard materials, e.g. Gazebo/Orange, as RGBA 0..1.

The names are Gazebo's, the values our own: Gazebo's textures become similar plain colours.
"""

import math

from bullet_sim.formats.xml_read import leading_numbers, replace

_GREY = {
    "Grey": 0.7,
    "Gray": 0.7,
    "DarkGrey": 0.25,
    "DarkGray": 0.25,
    "LightGrey": 0.85,
    "White": 1.0,
    "FlatBlack": 0.08,
    "Black": 0.04,
    "Chrome": 0.78,
    "GreyTransparent": 0.7,
}
_COLORS = {
    "Red": (0.9, 0.08, 0.08),
    "RedBright": (0.95, 0.15, 0.1),
    "DarkRed": (0.5, 0.05, 0.05),
    "Green": (0.1, 0.8, 0.1),
    "DarkGreen": (0.05, 0.4, 0.05),
    "Blue": (0.1, 0.15, 0.9),
    "DarkBlue": (0.05, 0.07, 0.45),
    "SkyBlue": (0.3, 0.6, 0.95),
    "Yellow": (0.95, 0.9, 0.1),
    "DarkYellow": (0.65, 0.6, 0.05),
    "ZincYellow": (0.97, 0.93, 0.2),
    "Orange": (1.0, 0.5, 0.05),
    "DarkOrange": (0.8, 0.38, 0.03),
    "Gold": (0.85, 0.68, 0.22),
    "Purple": (0.62, 0.12, 0.75),
    "DarkPurple": (0.35, 0.07, 0.42),
    "Indigo": (0.29, 0.05, 0.5),
    "Violet": (0.6, 0.35, 0.85),
    "Turquoise": (0.15, 0.85, 0.8),
    "DarkTurquoise": (0.05, 0.55, 0.55),
    "Magenta": (0.9, 0.1, 0.8),
    "DarkMagenta": (0.5, 0.05, 0.45),
    "Pink": (0.95, 0.6, 0.7),
    "Brown": (0.45, 0.28, 0.12),
    "Wood": (0.6, 0.42, 0.24),
    "WoodFloor": (0.55, 0.4, 0.25),
    "WoodPallet": (0.65, 0.5, 0.32),
    "Bricks": (0.6, 0.3, 0.24),
    "Grass": (0.3, 0.5, 0.2),
    "Road": (0.22, 0.22, 0.23),
    "Residential": (0.3, 0.3, 0.31),
    "Pedestrian": (0.5, 0.5, 0.5),
    "Mud": (0.35, 0.25, 0.16),
    "PaintedWall": (0.8, 0.78, 0.72),
    "CeilingTiled": (0.88, 0.88, 0.85),
    "Rockwall": (0.5, 0.47, 0.42),
    "Tarmac": (0.2, 0.2, 0.2),
    "Asphalt": (0.2, 0.2, 0.2),
    "Gravel": (0.45, 0.43, 0.4),
    "Sand": (0.76, 0.7, 0.5),
    "Runway": (0.3, 0.3, 0.3),
}
_SUFFIXES = (
    "Transparent",
    "TransparentOverlay",
    "GlowOutline",
    "Glow",
    "Laser",
    "LaserScan",
    "Bright",
)


def gazebo_color(name):
    """RGBA of a standard material, or None when there is none of that name.

    Args:
        name: 'Gazebo/Orange' or 'Orange'; Transparent and Glow forms count, too.
    """
    word = name.strip().rsplit("/", 1)[-1]
    for suffix in ("",) + _SUFFIXES:
        base = word[: -len(suffix)] if suffix and word.endswith(suffix) else word
        alpha = 0.5 if suffix.startswith(("Transparent", "Laser")) and base != word else 1.0
        if base in _GREY:
            return (_GREY[base],) * 3 + (alpha,)
        if base in _COLORS:
            return _COLORS[base] + (alpha,)
    return None


def rgba_of(element, text, what):
    """RGBA 0..1 of 3 or 4 numbers, or None with a warning; what is beyond 0..1 is cut off.

    Args:
        element: Node that the text is of.
        text: the numbers.
        what: for the message.
    """
    values, _ = leading_numbers(text, 4)
    values += (1.0,) * (len(values) == 3)
    if len(values) == 4 and all(map(math.isfinite, values)):
        return tuple(min(1.0, max(0.0, value)) for value in values)
    sentence = f"{what} is '{(text or '').strip()}', must be 3 or 4 numbers from 0 to 1"
    replace(element, what, text, sentence, None)
    return None

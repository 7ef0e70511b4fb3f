"""Drawings of roads, pavements and steps: see drawings.py."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bullet_sim.formats.images.painting import Array, Color, Random, fill, noise, plain

_SLABS = (43, 94, 145, 196, 244, 294, 343, 393, 443, 493, 542, 591)  # middles of the long joints
_ENDS = (51, 2, 44, -1, 37, -6, 28, -2, 31, -1, 35, 0, 51)  # first joint between two slabs, left on


def pedestrian(random: Random) -> Array:
    """Twelve columns of upright slabs, each moved by about half of one, seven in the height."""
    size = (600, 600)
    picture = plain(size, (100, 98, 85))
    for column, (left, right) in enumerate(zip((-9, *_SLABS), (*_SLABS, 642))):
        for y in np.round(_ENDS[column] + np.arange(-1, 8) * (600 / 7)).astype(int):
            shade = random.normal(0.0, 3.0)
            x, width = max(0, left + 3), min(600, right - 2) - max(0, left + 3)
            top, bottom = max(0, y + 2), max(0, min(600, y + 83))
            picture[top:bottom, x : x + width] = np.float32((158, 158, 144)) + shade
    picture += noise(random, size, (1.2, 1, 1), (1.2, 5, 3), (2.0, 60, 60))[..., None]
    joint = picture[..., :1] < 125
    return picture + joint * noise(random, size, (9, 3, 3))[..., None]


@dataclass(frozen=True)
class _Road:
    """A road from below to above.

    Attributes:
        size: height and width.
        across: x and color of the surface, which is linear in between.
        grain: see noise.
        lines: x, width and color.
        dashes: the same.
        rows: y and height of each dash.
        worn: share of the lines that is worn off.
        specks: how much darker single spots of two pixels are.
        roughness: share of the grain that the lines have.
    """

    size: tuple[int, int]
    across: tuple[tuple[float, Color], ...]
    grain: tuple[tuple[float, float, float], ...]
    lines: tuple[tuple[float, float, Color], ...] = ()
    dashes: tuple[tuple[float, float, Color], ...] = ()
    rows: tuple[tuple[int, int], ...] = ()
    worn: float = 0.0
    specks: float = 0.0
    roughness: float = 1.0

    def __call__(self, random: Random) -> Array:
        """Its image."""
        height, width = self.size
        x, colors = [at for at, _ in self.across], np.float32([color for _, color in self.across])
        row = np.stack([np.interp(np.arange(width), x, colors[:, k]) for k in range(3)], axis=1)
        ground = np.repeat(row[None].astype(np.float32), height, axis=0)
        grain = noise(random, self.size, *self.grain)
        if self.specks:
            grain -= self.specks * (noise(random, self.size, (1, 2, 2)) > 3.0)
        paint = ground.copy()
        marked = np.zeros(self.size, bool)
        for at, wide, color in self.lines:
            fill(paint, at, 0, wide, height, color)
            marked[:, round(at) : round(at + wide)] = True
        if self.worn:
            wear = noise(random, self.size, (1, 14, 5), (0.7, 3, 3), (0.6, 90, 12))
            left = (wear - np.quantile(wear[:, ::7], self.worn)) * 1.5
            left = np.where(marked, np.clip(left, 0.1, 1.0), 0.0).astype(np.float32)
            paint = ground + (paint - ground) * left[..., None]
        for at, wide, color in self.dashes:
            for top, tall in self.rows:
                fill(paint, at, top, wide, tall, color)
                marked[top : top + tall, round(at) : round(at + wide)] = True
        grain *= np.where(marked, np.float32(self.roughness), np.float32(1.0))
        return paint + grain[..., None]


def _grays(*values: float, end: float, warm: float = 1.0) -> tuple[tuple[float, Color], ...]:
    """Equally spaced _Road.across from 0 to `end`, slightly warm."""
    x = np.linspace(0, end, len(values)).tolist()
    return tuple((at, (gray + warm, gray, gray - 0.5 * warm)) for at, gray in zip(x, values))


def _browns(start: float, end: float, *values: float) -> tuple[tuple[float, Color], ...]:
    """As _grays, of a brown asphalt; values: of red."""
    x = np.linspace(start, end, len(values)).tolist()
    return tuple(
        (at, (red, 107 + (red - 112) * 0.9, 102 + (red - 112) * 0.7)) for at, red in zip(x, values)
    )


_YELLOW: Color = (204, 188, 127)
_DEEP: Color = (171, 148, 76)
_WHITE: Color = (252, 252, 252)
_CREAM: Color = (173, 169, 151)
_ASPHALT = ((3.4, 1, 1), (1.9, 3, 3), (1.6, 20, 6), (1.4, 40, 30), (1.3, 150, 10))
PRIMARY = _Road(
    (1024, 1024),
    _grays(
        *(105, 97, 97, 102, 110, 116, 118, 117, 112, 103, 94, 87, 88),
        *(89, 88, 90, 96, 105, 115, 121, 122, 116, 106, 98, 101),
        end=1023,
        warm=0.4,
    ),
    ((5.9, 1, 1), (2.2, 4, 4), (1.8, 16, 16), (1.4, 64, 64)),
    tuple((x, 5, _YELLOW) for x in (15, 491, 504, 1004)),
    roughness=1.5,
)
_PAVED = (130, 122, 116, 112, 113, 113, 116, 121, 128, 131, 128, 121, 116, 115, 116, 120, 127, 132)
RESIDENTIAL = _Road((600, 300), _browns(0, 299, *_PAVED), _ASPHALT, specks=14.0)
SECONDARY = _Road(
    (600, 300),
    _browns(0, 299, *_PAVED),
    _ASPHALT,
    ((0, 3, (154, 141, 93)), (273, 8, _DEEP), (287, 7, _DEEP)),
    specks=14.0,
    roughness=1.5,
)
_HALF = (124, 117, 112, 112, 116, 122, 131, 130, 124, 119, 116, 115, 117, 122, 130)
TRUNK = _Road(
    (600, 600),
    _browns(0, 290, *_HALF) + _browns(300, 599, *_HALF),
    _ASPHALT,
    tuple((x, 9 if x < 577 else 8, _DEEP) for x in (3, 283, 296, 577)),
    ((144, 7, _CREAM), (438, 7, _CREAM)),
    ((24, 72), (175, 72), (326, 72), (480, 68)),
    specks=14.0,
    roughness=1.5,
)
_MOTORWAY_GRAYS = (
    *((0, 126), (22, 115), (24, 106), (43, 88), (57, 75), (64, 82), (95, 86), (130, 92), (150, 99)),
    *((170, 106), (200, 109), (250, 109), (310, 111), (350, 109), (385, 100), (420, 90), (470, 85)),
    *((497, 83), (510, 99), (514, 99), (530, 88), (560, 88), (610, 91), (650, 103), (690, 110)),
    *((760, 110), (830, 108), (875, 100), (900, 91), (940, 84), (968, 79), (982, 92), (990, 104)),
    *((1010, 119), (1023, 137)),
)
MOTORWAY = _Road(
    (1024, 1024),
    tuple((x, (gray, gray, gray)) for x, gray in _MOTORWAY_GRAYS),
    ((12.6, 1, 1), (1.3, 200, 2), (1.0, 60, 30)),
    (
        (44, 12, (172, 139, 67)),
        (498, 11, (166, 142, 78)),
        (515, 12, (177, 147, 79)),
        (969, 12, (174, 140, 68)),
    ),
    tuple((x, 10, _WHITE) for x in (182, 349, 657, 824)),
    ((186, 139), (696, 139)),
    worn=0.06,
    roughness=0.4,
)


# Height below a step's edge -> its gray.
_STEP = ((0, 150), (1, 229), (4, 206), (9, 161), (14, 128), (18, 108), (22, 84), (25, 61), (33, 58))


def steps(random: Random) -> Array:
    """Steps of 33.2 px, each light at its edge and dark below."""
    size = (600, 450)
    y = (np.arange(600) - 16) % 33.2
    rows = np.interp(y, [at for at, _ in _STEP], [gray for _, gray in _STEP])
    picture = rows[:, None] * np.linspace(1.055, 0.945, 450)
    stains = noise(random, size, (5, 1, 1), (6, 3, 30), (5, 12, 60))
    picture += stains * (0.5 + rows / 240)[:, None]
    return np.repeat(np.clip(picture, 8, 255)[..., None], 3, axis=2).astype(np.float32)

"""Drawings of walls, floors, boards and grass: see drawings.py."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from bullet_sim.formats.images.painting import Array, Color, Random, bent, fill, noise, plain, toned

# Middles of the bed joints; of each course the first head joint, and from one to the next.
_BEDS = (-8, 57, 127, 195, 262, 329, 394, 459, 526, 591, 655, 720, 785, 849, 913, 975, 1037)
_HEADS = (35, 115, 39, 127, 56, 124, 59, 132, 57, 134, 67, 142, 71, 154, 72, 155)
_PITCHES = (199, 188)  # of the first and the last course
_BRICKS = (  # share, color, deviation
    (0.33, (165, 90, 72), 5),
    (0.34, (154, 84, 62), 5),
    (0.18, (145, 73, 55), 4),
    (0.08, (176, 150, 95), 7),
    (0.07, (98, 74, 70), 7),
)
_MORTAR = ((-7, (84, 66, 100)), (-4, (98, 96, 146)), (0, (142, 164, 210)), (5, (180, 188, 208)))
_HEAD = ((-8, (174, 145, 172)), (-5, (155, 164, 194)), (0, (113, 149, 183)), (6, (113, 126, 146)))


def _shades(at: Array, steps: Sequence[tuple[float, Color]]) -> Array:
    """Colors across a joint.

    Args:
        at: distance from its middle.
        steps: distances and their colors.
    """
    x, colors = [step for step, _ in steps], np.float32([color for _, color in steps])
    table = np.stack([np.interp(np.arange(-80, 81) / 8, x, colors[:, k]) for k in range(3)], axis=1)
    index = np.clip(at * 8 + 80.5, 0, 160).astype(np.intp)
    return np.take(table.astype(np.float32), index, axis=0)


def bricks(random: Random) -> Array:
    """15 courses in running bond."""
    size = (1024, 1024)
    limits = np.cumsum([share for share, _, _ in _BRICKS])[:-1]
    sort = np.searchsorted(limits, random.permutation(144) / 144, "right").reshape(16, 9)
    colors = np.float32([color for _, color, _ in _BRICKS])[sort]
    deviations = np.float32([deviation for _, _, deviation in _BRICKS])[sort]
    colors += (deviations * random.standard_normal((16, 9)).astype(np.float32))[..., None]
    y, x = np.mgrid[:1024, :1024].astype(np.float32)
    # edges are rough
    y += noise(random, size, (1.1, 12, 24), (0.5, 4, 5))
    x += noise(random, size, (1.1, 24, 12), (0.5, 5, 4))
    grain = noise(random, size, (9.5, 1, 1), (6, 4, 4), (4, 20, 14), (4, 40, 9))
    ocher = noise(random, size, (2.5, 40, 9), (2.5, 20, 24))
    arrays = x, y, grain, ocher, np.roll(grain, 512, axis=1)
    strips = [slice(at, at + 64) for at in range(0, 1024, 64)]  # small arrays are faster
    return np.concatenate([_bricks_of(colors, *(array[at] for array in arrays)) for at in strips])


def _bricks_of(
    colors: Array, x: Array, y: Array, grain: Array, ocher: Array, rough: Array
) -> Array:
    """Bricks and mortar at some positions.

    Args:
        colors: (16, 9, 3) of each course's bricks.
        grain, ocher: of the bricks; how light and how brown they are.
        rough: grain of the mortar.
    """
    beds = np.float32(_BEDS)
    course = np.clip(np.searchsorted(beds, y) - 1, 0, 15)
    above, below = y - beds[course], beds[course + 1] - y  # distances from the bed joints
    pitch = np.linspace(*_PITCHES, 16, dtype=np.float32)[course]
    along = (x - np.float32(_HEADS)[course]) / pitch
    across = (along - np.rint(along)) * pitch  # from the middle of the nearest head joint
    aside = np.abs(across)
    picture = colors[course, np.floor(along).astype(int) + 2]
    picture += cv2.merge([grain + 2, grain + ocher, grain - ocher - 3])
    rim = 1 - np.clip(np.minimum(np.minimum(above, below), aside) / 24, 0, 1)
    light = np.interp(below, (7, 9, 13, 18), (0.66, 0.70, 0.85, 1.0)).astype(np.float32)
    light *= np.interp(above, (5, 9, 14), (1.12, 1.08, 1.0)).astype(np.float32)
    red, green, blue = (light * (1 + part * rim) for part in (0.04, -0.22, -0.12))
    picture *= cv2.merge([red, green, blue])  # redder towards the edges
    depth = np.where(above < below, above, -below)
    for joint, mask in (
        (_shades(across, _HEAD), np.clip(7.6 - aside, 0, 1)),
        (_shades(depth, _MORTAR), np.clip(6.9 - np.abs(depth), 0, 1)),
    ):
        picture += (joint + rough[..., None] - picture) * mask[..., None]
    return picture


_HARDWOOD = (
    (93, 16, 0),
    (113, 36, 1),
    (132, 55, 2),
    (143, 67, 7),
    (154, 79, 17),
    (168, 96, 34),
    (182, 111, 51),
)
_PARQUET = (
    (155, 77, 30),
    (168, 92, 37),
    (179, 107, 43),
    (184, 115, 47),
    (189, 122, 53),
    (197, 132, 61),
    (204, 139, 70),
)


def hardwood(random: Random) -> Array:
    """Boards of 256 x 128, four rows with gaps between them."""
    picture = plain((512, 512), (0, 0, 0))
    for row, joint in enumerate((115, 252, 52, 248)):
        for start in (joint, joint + 256):
            size = (128, 256)
            values = noise(random, size, (0.55, 4, 200), (0.4, 16, 250), (0.25, 1.5, 120))
            values = bent(values, random, 3.5, 4.0, (64, 128))
            figure = noise(random, size, (0.35, 80, 10), (0.3, 40, 40))
            values += bent(figure, random, 4.0, 10.0, (43, 64)) + random.normal(0.0, 0.3)
            columns = np.arange(start, start + 256) % 512
            picture[128 * row : 128 * row + 128, columns] = toned(values, _HARDWOOD)
        for x in (joint, joint + 256):
            fill(picture, x - 2, 128 * row, 4, 128, (38, 0, 0))
    for y in (0, 126, 254, 382, 510):
        fill(picture, 0, y, 512, 2 if y in (0, 510) else 4, (36, 0, 0))
    return picture


_STRIPS = (  # y of a strip's top, x of its joints
    (3, (163, 273, 352)),
    (40, (7, 145, 273, 401)),
    (76, (56, 192, 273, 385)),
    (112, (85, 171, 285, 437)),
    (148, (12, 170, 331)),
    (184, (58, 170, 260)),
    (221, (71, 200, 321)),
    (259, (130, 262, 379)),
    (296, (43, 176, 294)),
)


def parquet(random: Random) -> Array:
    """A parquet floor with the reflection of a lamp."""
    size = (329, 496)
    picture = plain(size, (0, 0, 0))
    tops = [top for top, _ in _STRIPS] + [size[0] + _STRIPS[0][0]]
    for (top, joints), bottom in zip(_STRIPS, tops[1:]):
        rows = np.arange(top, bottom) % size[0]
        for start, end in zip(joints, (*joints[1:], joints[0] + size[1])):
            board = (bottom - top, end - start)
            values = noise(random, board, (0.35, 3, 120), (0.35, 12, 200), (0.3, 9, 40))
            values = bent(values, random, 1.2, 4.0, (37, 90)) + random.normal(0.0, 0.7)
            values += noise(random, board, (0.25, 1, 3))
            columns = np.arange(start, end) % size[1]
            colors = toned(0.65 * values, _PARQUET)
            colors[:, 0] *= 0.93
            colors[-1] *= 0.96
            picture[np.ix_(rows, columns)] = colors
    y, x = np.mgrid[: size[0], : size[1]]
    near = np.exp(-(((x - 235) / 105) ** 2) / 2 - ((np.minimum(y, 329 - y / 9) - 20) / 85) ** 2 / 2)
    picture *= (1.04 - 0.12 * y / size[0])[..., None]
    return picture + near[..., None] * np.float32((40, 78, 112))


def ceiling(random: Random) -> Array:
    """25 equal tiles with dark specks."""
    tile = plain((60, 60), (242, 242, 242))
    spots = noise(random, (60, 60), (1.0, 1.3, 1.3))
    shade = np.interp(spots, (-3.0, -2.0, -1.1, -0.6, 0.0, 2.0), (186, 199, 217, 235, 242, 250))
    tile[:] = shade[..., None]
    picture = np.tile(tile, (5, 5, 1))
    for at in (0, 59, 118, 179, 239, 299):
        for wide, gray in ((1, 229), (0, 190)):
            low, high = max(0, at - wide), at + wide + 1
            picture[low:high] = np.minimum(picture[low:high], gray)
            picture[:, low:high] = np.minimum(picture[:, low:high], gray)
    for at in (118, 179, 239):  # these are wider
        picture[at : at + 2] = picture[:, at : at + 2] = (182, 182, 182)
    return picture


def painted_wall(_: Random) -> Array:
    """From white down to yellow, below it a brown wainscot and its base."""
    y = np.arange(512)
    white, yellow = np.float32((255, 255, 254.5)), np.float32((240, 221, 93))
    rows = white + (yellow - white) * np.clip(y / 304, 0, 1)[:, None]
    rows[365:490], rows[490:] = (201, 111, 15), (104, 54, 1)
    return np.repeat(rows[:, None].astype(np.float32), 512, axis=1)


_BANDS = (  # y, height, x and width, colour, deviation of its grain
    (36, 48, 6, 246, (111, 72, 27), 11),
    (84, 3, 3, 249, (138, 76, 19), 6),
    (87, 42, 5, 246, (162, 119, 62), 10),
    (129, 17, 0, 256, (174, 100, 20), 4),
    (146, 51, 0, 256, (169, 124, 66), 8),
    (197, 13, 0, 256, (193, 134, 62), 3),
    (210, 46, 0, 256, (167, 122, 64), 8),
)
_NAILS = ((8, 156), (244, 155), (9, 180), (244, 179), (11, 219), (245, 219), (10, 242), (246, 244))


def pallet(random: Random) -> Array:
    """Boards over each other, the end of one at the top, nails."""
    picture = plain((256, 256), (0, 0, 0))
    for y, height, x, width, color, deviation in _BANDS:
        grain = noise(random, (height, width), (0.75, 2, 50), (0.5, 6, 40), (0.4, 1.5, 6))
        colors = np.float32(color) + grain[..., None] * deviation * np.float32((1.1, 1, 0.8))
        picture[y : y + height, x : x + width] = colors
    soft = np.clip(np.interp(np.arange(256), (3, 12, 75, 85), (0, 1, 1, 0)), 0, 1)
    picture[6:33] = soft[:, None] * np.float32((203, 133, 47))
    grain = noise(random, (31, 63), (6, 4, 20), (5, 31, 2))
    picture[4:35, 12:75] = np.float32((168, 115, 63)) + grain[..., None]
    for x, y in _NAILS:
        cv2.circle(picture, (x, y), 2, (80, 62, 36), -1)
    return np.maximum(picture, 0)


def grass(random: Random) -> Array:
    values = noise(random, (256, 256), (0.86, 1.4, 1.4), (0.35, 4, 4), (0.25, 8, 8))
    values += noise(random, (256, 256), (0.12, 24, 24))
    return toned(
        values,
        (
            (23, 74, 1),
            (35, 90, 4),
            (49, 109, 7),
            (60, 122, 11),
            (73, 136, 15),
            (93, 153, 26),
            (115, 168, 39),
        ),
    )

"""Drawings of signs and of the runway: see drawings.py."""

import cv2
import numpy as np

from bullet_sim.formats.images.painting import Array, Random, fill, plain


def frame(_: Random) -> Array:
    """A black frame around what has no alpha."""
    picture = plain((100, 100), (0, 0, 0, 255))
    picture[10:90, 10:90] = (255, 255, 255, 0)
    return picture


def center_of_mass(_: Random) -> Array:
    """White and black squares of 50."""
    y, x = np.mgrid[:100, :200] // 50
    return np.where((x + y) % 2 == 0, 255, 0)[..., None] * np.ones(3, np.float32)


_MARKINGS = (  # x, y, width and height on the upper half; the lower half mirrors them
    *((x, y, 65, 8.5) for x in (167, 1235) for y in (9, 22.5, 36)),
    (337, 17, 62, 16),
    (470, 16, 88, 16),
    (630, 20, 60, 10),
    (774, 23, 60, 5),
)


_OUTLINE = (  # with its gray
    *((154, y, 1159, 1, gray) for y, gray in ((1, 239), (2, 194), (101, 194), (102, 239))),
    *((x, 1, 1, 102, gray) for x, gray in ((154, 250), (155, 255), (156, 216))),
    *((x, 1, 1, 102, gray) for x, gray in ((1309, 127), (1310, 255), (1311, 255), (1312, 161))),
)


def runway(_: Random) -> Array:
    """Thresholds, numbers, touchdown zones, center line and the chevrons beyond its end."""
    picture = plain((104, 1462), (77, 77, 77))
    white, yellow = (255.0, 255.0, 255.0), (255.0, 255.0, 0.0)
    for apex in (1291, 1342, 1391, 1440):
        points = np.int32([[apex + 73, 6], [apex, 52], [apex + 73, 98]])
        cv2.polylines(picture, [points], False, yellow, 4)
    picture[:, 1461] = picture[:, :1313] = (77, 77, 77)
    for x, y, width, height, gray in _OUTLINE:
        fill(picture, x, y, width, height, (gray, gray, gray))
    for left, top, wide, tall in _MARKINGS:
        fill(picture, left, top, wide, tall, white)
        fill(picture, left, 104 - top - tall, wide, tall, white)
    for number in range(12):
        fill(picture, 314 + 72.8 * number, 50, 35, 4, white)
    picture[33:71, 249:284] = 77 + _stroke("36")[::-1, ::-1].T[..., None] * 178
    picture[34:72, 1181:1216] = 77 + _stroke("18").T[..., None] * 178
    return picture


def _stroke(text: str) -> Array:
    """Text of 35 x 38, 0..1."""
    large = np.zeros((200, 300), np.uint8)
    cv2.putText(large, text, (20, 170), cv2.FONT_HERSHEY_SIMPLEX, 5.0, 255, 14)
    x, y, width, height = cv2.boundingRect(large)
    cut = large[y : y + height, x : x + width]
    return cv2.resize(cut, (38, 35), interpolation=cv2.INTER_AREA).astype(np.float32) / 255

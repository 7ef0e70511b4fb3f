"""Draws docs/images/lap.webp: a lap's film and the path driven so far, from ./run lap's out/lap/.

Call it as: ./run lap --driver line && ./run exec python docs/tools/lap_picture.py
"""

import csv
import pathlib

import av
import cv2
import numpy as np
from PIL import Image

from track_model import track

ROOT = pathlib.Path(__file__).resolve().parents[2]
LAP, PICTURE = ROOT / "out" / "lap", ROOT / "docs" / "images" / "lap.webp"
HEIGHT = 240  # of both halves [px]
EVERY, PACE = 8, 180  # frames of the film, [ms] between pictures: the lap in a quarter of its time
MOVING = 0.01  # [m/s]
BLUE, WHITE = (40, 140, 255), (255, 255, 255)


def film(path):
    """Yields the film's frames, (H, W, 3) RGB."""
    with av.open(str(path)) as container:
        for frame in container.decode(video=0):
            yield frame.to_ndarray(format="rgb24")


def driven(path):
    """The path's positions from where the car starts to move, as the film does, (N, 2) [m]."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    start = next(index for index, row in enumerate(rows) if float(row["v"]) > MOVING)
    return np.array([(float(row["x"]), float(row["y"])) for row in rows[start:]])


class Map:
    """The track from above.

    Args:
        name: Of the track.
    """

    def __init__(self, name):
        found = track.load_track(name)
        picture = cv2.cvtColor(cv2.imread(found.texture), cv2.COLOR_BGR2RGB)
        self._scale = HEIGHT / picture.shape[0]
        width = round(picture.shape[1] * self._scale)
        self._picture = cv2.resize(picture, (width, HEIGHT), interpolation=cv2.INTER_AREA)
        xmin, xmax, _, ymax = found.extent
        self._origin = np.array([xmin, ymax])
        self._pixels = width / (xmax - xmin)  # [px/m]

    def with_path(self, path):
        """Gives the picture with a path, (N, 2) [m], and the car at its end."""
        points = ((path - self._origin) * (self._pixels, -self._pixels) * 16).astype(np.int32)
        drawn = self._picture.copy()
        cv2.polylines(drawn, [points], False, BLUE, 2, cv2.LINE_AA, shift=4)
        cv2.circle(drawn, tuple(int(v) for v in points[-1]), 5 * 16, WHITE, -1, cv2.LINE_AA, 4)
        return drawn


def main():
    """Draws the picture."""
    frames, path, above = list(film(LAP / "lap.mp4")), driven(LAP / "path.csv"), Map("default")
    pictures = []
    for index in range(0, len(frames), EVERY):
        seen = cv2.resize(frames[index], (HEIGHT * 4 // 3, HEIGHT), interpolation=cv2.INTER_AREA)
        until = max(2, round((index + 1) / len(frames) * len(path)))
        pictures.append(Image.fromarray(np.hstack([seen, above.with_path(path[:until])])))
    pictures[0].save(
        PICTURE, save_all=True, append_images=pictures[1:], duration=PACE, loop=0, quality=60
    )
    print(f"{PICTURE}: {len(pictures)} pictures, {PICTURE.stat().st_size // 1024} KB")


if __name__ == "__main__":
    main()

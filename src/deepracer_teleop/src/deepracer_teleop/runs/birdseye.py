"""Draws a track from above with the path that was driven on it."""

import cv2
import numpy as np

MARGIN = 70  # around the track, for the axes [px]
COLOURS = ((255, 160, 40), (80, 80, 255))  # BGR: buttons, cruise
FONT = cv2.FONT_HERSHEY_SIMPLEX


class View:
    """Maps metres to pixels: x to the right, y upwards."""

    def __init__(self, extent, width=1200):
        """Fits an extent (xmin, xmax, ymin, ymax) [m] into a width [px]."""
        self.xmin, self.xmax, self.ymin, self.ymax = extent
        self.scale = (width - 2 * MARGIN) / (self.xmax - self.xmin)
        self.shape = (round((self.ymax - self.ymin) * self.scale) + 2 * MARGIN, width, 3)

    def pixels(self, points):
        """Returns (N, 2) int32 pixels of (N, 2) metres."""
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        return np.round(
            np.column_stack(
                [
                    MARGIN + (points[:, 0] - self.xmin) * self.scale,
                    MARGIN + (self.ymax - points[:, 1]) * self.scale,
                ]
            )
        ).astype(np.int32)


def draw(track, samples, width=1200, names=("buttons", "cruise + slider")):
    """Draws track, path, start, axes in metres and a scale bar.

    Args:
        track: track_model.track.Track: centreline, inner, outer, extent and texture.
        samples: Recorder samples, at least one; phases that begin with "cruise" get a colour of
            their own.
        width: Of the picture [px].
        names: Labels of the path's colours; with one label the path has one colour.

    Returns:
        (H, W, 3) uint8 BGR.
    """
    view = View(track.extent, width)
    picture = np.full(view.shape, 250, np.uint8)
    _draw_ground(picture, view, track)
    _draw_axes(picture, view)
    points = view.pixels([(sample.x, sample.y) for sample in samples])
    for first, second, sample in zip(points[:-1], points[1:], samples[1:]):
        colour = COLOURS[len(names) > 1 and sample.phase.startswith("cruise")]
        cv2.line(picture, tuple(map(int, first)), tuple(map(int, second)), colour, 3, cv2.LINE_AA)
    _draw_ends(picture, view, samples)
    _draw_legend(picture, view, names)
    return picture


def _draw_ground(picture, view, track):
    (left, top), (right, bottom) = view.pixels([(view.xmin, view.ymax), (view.xmax, view.ymin)])
    texture = cv2.imread(track.texture)
    if texture is not None:
        picture[top:bottom, left:right] = cv2.resize(
            texture, (right - left, bottom - top), interpolation=cv2.INTER_AREA
        )
        return
    for line, colour in (
        (track.outer, (90, 90, 90)),
        (track.inner, (90, 90, 90)),
        (track.centreline, (20, 140, 245)),
    ):
        cv2.polylines(picture, [view.pixels(line)], True, colour, 2, cv2.LINE_AA)


def _draw_axes(picture, view):
    (left, top), (right, bottom) = view.pixels([(view.xmin, view.ymax), (view.xmax, view.ymin)])
    cv2.rectangle(picture, (int(left), int(top)), (int(right), int(bottom)), (60, 60, 60), 1)
    for metre in range(int(np.ceil(view.xmin)), int(view.xmax) + 1):
        x = int(view.pixels([(metre, 0)])[0, 0])
        cv2.line(picture, (x, bottom), (x, bottom + 6), (60, 60, 60), 1)
        _write(picture, f"{metre}", (x, bottom + 22), centred=True)
    for metre in range(int(np.ceil(view.ymin)), int(view.ymax) + 1):
        y = int(view.pixels([(0, metre)])[0, 1])
        cv2.line(picture, (left - 6, y), (left, y), (60, 60, 60), 1)
        _write(picture, f"{metre}", (left - 22, y + 5), centred=True)
    _write(picture, "x [m]", ((left + right) // 2, bottom + 46), centred=True)
    _write(picture, "y [m]", (left - 40, top - 14))


def _draw_ends(picture, view, samples):
    first, last = samples[0], samples[-1]
    start = view.pixels([(first.x, first.y)])[0]
    tip = view.pixels([(first.x + 0.35 * np.cos(first.yaw), first.y + 0.35 * np.sin(first.yaw))])[0]
    for colour, width in (((0, 0, 0), 6), ((90, 230, 90), 3)):
        cv2.arrowedLine(
            picture,
            tuple(map(int, start)),
            tuple(map(int, tip)),
            colour,
            width,
            cv2.LINE_AA,
            tipLength=0.4,
        )
        cv2.circle(picture, tuple(map(int, start)), 7 + width // 3, colour, -1, cv2.LINE_AA)
    end = tuple(map(int, view.pixels([(last.x, last.y)])[0]))
    cv2.circle(picture, end, 9, (0, 0, 0), -1, cv2.LINE_AA)
    cv2.circle(picture, end, 6, (255, 255, 255), -1, cv2.LINE_AA)


def _draw_legend(picture, view, names):
    left, top = MARGIN + 90, MARGIN - 40
    for words, colour in (("start", (90, 230, 90)), *zip(names, COLOURS), ("end", (0, 0, 0))):
        cv2.circle(picture, (left, top + 8), 7, colour, 1 if words == "end" else -1, cv2.LINE_AA)
        _write(picture, words, (left + 14, top + 13))
        left += 40 + 10 * len(words)
    right = view.shape[1] - MARGIN
    begin = right - round(view.scale)
    cv2.line(picture, (begin, top + 8), (right, top + 8), (0, 0, 0), 4)
    _write(picture, "1 m", (begin - 42, top + 13))


def _write(picture, words, place, centred=False):
    (width, _), _ = cv2.getTextSize(words, FONT, 0.5, 1)
    x = int(place[0]) - (width // 2 if centred else 0)
    cv2.putText(picture, words, (x, int(place[1])), FONT, 0.5, (40, 40, 40), 1, cv2.LINE_AA)

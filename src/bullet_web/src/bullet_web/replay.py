"""A recording as one HTML file that opens without a server and without the internet. No ROS.

The file has the page, three.js, the scenes with their meshes and images, and the states of what
moves; a policy in it keeps the browser from loading anything else.
"""

from __future__ import annotations

import array
import base64
import contextlib
import io
import json
import os
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from PIL import Image

from bullet_web.scene import Asset, Scene
from bullet_web.server import File

LIMIT = 10_000_000  # [B] of a file
MIN_SIDE = 256  # [px] to which images are shrunk at most
MAX_FRAMES = 20000  # then every second one is dropped
MAX_PARTS = 200  # then every second one is left out: time was reset again and again
MAX_SAMPLES = 5000  # of a curve
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
)
SCRIPTS = ("three.min.js", "OrbitControls.js", "world.js", "panels.js", "replay.js")


class TooLarge(ValueError):
    """A recording does not fit into LIMIT."""


class Part:
    """Frames of one scene: times [s] and flat rows of the bodies that move."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        moving = [body for body in scene["bodies"] if not body["static"]]
        self.widths = {body["key"]: len(body["state"]) - 1 for body in moving}
        self._last = {body["key"]: body["state"][1:] for body in moving}
        self.times: list[float] = []
        self.rows: list[array.array[float]] = []

    def add(self, time: float, bodies: Sequence[Sequence[float]]) -> None:
        """Add a frame; a body without a state stays."""
        for row in bodies:
            if len(row) - 1 == self.widths.get(int(row[0])):
                self._last[int(row[0])] = list(row[1:])
        self.times.append(time)
        self.rows.append(array.array("f", [value for row in self._last.values() for value in row]))

    def thin(self) -> None:
        """Drop every second frame, but not the last."""
        keep = [i for i in range(len(self.times)) if i % 2 == 0 or i == len(self.times) - 1]
        self.times = [self.times[i] for i in keep]
        self.rows = [self.rows[i] for i in keep]

    def encoded(self, before: Scene | None) -> Scene:
        """For the page; numbers are little-endian float32, times float64.

        Args:
            before: the scene of the part before, which is not repeated.
        """
        times, rows = array.array("d", self.times), array.array("f")
        for row in self.rows:
            rows.extend(row)
        if sys.byteorder == "big":
            times.byteswap()
            rows.byteswap()
        return {
            "scene": None if self.scene is before else self.scene,
            "bodies": [[key, width] for key, width in self.widths.items()],
            "times": base64.b64encode(times.tobytes()).decode(),
            "rows": base64.b64encode(rows.tobytes()).decode(),
        }


class Recording:
    """Frames of a world, in parts of one scene each.

    Attributes:
        title: of the page.
        text: shown with the plots.
    """

    def __init__(self, title: str = "Paddock") -> None:
        self.title, self.text = title, ""
        self._parts: list[Part] = []
        self._assets: dict[str, Asset] = {}
        self._curves: dict[str, dict[str, Any]] = {}

    @property
    def frames(self) -> int:
        """How many there are."""
        return sum(len(part.times) for part in self._parts)

    def set_scene(self, scene: Scene, assets: Mapping[str, Asset]) -> None:
        """What follows belongs to this scene (SceneMaker.make) with its assets."""
        self._parts.append(Part(scene))
        self._assets.update(assets)

    def add(self, time: float, bodies: Sequence[Sequence[float]]) -> None:
        """Add a frame.

        Args:
            time: simulated [s]; an earlier one than the last begins a new part.
            bodies: as in a view: key, position, quaternion, joints of each.
        """
        part = self._parts[-1]
        if part.times and time <= part.times[-1]:
            if time == part.times[-1]:
                return
            if len(self._parts) >= MAX_PARTS:
                del self._parts[1::2]
            self._parts.append(part := Part(part.scene))  # time was reset
        part.add(time, bodies)
        if self.frames > MAX_FRAMES:
            for part in self._parts:
                part.thin()

    def add_value(self, name: str, unit: str, time: float, value: float) -> None:
        """Add a point of a curve for the plots; an earlier one than the last starts it anew."""
        points = self._curves.setdefault(name, {"unit": unit, "points": []})["points"]
        if points and time < points[-1][0]:
            points.clear()
        points.append([round(time, 3), round(value, 4)])
        if len(points) > MAX_SAMPLES:
            del points[1::2]

    def html(self, files: Mapping[str, File]) -> str:
        """The page, in at most LIMIT bytes; images and the number of frames give way.

        Args:
            files: those of the page, by name.

        Raises:
            TooLarge: even then it is larger.
            ValueError: there is no frame.
        """
        if not self.frames:
            raise ValueError("nothing was recorded")
        side = 4096
        while True:
            page = self._page(files, side)
            size = len(page.encode())
            if size <= LIMIT:
                return page
            if side > MIN_SIDE:
                side //= 2
            elif self.frames > 4 * len(self._parts):
                for part in self._parts:
                    part.thin()
            else:
                raise TooLarge(
                    f"the recording has {size / 1e6:.1f} MB with its meshes alone, at most "
                    f"{LIMIT / 1e6:g} MB fit"
                )

    def write(self, path: str | os.PathLike[str], files: Mapping[str, File]) -> int:
        """Write the page; returns its size [B].

        Raises:
            TooLarge, ValueError: as html().
            OSError: it cannot be written.
        """
        data = self.html(files).encode()
        part = Path(f"{os.fspath(path)}.{os.getpid()}.part")
        try:
            part.write_bytes(data)
            os.replace(part, path)
        except OSError:
            with contextlib.suppress(OSError):
                part.unlink()  # half of it is of no use, and fills the disk
            raise
        return len(data)

    def _page(self, files: Mapping[str, File], side: int) -> str:
        parts = [part for part in self._parts if part.times]
        scenes = [None, *(part.scene for part in parts)]
        names = {
            name
            for part in parts
            for body in part.scene["bodies"]
            for link in body["links"]
            for instance in link["instances"]
            for name in (instance["mesh"], instance["image"])
            if name
        }
        data = {
            "title": self.title,
            "text": self.text,
            "parts": [part.encoded(before) for before, part in zip(scenes, parts)],
            "curves": self._curves,
            "assets": {name: _address(shrunk(self._assets[name], side)) for name in sorted(names)},
        }
        content = {name: file.data.decode("utf-8", "replace") for name, file in files.items()}
        text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
        scripts = [f"<script>window.REPLAY = {text};</script>"]
        scripts += [f"<script>{_inlined(content[name])}</script>" for name in SCRIPTS]
        page = content["index.html"]
        head = f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        style = f"<style>{content['page.css']}</style>"
        page = page.replace('<meta charset="utf-8">', f'<meta charset="utf-8">{head}')
        page = page.replace('<link rel="stylesheet" href="page.css">', style)
        page = page.replace("<body>", '<body class="is-replay">')
        start, end = page.index("<!-- scripts -->"), page.index("<!-- /scripts -->")
        return page[:start] + "\n".join(scripts) + page[end:]


def _inlined(script: str) -> str:
    """A script as text of an HTML element, which "</script" in a string of it would end."""
    return re.sub("</(?=script)", r"<\\/", script, flags=re.IGNORECASE)


def shrunk(asset: Asset, side: int) -> Asset:
    """An image of at most `side` pixels; other assets as they are."""
    if not asset.type.startswith("image/"):
        return asset
    image = Image.open(io.BytesIO(asset.data))
    if max(image.size) <= side:
        return asset
    image.thumbnail((side, side))
    stream = io.BytesIO()
    image.save(stream, image_format(asset), quality=80)
    return asset._replace(data=stream.getvalue())


def image_format(asset: Asset) -> str:
    """Name of its format for Pillow."""
    return "PNG" if asset.type == "image/png" else "JPEG"


def _address(asset: Asset) -> str:
    return f"data:{asset.type};base64,{base64.b64encode(asset.data).decode()}"

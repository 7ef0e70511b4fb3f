"""Drives in the gym as replays: HTML files for any browser, where bullet_web is installed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bullet_sim.sensors.scenes import WorldViews


class ReplayRecorder:
    """Keeps the frames of a world, and writes them as a replay.

    Args:
        world: bullet_sim.world.World, of which a frame is kept at each add().
        title: of the page.

    Raises:
        ImportError: bullet_web or what it needs is not installed.
    """

    def __init__(self, world: Any, title: str) -> None:
        from bullet_web.replay import Recording
        from bullet_web.scene import SceneMaker

        self._views, self._maker = WorldViews(world), SceneMaker()
        self._recording, self._scene = Recording(title), 0

    def add(self) -> None:
        """Keep the world as it is now."""
        view = self._views.view()
        if view["scene"] != self._scene:
            self._scene = view["scene"]
            scene = self._maker.make(self._views.scene())
            self._recording.set_scene(scene, self._maker.assets)
        self._recording.add(view["time"], view["bodies"])

    def write(self, path: str, text: str) -> None:
        """Write the file; the text is shown with the plots.

        Raises:
            OSError: it cannot be written, or three.js is not installed.
            ValueError: nothing was kept, or the meshes alone are too large for a replay.
        """
        from bullet_web import files

        self._recording.text = text
        self._recording.write(path, files.read(files.REPLAY))


def keep(world: Any, title: str, path: str, drive: Callable[[Callable[[], None]], str]) -> str:
    """Drive once and write the drive as a replay.

    Args:
        drive: function of `add_frame`, which it calls after every action; returns a text for the
            replay.

    Returns:
        Why there is no replay, or an empty text; the drive is done in any case.
    """
    try:
        recorder = ReplayRecorder(world, title)
    except ImportError as error:
        drive(lambda: None)
        return str(error)
    text = drive(recorder.add)
    try:
        recorder.write(path, text)
    except (OSError, ValueError) as error:
        return str(error)
    return ""

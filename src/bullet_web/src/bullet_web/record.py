"""The node `record`: keeps what happens in the world as a replay, and writes it when it ends.

Its parameter ~recording is true as soon as it has the first frame.
"""

from __future__ import annotations

import os
import sys
import threading
from dataclasses import dataclass
from typing import Any

import roslib.message
import rospy
from paddock_common.nodes import run
from paddock_common.settings import check, number, read, text

from bullet_web import files
from bullet_web.replay import Recording
from bullet_web.simulator import Simulator

REFEREE = "/referee/status"
RECORDING = "~recording"


@dataclass(frozen=True)
class Settings:
    """Settings of the node.

    Attributes:
        out: file to write, such as /tmp/replay.html.
        title: of the page.
        rate: frames a second of wall time.
        simulator: name of its node.
    """

    out: str = text("replay.html")
    title: str = text("Paddock")
    rate: float = number(20.0, above=0.0, max=100.0, unit="Hz")
    simulator: str = text("/gazebo")

    def __post_init__(self) -> None:
        check(self)
        folder = os.path.dirname(os.path.abspath(self.out))
        if not os.path.isdir(folder):
            raise ValueError(f"out is {self.out!r}; there is no folder {folder}")


class Recorder:
    """Records from its construction to the end of the node."""

    def __init__(self) -> None:
        self._settings = read(Settings, rospy.get_param)
        self._files = files.read(files.REPLAY)
        self._recording = Recording(self._settings.title)
        self._lock = threading.Lock()
        self._is_recording = False
        rospy.set_param(RECORDING, False)
        self._simulator = Simulator(
            self._settings.rate,
            self._new_scene,
            self._new_view,
            lambda contacts: None,
            lambda reason: None,
            self._settings.simulator,
        )
        self._simulator.watch(True)
        self._simulator.start()
        kind = roslib.message.get_message_class("track_model/LapStatus")
        if kind is not None:
            rospy.Subscriber(REFEREE, kind, self._new_lap, queue_size=1)
        rospy.on_shutdown(self._write)

    def _new_scene(self, _: int) -> None:
        with self._lock:
            self._recording.set_scene(self._simulator.scene, self._simulator.assets)

    def _new_view(self, view: dict[str, Any], _: str) -> None:
        with self._lock:
            self._recording.add(view["time"], view["bodies"])
        if not self._is_recording:
            self._is_recording = True
            rospy.set_param(RECORDING, True)

    def _new_lap(self, message: Any) -> None:
        with self._lock:
            time = message.header.stamp.to_sec()
            self._recording.add_value("to the center line", "m", time, message.lateral_error)
            if message.laps:
                self._recording.text = (
                    f"{message.laps} laps, best {message.best_lap_time:.2f} s, penalty "
                    f"{message.penalty:g} s"
                )

    def _write(self) -> None:
        self._simulator.watch(False)
        with self._lock:
            try:
                size = self._recording.write(self._settings.out, self._files)
            except (OSError, ValueError) as error:
                print(f"no replay: {error}", file=sys.stderr, flush=True)
                return
        print(f"replay: {self._settings.out} ({size / 1e6:.1f} MB)", flush=True)


def main() -> None:
    """Run the node `record`."""
    run("record", Recorder, (ValueError, OSError), disable_rostime=True)

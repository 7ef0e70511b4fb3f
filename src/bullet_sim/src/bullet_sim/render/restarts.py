"""How often a render worker that died is started again."""

import time

from bullet_sim.errors import RenderError
from bullet_sim.render.process import Worker

MAX_RESTARTS = 3  # within ...
WINDOW = 60.0  # [s] ... of wall time: a worker that keeps dying is given up


class Restarts:
    """Starts workers in place of dead ones, at most MAX_RESTARTS within WINDOW.

    Args:
        environment: variables for the worker.
        quality: Quality.

    Attributes:
        count: of all restarts.
    """

    def __init__(self, environment, quality):
        self._environment, self._quality = environment, quality
        self._last = []  # times of the last restarts
        self.count = 0

    def replace(self, dead):
        """Close a Worker that has died and start another one.

        Returns:
            The new Worker, or None; what has happened, one line.
        """
        text = dead.exit_reason()
        dead.close()
        now = time.monotonic()
        self._last = [moment for moment in self._last if now - moment < WINDOW]
        within = f"{MAX_RESTARTS} times within {WINDOW:g} s"
        if len(self._last) >= MAX_RESTARTS:
            return None, f"{text}; it is not started again after {within}"
        try:
            worker = Worker(dead.kind, self._environment, self._quality)
        except RenderError as error:
            return None, f"{text}; it could not be started again: {error}"
        self._last.append(now)
        self.count += 1
        return worker, f"{text}; started again (at most {within})"

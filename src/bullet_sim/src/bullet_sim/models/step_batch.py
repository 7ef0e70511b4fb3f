"""Steps in one call of the solver 'ode', before which nothing but PIDs is computed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from bullet_sim.controllers.base import MAX_STEPS
from bullet_sim.controllers.manager import Manager

if TYPE_CHECKING:
    from bullet_sim.engine import Engine
    from bullet_sim.models.model import Model


class StepBatch:
    """Steps of robots whose controllers command nothing new but efforts of PIDs.

    Args:
        models: those with controllers that have to be updated before each step.
        time_step: [s].

    Attributes:
        max_steps: how many steps may be made before controllers have to be updated; 0: they have
            to be now.
    """

    def __init__(self, models: Sequence[Model], time_step: float) -> None:
        self._time_step, self.max_steps = time_step, MAX_STEPS
        self._robots: list[tuple[Model, Manager]] = []
        for model in models:
            manager = model.manager
            assert manager is not None
            is_own = manager.hardware.joints is model.joints  # not those of steer_bot
            steps = manager.steps_until_update(time_step) if is_own else 0
            self.max_steps = min(self.max_steps, steps)
            if self.max_steps == 0:
                return
            self._robots.append((model, manager))

    def make(self, engine: Engine, count: int) -> None:
        """Make steps, at most `max_steps`."""
        rows = [
            model.joints.effort_rows(manager.hardware.acting) for model, manager in self._robots
        ]
        noted = any(not each.pids for _, manager in self._robots for each in manager.updated)
        with engine.controlled(sum(rows, []), noted):
            engine.step(count - 1)
            for _, manager in self._robots:
                manager.hardware.read()  # as before the last of the steps
            engine.step(1)
        for (model, manager), of_robot in zip(self._robots, rows):
            model.joints.take_rows(manager.hardware.acting, of_robot)
            positions: list[Sequence[Sequence[float]]] = []
            for controller in manager.updated:
                order = map(model.joints.index, controller.config.joints)
                positions.append(() if controller.pids else engine.noted(model.body, order, count))
            manager.steps_made(count, self._time_step, positions)

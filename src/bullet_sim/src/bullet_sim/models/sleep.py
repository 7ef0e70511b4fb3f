"""Loose objects at rest sleep, as with Gazebo's (ODE's) automatic disabling.

A box on the ground costs PyBullet several microseconds of each step, and a multiple of that on a
mesh, however long it has been lying there. Gazebo no longer simulates a model without joints that
has been slower than 0.1 m/s and 0.1 rad/s for a second. The bounds here are tighter: nothing that
rolls or creeps visibly falls asleep. What sleeps wakes when something moves it or touches it
visibly, within the step; what is set by a service wakes it before the next step.

Bullet's own sleeping depends on timers that saved states do not have. Here bodies are put to sleep
at fixed step counts, by what can be saved.
"""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from bullet_sim.component import Stateful
from bullet_sim.pose import Quat, Vec3

if TYPE_CHECKING:
    from bullet_sim.engine import Engine
    from bullet_sim.models.model import Model

PERIOD = 0.1  # [s] of simulated time between two checks
CHECKS = 10  # of rest in a row after which a body sleeps
DISTANCE = 1e-3  # [m] within which it has to stay meanwhile
ANGLE = 5e-3  # [rad]


class Sleep(Stateful):
    """Puts loose objects to sleep that rest.

    Attributes:
        bodies: of models that may sleep.
    """

    STATE = ("bodies", "_resting")

    def __init__(self, engine: "Engine") -> None:
        self._engine = engine
        self.bodies: tuple[int, ...] = ()
        # pose at the first check of rest, checks since
        self._resting: dict[int, tuple[tuple[Vec3, Quat], int]] = {}

    @property
    def interval(self) -> int:
        """Steps between two checks."""
        return max(1, round(PERIOD / self._engine.time_step))

    def assign(self, models: Iterable["Model"]) -> None:
        """Find the models that may sleep; call it when models came or went."""
        self.bodies = tuple(model.body for model in models if may_sleep(model))
        self._resting = {}

    def update(self) -> None:
        """Put to sleep what rests, and note what was woken."""
        engine, resting = self._engine, self._resting
        for body in self.bodies:
            if engine.is_asleep(body):
                continue
            pose = engine.body_pose(body)
            first, checks = resting.get(body, (pose, 0))
            resting[body] = (first, checks + 1) if _is_near(first, pose) else (pose, 1)
        ready = {body for body, (_, checks) in resting.items() if checks > CHECKS}
        for body in sorted(ready):
            if all(
                other in ready or not engine.moves(other) or engine.is_asleep(other)
                for _, other, _, _ in engine.touching(body)
            ):
                engine.sleep(body)
                del resting[body]


def may_sleep(model: "Model") -> bool:
    """Whether a model is a loose object: without joints and without anything that acts on it."""
    return not (
        model.is_static
        or model.source.fixed_base
        or model.is_ghost
        or model.parts_joints
        or model.description.sensors
        or model.description.control_namespace is not None
        or not model.description.auto_disable
        or not all(link.gravity for link in model.description.links.values())
    )


def _is_near(first: tuple[Vec3, Quat], pose: tuple[Vec3, Quat]) -> bool:
    dot = sum(a * b for a, b in zip(first[1], pose[1]))
    return math.dist(first[0], pose[0]) < DISTANCE and abs(dot) > math.cos(0.5 * ANGLE)

"""What is spawned inside something else is pushed out gently.

Bullet corrects an overlap within a few steps, which throws a robot that was spawned in the ground
meters high. Gazebo bounds the speed of that correction. Here the links that overlap pass through
each other for the time being, and the model moves out at a bounded speed: upwards where it is
in the ground or in a slab, else along the contact's normal, or away from the other model.
"""

import math
from typing import TYPE_CHECKING

from bullet_sim.component import Stateful
from bullet_sim.pose import Vec3

if TYPE_CHECKING:
    from bullet_sim.engine import Engine
    from bullet_sim.models.model import Model

Overlap = tuple[int, int, int, float, Vec3]  # see Engine.overlaps

TOLERANCE = 5e-4  # [m] of overlap that the solver may correct by itself
SPEED = 0.3  # [m/s] at most, where no maxVel is given
RATE = 20.0  # [1/s]: speed per depth near the end
SLOWEST = 0.005  # [m/s]
SLACK = 0.5  # [m] beyond the first depth that a model may have to move before it is given up
_UPRIGHT = 0.5  # vertical part of a normal above which the direction out is upwards


class Release(Stateful):
    """Pushes overlapping models apart."""

    STATE = ("_unchecked", "_moving")

    def __init__(self, engine: "Engine") -> None:
        self._engine = engine
        self._unchecked: list[Model] = []  # to be checked before the next step
        self._moving: dict[int, _Release] = {}  # by body

    @property
    def active(self) -> bool:
        """Whether a model is being moved out, or has to be checked."""
        return bool(self._moving or self._unchecked)

    @property
    def moving(self) -> bool:
        """Whether a model is being moved out."""
        return bool(self._moving)

    def end(self) -> None:
        """Stop moving models out and leave them where they are."""
        for release in self._moving.values():
            release.restore_collisions(self._engine)
        self.clear()

    def resume(self) -> None:
        """Continue to move models out, as restored."""
        for release in self._moving.values():
            release.pass_through(self._engine)

    def check_later(self, model: "Model") -> None:
        """Check a model before the next step: its pose was set."""
        if not model.is_static and not model.source.fixed_base and model not in self._unchecked:
            self._unchecked.append(model)

    def remove(self, model: "Model") -> None:
        """Note that a model is deleted."""
        self._unchecked = [other for other in self._unchecked if other is not model]
        self._moving.pop(model.body, None)
        for release in self._moving.values():
            release.pairs = [pair for pair in release.pairs if pair[1] != model.body]

    def clear(self) -> None:
        """Note that all models were loaded again."""
        self._unchecked, self._moving = [], {}

    def move(self) -> None:
        """Set velocities for the next step."""
        for model in self._unchecked:
            self._check(model)
        self._unchecked = []
        for body, release in list(self._moving.items()):
            if not release.move(self._engine):
                del self._moving[body]

    def _check(self, model: "Model") -> None:
        before = self._moving.pop(model.body, None)
        if before is not None:
            before.restore_collisions(self._engine)
        limit = max([TOLERANCE] + [link.surface.min_depth for link in model.rigid_parts.values()])
        overlaps = self._engine.overlaps(model.body, limit)
        if overlaps:
            self._moving[model.body] = _Release(self._engine, model, overlaps, limit)


class _Release(Stateful):
    """A model that is moved out of what it overlaps."""

    STATE = ("pairs", "_left")

    def __init__(
        self, engine: "Engine", model: "Model", overlaps: list[Overlap], limit: float
    ) -> None:
        self._model, self._limit = model, limit
        self.pairs = sorted({(link, other, its) for link, other, its, _, _ in overlaps})
        depth, normal = max((depth, normal) for _, _, _, depth, normal in overlaps)
        moving = [other for _, other, _ in self.pairs if other in engine.free]
        if any(abs(normal[2]) > _UPRIGHT for *_, normal in overlaps) and len(moving) < len(
            self.pairs
        ):
            self._direction = (0.0, 0.0, 1.0)
        elif moving:
            self._direction = _apart(
                engine.base_pose(model.body)[0], engine.base_pose(moving[0])[0]
            )
        else:
            self._direction = normal
        speeds = [link.surface.max_speed for link in model.rigid_parts.values()]
        given = [speed for speed in speeds if speed]
        self._speed = max(SLOWEST, min(given)) if given else SPEED
        self._left = SLACK + 3.0 * depth
        self.pass_through(engine)

    def move(self, engine: "Engine") -> bool:
        """Set the velocity for the coming step; returns whether it has still to move."""
        body = self._model.body
        depth = max((engine.pair_depth(body, *pair) for pair in self.pairs), default=0.0)
        if depth <= self._limit or self._left <= 0.0:
            if depth > self._limit:
                self._model.description.warn(
                    f"model '{self._model.name}' is {depth:.3f} m deep in another and could not "
                    "be moved out of it"
                )
            self.restore_collisions(engine)
            engine.set_base_velocity(body, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            return False
        speed = min(self._speed, max(SLOWEST, RATE * depth))
        self._left -= speed * engine.time_step
        # gravity acts within the step
        velocity = [
            speed * w - g * engine.time_step for w, g in zip(self._direction, engine.gravity)
        ]
        engine.set_base_velocity(body, velocity, (0.0, 0.0, 0.0))
        return True

    def pass_through(self, engine: "Engine") -> None:
        """Disable the collisions of the pairs."""
        for link, other, its in self.pairs:
            engine.set_pair_collision(self._model.body, link, other, its, False)

    def restore_collisions(self, engine: "Engine") -> None:
        """Enable the collisions of the pairs."""
        for link, other, its in self.pairs:
            engine.set_pair_collision(self._model.body, link, other, its, True)


def _apart(mine: Vec3, other: Vec3) -> Vec3:
    """Horizontal unit vector from the other model to mine; to the left where both are one."""
    x, y = mine[0] - other[0], mine[1] - other[1]
    length = math.hypot(x, y)
    return (x / length, y / length, 0.0) if length > 1e-3 else (0.0, 1.0, 0.0)

"""The wind of a world, as Gazebo's WindPlugin has it, and its force on links."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from bullet_sim.component import Stateful
from bullet_sim.description.model import Link
from bullet_sim.description.world import Wind
from bullet_sim.pose import Array, Pose

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from bullet_sim.models.model import Model

SEED = 1  # of its noise


class WindForces(Stateful):
    """Pushes links that have enable_wind by their masses and how much slower they are.

    As there the wind's means go on once for each such link in each step, so that it rises the
    faster the more of them there are.

    Args:
        models: function that gives the models of the world.
    """

    STATE = ("_speed", "_vertical", "_direction", "_rng")

    def __init__(self, models: Callable[[], Iterable[Model]], wind: Wind) -> None:
        self._models, self._wind = models, wind
        self.restart()

    def restart(self) -> None:
        """As at the start."""
        self._speed = self._vertical = self._direction = 0.0  # means [m/s, degrees]
        self._rng = np.random.default_rng(SEED)

    def _links(self) -> Iterator[tuple[Model, Link]]:
        """Links as Gazebo has them, of a URDF with what is merged into them."""
        for model in self._models():
            described = model.description
            if not model.is_static and described.motion is None:
                links = model.rigid_parts if described.is_urdf else described.links
                for name, link in links.items():
                    if described.links[name].wind:
                        yield model, link

    def update(self, time: float, period: float) -> None:
        """Push the links during the step of this length [s] that ends at a time [s]."""
        for model, link in list(self._links()):
            velocity = self._velocity(time, period)
            pose, linear, _ = model.link_state(link.name)
            force = link.mass * self._wind.factor * (velocity - linear)
            place = (pose * Pose(tuple(link.center.tolist()))).position
            part = model.link_in_body(link.name)[0]
            model.body.apply_force(part, force.tolist(), place)

    def _velocity(self, time: float, period: float) -> Array:
        """Of the wind at a link (3,) [m/s]."""
        wind = self._wind
        x, y, z = wind.velocity
        self._speed = _risen(self._speed, math.hypot(x, y), period, wind.rise)
        self._vertical = _risen(self._vertical, z, period, wind.vertical_rise)
        towards = math.degrees(math.atan2(y, x))
        self._direction = _risen(self._direction, towards, period, wind.turn)
        gust = wind.gusts * math.sin(2.0 * math.pi * time / wind.gust_period)
        sway = wind.sway * math.sin(2.0 * math.pi * time / wind.sway_period)
        speed = self._speed * (1.0 + gust) + self._noise(0)
        angle = math.radians(self._direction + sway + self._noise(1))
        height = self._vertical + self._noise(2)
        return np.array((speed * math.cos(angle), speed * math.sin(angle), height))

    def _noise(self, number: int) -> float:
        mean, deviation = self._wind.noise[number]
        return mean + deviation * float(self._rng.normal()) if deviation else mean


def _risen(mean: float, value: float, period: float, rise: float) -> float:
    share = period / rise
    return (1.0 - share) * mean + share * value

"""Races between drivers: opponents by pure pursuit, results."""

import numpy as np
from deepracer_control.drivers.pursuit import Path, Pursuit

from paddock_gym.course import LAP
from paddock_gym.evaluation.laps import FIRST_SEED, follow

SPACING = 0.05  # of the points of a line along the lane [m]


class Avoiding:
    """Pure pursuit that passes slower cars ahead: a driver of one car of a RaceEnv.

    Args:
        task: Race of the car.
        max_speed: on straights [m/s].
        aside: of the lane's half width, by which it passes.
        sight, clear: it passes from this distance behind to that in front of the other [m].
    """

    def __init__(self, task, max_speed=1.5, aside=0.75, sight=2.0, clear=1.0):
        self._task, self._max_speed = task, max_speed
        self._clear, self._sight, self._line = clear, sight, 0
        course = task.course
        along = np.arange(0.0, course.length, SPACING)
        left, right = course.sides(along)
        self._lines = [
            Pursuit(
                Path([course.pose(*row)[:2] for row in zip(along, offsets)], closed=True),
                max_speed=max_speed,
            )
            for offsets in (0.0 * left, -aside * right, aside * left)
        ]

    def act(self, _observation=None):
        """The action at the car's pose."""
        ahead, lateral, speed = self._task.rival()
        is_near = (-self._clear if self._line else 0.0) < ahead < self._sight
        if not (is_near and speed < self._max_speed):
            self._line = 0
        elif not self._line:
            self._line = 1 if lateral > 0.0 else 2  # where there is more room
        return follow(self._lines[self._line], self._task.car.motion(), self._task.actions)


def race(env, drivers, count, seed=FIRST_SEED):
    """Drive races.

    Args:
        env: RaceEnv.
        drivers: name of a car -> function of its observation that gives its action.
        count: how many races; their seeds follow each other.

    Returns:
        name -> how each run ended; of the winner: lap.
    """
    ends = {name: [] for name in drivers}
    for number in range(count):
        seen, infos = env.reset(seed=seed + number)
        last = {}
        while env.agents:
            actions = {name: drivers[name](seen[name]) for name in env.agents}
            seen, _, _, _, infos = env.step(actions)
            last.update(infos)
        for name, rows in ends.items():
            rows.append(last[name]["end"])
    return ends


def wins(ends):
    """How many of the races of race() each has won, by its lap."""
    return {name: rows.count(LAP) for name, rows in ends.items()}

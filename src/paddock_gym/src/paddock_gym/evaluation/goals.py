"""Drives of the Cyber Truck to goals, by the controller of cybertruck's node `goal`."""

import math
from dataclasses import dataclass

import numpy as np
from cybertruck.goal.controller import ACTIVE, REACHED, GoalController
from cybertruck.goal.settings import GoalSettings

from paddock_gym.simulation.truck import DRIVE_PERIOD, Truck

FIRST_SEED = 20_000  # of the goals
MIN_DISTANCE, MAX_DISTANCE = 1.0, 8.0  # [m]
TIME_LIMIT = 60.0  # simulated time of a drive [s]
PERIODS = 2  # of the drive node for each command of the controller


@dataclass(frozen=True)
class Drive:
    """One goal.

    Attributes:
        end: reached, stuck or late.
        time: simulated [s].
        detour: length of the driven path over that of the shortest one.
        distance: to the goal at the end [m].
    """

    end: str
    time: float
    detour: float
    distance: float

    @property
    def is_good(self):
        """Whether it was reached."""
        return self.end == REACHED


def goals(count, seed=FIRST_SEED):
    """(x, y) [m] of goals around the truck, in all directions."""
    rng = np.random.default_rng(seed)
    return [
        (distance * math.cos(direction), distance * math.sin(direction))
        for distance, direction in zip(
            rng.uniform(MIN_DISTANCE, MAX_DISTANCE, count), rng.uniform(-math.pi, math.pi, count)
        )
    ]


def drive_all(targets, trailer=False, **gains):
    """Drive from the origin to each goal.

    Args:
        targets: of goals().

    Returns:
        Drives.

    Raises:
        ValueError: a gain is wrong.
    """
    settings = GoalSettings(trailer=trailer, **gains)
    truck, rest = Truck.settled(trailer)
    try:
        return [drive(truck, rest, settings, target) for target in targets]
    finally:
        truck.close()


def drive(truck, rest, settings, target):
    """Drive once from a state of rest; returns the Drive."""
    truck.restore(rest)
    truck.place_truck(0.0, 0.0, 0.0)
    controller = GoalController(settings)
    controller.start(*target)
    time, state = 0.0, ACTIVE
    while True:
        state, linear, angular = controller.update(*truck.rear_axle_pose(), time)
        if state != ACTIVE or time > TIME_LIMIT:
            break
        steering = math.atan(settings.wheelbase * angular / linear) if linear > 1e-6 else 0.0
        truck.drive(steering, linear, PERIODS)
        time += PERIODS * DRIVE_PERIOD
    return Drive(
        "late" if state == ACTIVE else state,
        time,
        controller.driven / max(controller.shortest, 1e-6),
        controller.distance,
    )

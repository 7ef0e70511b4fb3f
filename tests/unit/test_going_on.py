"""DeepRacer and truck with trailer go on from a saved state as if they had never stopped."""

import math

import numpy as np
import pytest
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from paddock_gym.simulation import description, truck
from paddock_gym.simulation.car import Car

STEP, PERIOD = 0.002, 0.02  # [s] of physics, between commands
PERIODS = round(4.0 / PERIOD)  # 5 s with those before: what stands has gone to sleep by then


class DeepRacer:
    """The car on a plane, driven in curves or left alone."""

    def __init__(self):
        self.world = World(STEP)
        self.world.spawn(sdf.ground_plane())
        self.car = Car(self.world, "car", Pose((0.0, 0.0, 0.05)), description.car_urdf())

    def command(self, number, moves):
        """Command speed and steering for the period of a number."""
        speed, steering = 1.5 * moves, 0.3 * moves * math.sin(0.05 * number)
        self.car.drive(speed, steering)


class Truck:
    """Truck and trailer on a plane, driven in curves or left alone.

    Without the limits of the drive node, which is not part of the world.
    """

    def __init__(self):
        self.truck = truck.Truck()
        self.world = self.truck.world

    def command(self, number, moves):
        """Command speed and steering for the period of a number."""
        self.truck._write(0.2 * moves * math.sin(0.02 * number), 1.0 * moves)


def trace(robot, moves, start, periods=PERIODS):
    """All that can be measured of all links, after each period."""
    found, world = [], robot.world
    for number in range(start, start + periods):
        robot.command(number, moves)
        world.step(round(PERIOD / STEP))
        parts = []
        for model in world.models.values():
            for part in model.rigid_parts:
                parts += model.body.link_motion(part)
            parts += [] if model.is_static else model.joints.arrays()
        found.append(np.hstack([np.ravel(part) for part in parts]).tobytes())
    return found


def difference(one, other):
    """Number of the first period after which two traces differ, or None."""
    return next((n for n, pair in enumerate(zip(one, other)) if pair[0] != pair[1]), None)


@pytest.mark.parametrize("make", [DeepRacer, Truck])
@pytest.mark.parametrize("moves", [1.0, 0.0], ids=["driving", "standing"])
def test_four_seconds_after_a_saved_state_are_those_of_a_run_without(make, moves):
    never = make()
    trace(never, moves, 0, 50)
    expected = trace(never, moves, 50)
    never.world.close()
    robot = make()
    trace(robot, moves, 0, 50)
    state = robot.world.save_state()
    trace(robot, 1.0 - 2.0 * moves, 0, 40)  # somewhere else, with other commands
    assert robot.world.restore_state(state) == ""
    assert difference(trace(robot, moves, 50), expected) is None
    robot.world.close()

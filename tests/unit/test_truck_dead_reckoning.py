"""Wheel odometry ends where the simulated truck is: there and back, circles, slaloms, backwards."""

import math

import numpy as np
import pytest
from cybertruck.drive.odometry import WheelOdometry
from cybertruck.goal.controller import GoalController
from cybertruck.goal.settings import GoalSettings
from test_cybertruck_physics import alone, train, trucks  # noqa: F401

MAX_ERROR = 0.1  # [m] after 32 m
MAX_TURN_ERROR = math.radians(1.0)
WAY = 32.0  # [m]
REST = 1.0  # [s] in which the truck stops after a drive


class Reckoning:
    """A truck and its wheel odometry, as the drive node keeps it.

    Args:
        truck: Truck, settled.

    Attributes:
        odometry: WheelOdometry.
        way: Distance driven [m].
    """

    def __init__(self, truck):
        self._truck, self.way = truck, 0.0
        self.odometry = WheelOdometry(truck.kinematics, (*truck.position[:2], truck.yaw))
        self.odometry.update(truck.measured())

    def drive(self, steering, speed, seconds):
        """Drives with a steering angle [rad] and a speed [m/s] for a time [s]."""
        last = self._truck.position

        def look():
            nonlocal last
            self.odometry.update(self._truck.measured())
            position = self._truck.position
            self.way += np.linalg.norm(position - last)
            last = position

        self._truck.drive(steering, speed, seconds, look)

    def errors(self):
        """Distance [m] and angle [rad] between odometry and truth."""
        odometry, (x, y, _) = self.odometry, self._truck.position
        turned = math.remainder(odometry.yaw - self._truck.yaw, 2.0 * math.pi)
        return math.hypot(odometry.x - x, odometry.y - y), abs(turned)

    def check(self):
        """The errors are within the limits, and within three standard deviations."""
        error, turned = self.errors()
        print(f"{self.way:.1f} m: {error:.3f} m, {math.degrees(turned):.2f} deg")
        assert error < MAX_ERROR
        assert turned < MAX_TURN_ERROR
        covariance = self.odometry.covariance
        assert turned < 3 * math.sqrt(covariance[2, 2])
        assert error < 3 * math.sqrt(np.linalg.eigvalsh(covariance[:2, :2]).max())


def test_there_and_back(train):  # noqa: F811
    """By the goal controller, from (0, 0) to (10, 10) and back to (0, 0)."""
    truck = train
    reckoning = Reckoning(truck)
    controller = GoalController(GoalSettings(trailer=True))
    odometry, period = reckoning.odometry, 8 * truck.world.time_step
    for goal in ((10.0, 10.0), (0.0, 0.0)):
        controller.start(*goal)
        while True:
            linear, angular = controller.update(
                odometry.x, odometry.y, odometry.yaw, truck.world.time
            )[1:]
            if controller.goal is None:
                break
            reckoning.drive(*truck.kinematics.from_twist(linear, angular), period)
        reckoning.drive(truck.limiter.steering, 0.0, REST)
        assert math.dist(goal, truck.position[:2]) < 0.15
    assert reckoning.way > 30.0
    reckoning.check()


def circle(degrees):
    """A circle; positive to the left."""
    return lambda _: math.radians(degrees)


def slalom(degrees, period):
    """A sine of the steering angle with a period [s]."""
    return lambda time: math.radians(degrees) * math.sin(2.0 * math.pi * time / period)


def eight(degrees, period):
    """Circles to both sides in turn, the side changes after each half period [s]."""
    return lambda time: math.radians(degrees if time % period < period / 2.0 else -degrees)


FIGURES = {
    "circle to the left": (circle(20.0), 0.8),
    "circle to the right": (circle(-28.0), 1.0),
    "slalom": (slalom(25.0, 4.0), 1.0),
    "fast slalom": (slalom(8.0, 2.0), 1.5),
    "eight backwards": (eight(20.0, 32.0), -0.5),
}
FORWARD = [name for name, (_, speed) in FIGURES.items() if speed > 0.0]


@pytest.mark.parametrize("name", ["circle to the right", "fast slalom"])
def test_figures(alone, name):  # noqa: F811
    """./run test long drives them all, and with the trailer."""
    check_figure(alone, name)


def check_figure(truck, name):
    """Drives a figure of FIGURES for 32 m; the odometry stays with the truck."""
    steering, speed = FIGURES[name]
    reckoning, held = Reckoning(truck), 0.04  # [s] for which a command is held
    for number in range(round(WAY / abs(speed) / held)):
        reckoning.drive(steering(number * held), speed, held)
    reckoning.drive(truck.limiter.steering, 0.0, REST)
    assert reckoning.way == pytest.approx(WAY, rel=0.02)
    reckoning.check()

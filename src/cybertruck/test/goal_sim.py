"""A kinematic truck with trailer for the goal controller's tests: lags, limits, hitch angle."""

import math
from dataclasses import dataclass, field

PERIOD = 0.008  # of odometry [s]


@dataclass
class Truck:
    """Bicycle with a drive node's limits: steering rate, acceleration, full lock.

    Attributes:
        x, y: Rear axle's center [m].
        heading: [rad].
        hitch: Trailer heading minus truck heading [rad].
    """

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    hitch: float = 0.0
    speed: float = 0.0
    steering: float = 0.0
    time: float = 0.0
    path: float = 0.0
    wheelbase: float = 0.508
    max_steering: float = 0.7854
    steering_rate: float = 2.5
    acceleration: float = 2.0
    widest_hitch: float = 0.0
    tightest: float = 0.0
    trace: list = field(default_factory=list)

    def step(self, linear, angular):
        """Drives for PERIOD towards a commanded Twist."""
        target = math.atan(angular / linear * self.wheelbase) if abs(linear) > 1e-9 else 0.0
        target = min(max(target, -self.max_steering), self.max_steering)
        max_change = self.steering_rate * PERIOD
        self.steering += min(max(target - self.steering, -max_change), max_change)
        max_change = self.acceleration * PERIOD
        self.speed += min(max(linear - self.speed, -max_change), max_change)
        curvature = math.tan(self.steering) / self.wheelbase
        self.tightest = max(self.tightest, abs(curvature))
        middle = self.heading + 0.5 * self.speed * curvature * PERIOD
        self.x += self.speed * math.cos(middle) * PERIOD
        self.y += self.speed * math.sin(middle) * PERIOD
        self.heading += self.speed * curvature * PERIOD
        self.hitch -= (
            self.speed
            * PERIOD
            * (math.sin(self.hitch) / 0.70 + (0.30 / 0.70 * math.cos(self.hitch) + 1.0) * curvature)
        )
        self.widest_hitch = max(self.widest_hitch, abs(self.hitch))
        self.path += abs(self.speed) * PERIOD
        self.time += PERIOD
        self.trace.append((self.x, self.y))


@dataclass
class Run:
    """Result of a drive to a goal."""

    state: str
    error: float  # distance to the goal at the end [m]
    path: float  # [m]
    shortest: float  # [m]
    sign_changes: int  # of the heading error, beyond one degree
    time: float  # [s]


def drive(controller, truck, goal, limit=120.0) -> Run:
    """Drives a truck to a goal.

    Args:
        truck: Truck, moved.
        goal: (x, y) [m].
        limit: Longest drive [s].
    """
    controller.start(*goal)
    start_time, path_before = truck.time, truck.path
    sign, changes, state = 0, 0, "none"
    while truck.time - start_time < limit:
        update = controller.update(truck.x, truck.y, truck.heading, truck.time)
        state = update[0]
        error = math.remainder(
            math.atan2(goal[1] - truck.y, goal[0] - truck.x) - truck.heading, 2.0 * math.pi
        )
        if state == "active" and abs(error) > math.radians(1.0):
            now = 1 if error > 0.0 else -1
            changes += bool(sign and now != sign)
            sign = now
        if state != "active":
            break
        truck.step(*update[1:])
    while abs(truck.speed) > 1e-6:
        truck.step(0.0, 0.0)
    return Run(
        state,
        math.hypot(goal[0] - truck.x, goal[1] - truck.y),
        truck.path - path_before,
        controller.shortest,
        changes,
        truck.time - start_time,
    )

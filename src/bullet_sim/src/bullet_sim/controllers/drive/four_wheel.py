"""The controller of a base with four driven and steered wheels."""

import collections
import math

from bullet_sim.controllers.drive import four_wheel_geometry as geometry
from bullet_sim.controllers.drive.controllers import Drive
from bullet_sim.controllers.drive.odometry import MAX_ARC, MIN_PERIOD


class FourWheelOdometry:
    """Pose in the plane, velocity, and what odom_steer reports.

    Args:
        window: number of periods over which the rates are averaged.

    Attributes:
        x, y [m], heading [rad]: as Odometry's.
        linear, lateral [m/s], angular [rad/s]: in the robot's own frame, of the last period.
        speed: forward or backwards [m/s]; acceleration [m/s^2], jerk [m/s^3]: its means.
        angles: of the virtual front and rear wheel [rad]; rates: their means [rad/s].
    """

    def __init__(self, window=10):
        self._rates = [collections.deque(maxlen=max(1, window)) for _ in range(4)]
        self.reset()

    def reset(self, _time=0.0):
        """Back to the origin, at rest."""
        self.x = self.y = self.heading = 0.0
        self.start()

    def start(self, _time=0.0):
        """Continue from the present pose, at rest."""
        self.linear = self.lateral = self.angular = self.speed = 0.0
        self.acceleration = self.jerk = 0.0
        self.angles, self.rates = (0.0, 0.0), (0.0, 0.0)
        for rates in self._rates:
            rates.clear()

    def move(self, motion, angles, period):
        """Add a period [s] with a motion (as body_motion gives it) and steering angles [rad].

        A motion that is NaN or further than any wheel can travel is ignored.
        """
        if not all(abs(value) * period <= MAX_ARC for value in motion):
            return
        self.linear, self.lateral, self.angular = motion
        heading = self.heading + self.angular * period / 2.0
        cos, sin = math.cos(heading), math.sin(heading)
        self.x += (self.linear * cos - self.lateral * sin) * period
        self.y += (self.linear * sin + self.lateral * cos) * period
        self.heading += self.angular * period
        speed = math.copysign(math.hypot(self.linear, self.lateral), self.linear)
        acceleration = self._mean(0, (speed - self.speed) / period)
        self.jerk = self._mean(1, (acceleration - self.acceleration) / period)
        self.rates = tuple(
            self._mean(2 + n, (angles[n] - self.angles[n]) / period) for n in range(2)
        )
        self.speed, self.acceleration, self.angles = speed, acceleration, angles

    def _mean(self, number, value):
        rates = self._rates[number]
        rates.append(value)
        return math.fsum(rates) / len(rates)


class FourWheel(Drive):
    """Commands are (forward [m/s], turn [rad/s]) or (speed [m/s], front, rear angle [rad])."""

    def __init__(self, spec, hardware):
        super().__init__(spec, hardware)
        self.odometry = FourWheelOdometry(spec.drive.window)

    def update(self, state, time, period):
        """Odometry, then wheels and steering within the limits."""
        self.observe(state, time)
        drive = self.spec.drive
        wanted = self._wanted if self._age <= drive.timeout else (0.0,) * len(self._wanted)
        self._age += period
        forward = drive.linear.limit(wanted[0], self.limited[0], self._before[0], period)
        turn = self.limited[1]
        if len(wanted) == 2:
            turn = drive.angular.limit(wanted[1], turn, self._before[1], period)
            outputs = geometry.for_twist(drive, forward, turn)
        else:
            outputs = geometry.for_angles(drive, forward, *wanted[1:])
        self._before, self.limited = self.limited, (forward, turn)
        self._write_once(outputs)

    def observe(self, state, time):
        """Update the odometry to a state."""
        period = time - self._time
        if period < MIN_PERIOD:
            return
        drive, positions = self.spec.drive, state[0]
        speeds = [(positions[name] - self._positions[name]) / period for name in drive.wheels]
        angles = [positions[name] for name in drive.steers]
        front, rear = (geometry.middle_angle(*pair) for pair in (angles[:2], angles[2:]))
        self._positions = {name: positions[name] for name in drive.wheels}
        self._time = time
        motion = geometry.body_motion(drive, speeds, front, rear)
        self.odometry.move(motion, (front, rear), period)

    def _outputs(self, forward, turn):
        return geometry.for_twist(self.spec.drive, forward, turn)

    def _write(self, outputs):
        self.hardware.velocities(self.spec.drive.wheels, outputs[0])
        self.hardware.positions(self.spec.drive.steers, outputs[1])
